// What the robot saw, drawn over its picture: boxes in shares of the picture, only while they belong to what is shown.
(() => {
  "use strict";
  const NS = "http://www.w3.org/2000/svg";
  const NEAR_MS = 300; // at 0.5 m/s a box of another moment lies 15 cm beside the plant: then it is pale
  const PLANTS = new Set(["weed", "crop"]);
  const LEAST_PX = 6;
  const APART_MS = 900; // they come twice a second; what is older than the next one is none of this picture

  const svg = (tag, attributes, ...children) => {
    const node = document.createElementNS(NS, tag);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    node.append(...children);
    return node;
  };

  // the part of the node that the picture fills when it is fitted into it whole, or (isCover) fills it and is cut off
  function fitted(node, width, height, isCover) {
    const scale = (isCover ? Math.max : Math.min)(node.clientWidth / width, node.clientHeight / height);
    const [w, h] = [width * scale, height * scale];
    return { left: (node.clientWidth - w) / 2, top: (node.clientHeight - h) / 2, width: w, height: h };
  }

  class Detections {
    constructor(viewer, { isCover = () => false } = {}) {
      this.viewer = viewer;
      this.isCover = isCover;
      this.node = svg("svg", { class: "c-boxes", "aria-hidden": "true" });
      this.count = 0;
    }
    // of this camera in the lane's group `detections`; null while nothing was said of its pictures
    of(group) {
      return group ? [group, ...(group.others ?? [])].find((one) => one.camera === this.viewer.camera) ?? null : null;
    }
    paint(group, isOn) {
      const { viewer } = this;
      const found = this.of(group);
      const apartMs = found && viewer.sight && viewer.sight.captured !== null ? Math.abs(viewer.sight.captured - found.t) : Infinity;
      const boxes = isOn && apartMs <= APART_MS && viewer.judged?.state === "live" ? found.boxes : [];
      HL.toggle(this.node, "pale", apartMs > NEAR_MS);
      this.count = boxes.length;
      const place = viewer.width ? fitted(viewer.node, viewer.width, viewer.height, this.isCover()) : null;
      const key = place && JSON.stringify([boxes, place]);
      if (key === this.key) return;
      this.key = key;
      this.node.replaceChildren(...(place ? boxes.map((box) => this.box(box, place)) : []));
    }
    box({ x, y, w, h, kind = "", hit = null }, place) {
      const [left, top] = [place.left + x * place.width, place.top + y * place.height];
      const [width, height] = [Math.max(4, w * place.width), Math.max(4, h * place.height)];
      if (PLANTS.has(kind)) return this.plant(left + width / 2, top + height / 2, Math.max(LEAST_PX, Math.hypot(width, height) / 2), kind, hit);
      const rect = svg("rect", { x: left, y: top, width, height, rx: 2 });
      const text = svg("text", { x: left, y: Math.max(12, top - 4) });
      text.textContent = kind.replaceAll("_", " ").replaceAll("-", " ");
      return svg("g", { class: `k-${kind}` }, rect, text);
    }
    // dozens of plants are in a picture: a ring each, with cross hairs where the laser hit and broken where it missed
    plant(x, y, r, kind, hit) {
      const ring = svg("circle", { cx: x, cy: y, r });
      const hairs = hit ? [[-1, 0], [1, 0], [0, -1], [0, 1]].map(([dx, dy]) => svg("path", { d: `M${x + dx * (r - 3)} ${y + dy * (r - 3)}L${x + dx * (r + 4)} ${y + dy * (r + 4)}` })) : [];
      return svg("g", { class: `k-${kind}${hit === false ? " missed" : ""}` }, ring, ...hairs);
    }
  }

  Object.assign(HL.camera, { Detections });
})();
