// Export: what a format cannot carry is said before the file is taken.
(() => {
  "use strict";
  const { el } = HL;
  const M = HL.maps;
  const SHOWN = 200;

  const save = (path) => {
    const link = el("a", { href: path, download: "" });
    document.body.append(link);
    link.click();
    link.remove();
  };

  const exportPath = (format, of) => `${HL.config.apiPath}/map/export?format=${format}&of=${of}`;

  // format: [name, word]; of: "draft" or "published"
  async function exportMap([format, word], of) {
    const path = exportPath(format, of);
    const answer = await HL.port.api("GET", `/map/export/losses?format=${format}&of=${of}`, null, 30000);
    if (!answer.ok) return HL.toast(`Not exported: ${answer.text || "the server did not answer"}`, "block");
    const lost = [...(answer.left_out ?? []), ...(answer.cut ?? [])];
    if (!lost.length) return save(path);
    const list = el("ol", { class: "m-log", "data-testid": "export-losses" }, ...lost.slice(0, SHOWN).map((one) => el("li", {}, one)));
    const more = lost.length > SHOWN ? [el("p", { class: "h-t14 h-2" }, `and ${lost.length - SHOWN} more`)] : [];
    const head = el("p", { class: "h-t16" }, `${word} has no place for ${M.count(lost.length, "thing")} of this map. GeoJSON carries everything.`);
    return HL.sheet({ title: `${word} leaves something out`, hook: "export-lossy", body: [head, list, ...more], buttons: [["Cancel", (close) => close()], ["Export without", (close) => (close(), save(path)), true]] });
  }

  Object.assign(M, { exportMap, exportPath });
})();
