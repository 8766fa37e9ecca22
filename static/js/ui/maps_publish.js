// Publishing and discarding a draft: both ask once, publishing a much smaller map asks again with numbers.
(() => {
  "use strict";
  const { el, text, attr } = HL;
  const M = HL.maps;

  const parcelArea = (features) => [...features.values()].filter((one) => M.kindOf(one) === "parcel").reduce((sum, one) => sum + (M.areaM2(one) ?? 0), 0);

  // "Dijkveld: soil set to Clay": for the others a change says of what it is
  function noted(one) {
    const names = one.names ?? one.changes?.map(({ before, after }) => (before ?? after)?.properties?.name) ?? [];
    return names.length !== 1 || !names[0] || one.label.includes(names[0]) ? one.label : `${names[0]}: ${one.label[0].toLowerCase()}${one.label.slice(1)}`;
  }

  function usualNote(log) {
    const done = log.filter((one) => !one.is_undone);
    if (!done.length) return "";
    return done.length === 1 ? noted(done[0]) : `${noted(done[0])}, and ${done.length - 1} more`;
  }

  // done(version) after the server took it; checked(findings) when it found what blocks
  function askPublish(client, { done, checked }) {
    const version = client.nextVersion;
    const note = el("input", { class: "h-input", maxlength: "200", autofocus: true, autocomplete: "off", "data-testid": "publish-note" });
    note.value = usualNote([...(client.draft?.log ?? []), ...client.queue.items]);
    const said = el("p", { class: "h-error", role: "alert", "data-testid": "publish-error" });
    const go = el("button", { type: "button", class: "h-btn pri", "data-testid": "publish-go", onclick: () => publish(false) }, `Publish v${version}`);
    const close = HL.sheet({
      title: `Publish v${version}`,
      hook: "publish",
      body: [el("label", { class: "h-field" }, "What changed, for the others", note), el("p", { class: "h-t14 h-2" }, "New missions are planned on it. Running missions keep their map."), said, el("div", { class: "foot" }, el("button", { type: "button", class: "h-btn", onclick: () => close() }, "Not yet"), go)],
    });
    note.addEventListener("keydown", (event) => event.key === "Enter" && go.click());

    async function publish(isShrinkingOk) {
      attr(go, "disabled", true);
      text(said, "");
      const words = note.value.trim();
      const answer = await client.publish(words, isShrinkingOk);
      attr(go, "disabled", null);
      if (answer.ok) return close(), done(answer.version ?? version);
      if (answer.code === "shrinks") return close(), askShrinking(client, answer, words, { done, checked });
      if (answer.findings) checked(answer);
      return text(said, `Not published: ${answer.text || "the server did not answer. Look at the versions before you try again."}`);
    }
  }

  function askShrinking(client, answer, note, { done }) {
    const [was, is] = [client.base, client.features];
    const line = (word, from, to) => el("li", {}, el("span", {}, word), el("b", {}, `${from} to ${to}`));
    const facts = el("ol", { class: "m-log", "data-testid": "publish-shrinks" }, line("Shapes", was.size, is.size), line("Parcels", M.words(M.area(parcelArea(was))), M.words(M.area(parcelArea(is)))));
    const again = async (close) => {
      close();
      const reply = await client.publish(note, true);
      if (reply.ok) done(reply.version ?? client.baseVersion);
      else HL.toast(`Not published: ${reply.text || "no answer"}`, "block");
    };
    HL.sheet({ title: "The map gets much smaller", hook: "publish-smaller", body: [el("p", { class: "h-t16" }, answer.text), facts], buttons: [["Not yet", (close) => close()], ["Publish it so", again, true]] });
  }

  function askDiscard(client, done) {
    const changes = (client.draft?.log ?? []).filter((one) => !one.is_undone).length + client.queue.length;
    const stays = client.baseVersion ? `v${client.baseVersion} stays as it is.` : "There is no published map yet.";
    const really = async (close) => {
      close();
      const answer = await client.discard();
      if (answer.ok) done();
      else HL.toast(`Not discarded: ${answer.text || "no answer"}`, "block");
    };
    HL.sheet({ title: "Discard this draft?", hook: "discard", body: [el("p", { class: "h-t16" }, changes ? `${M.count(changes, "change")} of it are lost and cannot be brought back.`.replace("1 change of it are", "1 change of it is") : "Nothing in it was changed."), el("p", { class: "h-t14 h-2" }, stays)], buttons: [["Keep it", (close) => close()], ["Discard draft", really, true]] });
  }

  Object.assign(HL.maps, { askPublish, askDiscard });
})();
