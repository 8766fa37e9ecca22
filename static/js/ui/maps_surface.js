// The drawing surface: fetched when it is shown, made anew when the right to draw changes, and fed with changes.
(() => {
  "use strict";
  const { el, icon } = HL;
  const sheets = new Map();

  function loadSheet(href) {
    if (!sheets.has(href)) {
      sheets.set(href, new Promise((resolve, reject) => {
        const link = el("link", { rel: "stylesheet", href });
        link.onload = resolve;
        link.onerror = () => { sheets.delete(href); link.remove(); reject(new Error(`no style sheet ${href}`)); };
        document.head.append(link);
      }));
    }
    return sheets.get(href);
  }

  class Surface {
    // address: {scripts, vendor}; on: what the editor tells
    constructor(address, on) {
      this.address = address;
      this.on = on;
      this.node = el("div", { class: "m-surface" });
      this.editor = null;
      this.isReadOnly = null;
    }

    // looks at some features; they stay in view when drawing begins
    fit(ids) {
      this.focus = ids;
      this.editor?.fit(ids);
    }

    // shows what on.features() gives; a later call wins over an earlier one that is still loading
    async show(isReadOnly) {
      if (this.isReadOnly === isReadOnly) return this.editor?.setFeatures(this.on.features());
      this.isReadOnly = isReadOnly;
      this.turn = (this.turn ?? 0) + 1;
      const { turn } = this;
      this.editor?.destroy();
      this.editor = null;
      const host = el("div", { class: "m-host", "data-testid": "map-editor" });
      const wait = el("div", { class: "m-notice", role: "status", "data-testid": "surface-loading" }, el("div", { class: "h-card h-skeleton m-loading" }, el("span", { class: "h-t14 h-2" }, "Drawing the map"), el("i"), el("i"), el("i")));
      this.node.replaceChildren(host, wait);
      try {
        const base = window.path_prefix ?? "";
        const { scripts, vendor } = this.address;
        const [{ MapEditor }] = await Promise.all([import(`${base}${scripts}/editor/map_editor.js`), loadSheet(`${base}${scripts}/map/map.css`), loadSheet(`${base}${scripts}/editor/editor.css`), loadSheet(`${base}${vendor}/maplibre-gl-core.css`)]);
        if (turn !== this.turn) return undefined;
        const editor = new MapEditor(host, { vendorUrl: `${base}${vendor}`, baseMapsUrl: `${HL.config.apiPath}/base-maps`, readOnly: isReadOnly, ...this.on });
        await editor.start();
        if (turn !== this.turn) return editor.destroy();
        this.editor = editor;
        const features = this.on.features();
        editor.setFeatures(features);
        editor.fit(this.focus ?? null);
        if (!features.length) this.fitRobots(turn);
        this.on.onReady();
        const drawn = () => (turn !== this.turn || editor.isDrawn ? wait.remove() : requestAnimationFrame(drawn));
        drawn();
      } catch (error) {
        console.error("map builder:", error);
        if (turn === this.turn) this.fail();
      }
      return undefined;
    }

    // nothing is drawn yet: a field as drawn on half a continent would be larger than any
    async fitRobots(turn) {
      const answer = await HL.port.api("GET", "/robots");
      if (turn === this.turn && answer.ok && !this.on.features().length) this.editor?.fit(HL.maps.groundAround(answer.robots ?? []));
    }

    fail() {
      this.isReadOnly = null;
      this.node.replaceChildren(el("div", { class: "h-card h-notice", role: "alert", "data-testid": "surface-error" }, icon("cloud_off", "l"), el("b", { class: "h-t18 h-b" }, "The map did not start"), el("span", { class: "h-2" }, "Its scripts did not load. The draft is kept."), el("button", { type: "button", class: "h-btn", onclick: () => this.show(this.on.isReadOnly()) }, icon("refresh", "m"), "Try again")));
    }

    destroy() {
      this.turn = (this.turn ?? 0) + 1;
      this.editor?.destroy();
      this.editor = null;
      this.isReadOnly = null;
      this.node.replaceChildren();
    }
  }

  Object.assign(HL.maps, { Surface, loadSheet });
})();
