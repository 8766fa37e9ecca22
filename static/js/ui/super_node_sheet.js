// One node: what is known of it, what is wrong, what goes off without it; start, stop and restart by slide.
(() => {
  "use strict";
  const { el, text, attr, toggle, LiveElement, words } = HL;
  const NO_RIGHT = "Restarting nodes needs the admin role.";
  const ACTS = [
    ["restart", "Restart", "refresh", "Slide to restart"],
    ["start", "Start", "play_arrow", "Slide to start"],
    ["stop", "Stop", "block", "Slide to stop"],
  ];

  // why this cannot be asked now; empty when it may be tried
  function refusal(act, node) {
    if (!mayAct()) return NO_RIGHT;
    const off = HL.offline(HL.view.robot);
    if (off) return off;
    if (act === "start" && node.state === "started" && HL.superNodes.heard(node).state !== "stale") return "It is started";
    if (act === "stop" && node.state === "stopped") return "It is stopped";
    return "";
  }

  const effect = (node) => (node.off.length ? `Turns off: ${node.off.join(", ")}` : "No function needs it");

  class NodeSheet extends LiveElement {
    build() {
      this.facts = el("dl", { class: "s-facts" });
      this.findings = el("ul", { class: "s-findings" });
      this.off = el("p", { class: "h-t14 h-2" });
      this.right = el("p", { class: "h-t14 h-2" }, NO_RIGHT);
      this.slides = ACTS.map(([act, label, sign, words]) => [act, new HL.Slide({
        hook: `node-${act}`, icon: sign, label: words, line: "", button: { icon: sign, label }, onopen: (isOpen) => this.focusOn(isOpen ? act : null),
        act: () => HL.port.command(HL.view.robot, `node_${act}`, { node: this.dataset.node }),
      })]);
      this.acts = el("div", { class: "s-acts h-actions" }, ...this.slides.map(([, slide]) => slide.node));
      this.append(this.findings, this.facts, this.off, this.acts, this.right);
    }
    leave() {
      this.slides.forEach(([, slide]) => slide.drop());
    }
    focusOn(chosen) {
      toggle(this.acts, "single", chosen !== null);
      for (const [act, slide] of this.slides) toggle(slide.node, "chosen", act === chosen);
    }
    paint() {
      const node = HL.superNodes.find(this.dataset.node);
      if (!node) return;
      attr(this.acts, "hidden", !mayAct());
      attr(this.right, "hidden", mayAct());
      this.draw(facts(node));
      const found = node.findings.join("|");
      if (found !== this.found) {
        this.found = found;
        this.findings.replaceChildren(...node.findings.map((one) => el("li", {}, HL.icon("warning", "m"), one)));
      }
      text(this.off, node.off.length ? `Needed by: ${node.off.join(", ")}.` : "No function needs it.");
      for (const [act, slide] of this.slides) slide.allow(refusal(act, node), act === "start" ? "The node starts on the robot" : effect(node));
    }
    draw(pairs) {
      const keys = pairs.map(([key]) => key).join();
      if (keys !== this.keys) {
        this.keys = keys;
        this.values = pairs.map(([key]) => [el("dt", {}, key), el("dd", { "data-key": key })]);
        this.facts.replaceChildren(...this.values.flat());
      }
      pairs.forEach(([, value], i) => text(this.values[i][1], value));
    }
  }

  function facts(node) {
    const { heard, lifeWord, rate, number } = HL.superNodes;
    const { ageMs, state } = heard(node);
    const since = node.since === null ? "" : ` for ${words.age(HL.port.age(node.since))}`;
    const after = node.starts_after.map((name) => HL.superNodes.find(name)?.label ?? name).join(", ");
    return [
      ["Life cycle", `${lifeWord(node)}${state === "stale" ? "" : since}`],
      ["Says", node.text || "nothing"],
      ["Rate", `${rate(node.rate_hz)} Hz${node.usual_hz ? `, usual ${rate(node.usual_hz)} Hz` : ""}`],
      ["Load", node.cpu_pct === null ? "not told" : `${number(node.cpu_pct, 1)} % of its computer`],
      ["Heard", state === "missing" ? "never" : `${words.age(ageMs)} ago, told each ${number(node.period_ms / 1000)} s`],
      ["Restarts", number(node.restarts)],
      ["Clock", node.offset_ms === null ? "not told" : `${node.offset_ms > 0 ? "+" : ""}${node.offset_ms.toFixed(0)} ms to the robot's`],
      ["Computer", node.host || "not told"],
      ["Subsystem", node.subsystem || "not told"],
      ["Starts after", after || "nothing"],
    ];
  }

  // "Restart…": which one, what is wrong first; the node's own sheet has the slide
  const RANK = { failure: 0, stopped: 2 };
  const rank = (node) => RANK[node.state] ?? (node.findings.length || HL.superNodes.heard(node).state === "stale" ? 1 : 3);
  const mayAct = () => HL.config.rights.includes("manage_nodes");
  const restart = {
    refusal: () => (mayAct() ? HL.offline(HL.view.robot) : NO_RIGHT),
    open() {
      const nodes = [...(HL.superNodes.all() ?? [])].sort((a, b) => rank(a) - rank(b) || (a.label < b.label ? -1 : 1));
      const why = restart.refusal() || (nodes.length ? "" : "No node is known yet.");
      if (why) return HL.toast(why, "lock");
      const line = (node) => el("button", { type: "button", class: "h-btn s-which", "data-testid": `restart-${node.name}`, onclick: () => (close(), HL.superNodes.open(node.name)) }, HL.superNodes.glyph(node.state), el("span", { class: "h-ell" }, node.label), el("span", { class: "h-t13 h-2 h-ell" }, node.finding || HL.superNodes.lifeWord(node)));
      const close = HL.sheet({ title: "Restart which node?", hook: "restart-sheet", body: [el("div", { class: "s-whichlist" }, ...nodes.map(line))], buttons: [["Leave it", (shut) => shut(), true]] });
      return undefined;
    },
  };

  HL.superDefine("hl-super-node", NodeSheet);
  HL.superRestart = restart;
})();
