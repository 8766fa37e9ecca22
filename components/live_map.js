// NiceGUI element of the live map: loads the map's own modules, and MapLibre only where a map is on screen.

const sheets = new Map();

function loadSheet(url) {
  if (!sheets.has(url)) {
    sheets.set(url, new Promise((resolve, reject) => {
      const link = Object.assign(document.createElement("link"), { rel: "stylesheet", href: url });
      link.onload = resolve;
      link.onerror = () => { sheets.delete(url); link.remove(); reject(new Error(`no style sheet ${url}`)); };
      document.head.append(link);
    }));
  }
  return sheets.get(url);
}

export default {
  template: `<div :data-robots="0"></div>`,
  props: {
    robotId: { type: String, default: null },
    mode: { type: String, default: "robot" },
    hasButtons: { type: Boolean, default: true },
    engine: { type: String, default: "auto" },
    featuresUrl: String,
    missionUrl: String,
    codeUrl: String,
    vendorUrl: String,
  },
  async mounted() {
    await this.$nextTick(); // window.path_prefix is set by then
    await this.begin();
  },
  methods: {
    async begin() {
      const base = window.path_prefix ?? "";
      this.say("Loading map");
      await window.HL?.port?.firstPicture(); // nothing of a map may delay STOP or the values
      if (this.isGone) return;
      try {
        const [code] = await Promise.all([
          import(`${base}${this.codeUrl}/live_map.js`),
          loadSheet(`${base}${this.codeUrl}/map.css`),
          loadSheet(`${base}${this.vendorUrl}/maplibre-gl-core.css`),
        ]);
        if (this.isGone) return;
        this.$el.textContent = "";
        this.show(code, base);
      } catch (error) {
        console.error("map:", error);
        this.fail();
      }
    },
    show({ LiveMap, publish }, base) {
      this.map?.destroy();
      this.map = new LiveMap(this.$el, {
        robotId: this.robotId,
        mode: this.mode,
        hasButtons: this.hasButtons,
        engine: this.engine,
        featuresUrl: base + this.featuresUrl,
        missionUrl: base + this.missionUrl,
        baseMapsUrl: base + this.featuresUrl.replace(/features$/, "base-maps"),
        vendorUrl: base + this.vendorUrl,
        onSelect: (id) => this.$emit("select-robot", id),
      });
      this.code = { LiveMap, publish };
      publish(this.map);
      this.map.start();
    },
    fail() {
      const again = Object.assign(document.createElement("button"), { type: "button", textContent: "Try again" });
      again.style.minHeight = "48px";
      again.addEventListener("click", () => this.begin());
      this.say("Map did not load. ", again);
    },
    say(...words) {
      const card = Object.assign(document.createElement("div"), { className: "h-card" });
      card.style.cssText = "position:absolute;inset:50% auto auto 50%;width:max-content;height:auto;transform:translate(-50%,-50%);padding:12px 16px;font-weight:600"; // the map's own sheet is not there yet
      card.append(...words);
      this.$el.replaceChildren(card);
    },
  },
  watch: {
    robotId() {
      if (this.code) this.show(this.code, window.path_prefix ?? "");
    },
  },
  beforeUnmount() {
    this.isGone = true;
    this.map?.destroy();
    this.code?.publish(null, this.map);
  },
};
