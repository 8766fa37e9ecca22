// One direct stream (WHEP): offer, answer, pictures with their RTP time stamps, and letting go of it at once.
(() => {
  "use strict";
  const ANSWER_MS = 5000;
  const NO_WAY = "No direct way to the camera";
  const open = new Set();

  // what a browser lacks for it; empty when nothing
  function lacking() {
    const hasTimes = "requestVideoFrameCallback" in HTMLVideoElement.prototype; // without it nobody knows which picture is shown
    return typeof RTCPeerConnection === "function" && hasTimes ? "" : "This browser has no direct pictures";
  }

  const headers = (watcher, more) => ({ "X-Headland-CSRF": HL.config.csrf || "", "X-Headland-Watcher": watcher, ...more });

  function preferH264(transceiver) {
    const all = globalThis.RTCRtpReceiver?.getCapabilities?.("video")?.codecs ?? [];
    const first = all.filter((one) => /h264/i.test(one.mimeType));
    if (first.length) transceiver.setCodecPreferences?.([...first, ...all.filter((one) => !first.includes(one))]);
  }

  class Direct {
    // told: {picture(rtp), failed(why)}
    constructor({ robot, camera, watcher, video, told }) {
      Object.assign(this, { robot, camera, watcher, video, told, isClosed: false, session: null });
      open.add(this);
      this.#open().catch((error) => this.#fail(error?.said || NO_WAY));
    }

    async #open() {
      this.peer = new RTCPeerConnection({ iceServers: [] });
      this.peer.ontrack = (event) => this.#show(event);
      this.peer.onconnectionstatechange = () => this.peer.connectionState === "failed" && this.#fail(NO_WAY);
      const transceiver = this.peer.addTransceiver("video", { direction: "recvonly" });
      preferH264(transceiver);
      await this.peer.setLocalDescription(await this.peer.createOffer()); // sent as it is: waiting for candidates costs a second
      const answer = await this.#post(this.peer.localDescription.sdp);
      if (!this.isClosed) await this.peer.setRemoteDescription({ type: "answer", sdp: answer });
    }

    async #post(body) {
      const abort = new AbortController();
      const timer = setTimeout(() => abort.abort(), ANSWER_MS);
      const path = `/cameras/${encodeURIComponent(this.robot)}/${encodeURIComponent(this.camera)}/whep`;
      try {
        const answer = await fetch(HL.config.apiPath + path, { method: "POST", credentials: "same-origin", signal: abort.signal, body, headers: headers(this.watcher, { "Content-Type": "application/sdp", Accept: "application/sdp" }) });
        if (answer.status !== 201) throw Object.assign(new Error("refused"), { said: (await answer.json().catch(() => null))?.text || `The server answered ${answer.status}` });
        this.session = answer.headers.get("Location");
        if (this.isClosed) this.#delete();
        return await answer.text();
      } finally {
        clearTimeout(timer);
      }
    }

    #show({ receiver, track }) {
      if ("jitterBufferTarget" in receiver) receiver.jitterBufferTarget = 0; // a picture is worth less the older it is
      else if ("playoutDelayHint" in receiver) receiver.playoutDelayHint = 0;
      this.video.srcObject = new MediaStream([track]);
      this.video.play().catch(() => {}); // muted pictures may always play; what does not comes as no picture
      const next = (_now, frame) => {
        if (this.isClosed) return;
        this.told.picture(frame.rtpTimestamp ?? null);
        this.video.requestVideoFrameCallback(next);
      };
      this.video.requestVideoFrameCallback(next);
    }

    #fail(why) {
      if (!this.isClosed) this.told.failed(why); // who shows it keeps its last picture, then closes it
    }

    #delete() {
      if (!this.session) return;
      fetch(this.session, { method: "DELETE", credentials: "same-origin", keepalive: true, headers: headers(this.watcher) }).catch(() => {});
      this.session = null;
    }

    close() {
      if (this.isClosed) return;
      this.isClosed = true;
      open.delete(this);
      this.#delete();
      this.peer?.close();
      this.video.srcObject = null;
    }
  }

  window.addEventListener("pagehide", () => [...open].forEach((one) => one.close()));
  Object.assign(HL.camera, { Direct, lacking, directs: open });
})();
