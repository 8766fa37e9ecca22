// A file on its way to the server, with progress and a way to stop it.
(() => {
  "use strict";
  const LIMIT_MS = 180000; // large files over a field radio

  // upload(file, path, onProgress(share 0..1, or null while the server reads), limitMs) -> {answer: Promise, cancel}
  function upload(file, path, onProgress, limitMs = LIMIT_MS) {
    const request = new XMLHttpRequest();
    const answer = new Promise((resolve) => {
      const lost = (text, code) => resolve({ ok: false, status: 0, code, text });
      request.open("POST", `${HL.config.apiPath}${path}${path.includes("?") ? "&" : "?"}name=${encodeURIComponent(file.name)}`);
      request.responseType = "json";
      request.timeout = limitMs;
      request.setRequestHeader("X-Headland-CSRF", HL.config.csrf || "");
      request.setRequestHeader("Content-Type", "application/octet-stream");
      request.upload.onprogress = (event) => event.lengthComputable && onProgress(event.loaded / event.total);
      request.upload.onload = () => onProgress(null);
      request.onload = () => {
        const data = request.response ?? {};
        const ok = request.status >= 200 && request.status < 300;
        resolve({ ...data, ok, status: request.status, text: data.text || (ok ? "" : `The server answered ${request.status}.`) });
      };
      request.onerror = () => lost("The server cannot be reached.", "no_connection");
      request.ontimeout = () => lost("The server did not answer in time.", "no_answer");
      request.onabort = () => lost("Cancelled.", "cancelled");
      request.send(file);
    });
    return { answer, cancel: () => request.abort() };
  }

  HL.maps.upload = upload;
})();
