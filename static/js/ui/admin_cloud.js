// Admin: the link to the cloud. What is so, what waits, how long things take; asked again while somebody looks.
(() => {
  "use strict";
  const { el, icon, text } = HL;
  const { table, empty } = HL.records;
  const EVERY_MS = 2000;
  const SIGNS = { ok: "done", watch: "hourglass_top", bad: "error" };

  const button = (label, onclick, hook, look = "") => el("button", { type: "button", class: `h-btn ${look}`.trim(), "data-testid": hook, onclick }, label);

  function span(seconds) {
    if (seconds === null || seconds === undefined) return "–";
    if (seconds < 60) return `${seconds.toFixed(seconds < 9.95 ? 1 : 0)} s`;
    const minutes = Math.round(seconds / 60);
    if (minutes < 60) return `${minutes} min`;
    if (minutes < 2880) return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, "0")}`;
    return `${Math.round(minutes / 1440)} days`;
  }
  const ms = (seconds) => (seconds === null || seconds === undefined ? "–" : `${Math.round(seconds * 1000)} ms`);
  const size = (bytes) => (bytes < 1e6 ? `${Math.ceil(bytes / 1000)} kB` : `${(bytes / 1e6).toFixed(1)} MB`);
  const clock = (skew) => (skew === null || skew === undefined ? "not known" : skew === 0 ? "agrees with ours within 2 s" : `${Math.abs(skew).toFixed(0)} s ${skew > 0 ? "ahead of" : "behind"} ours`);

  // what holds of every link: its answers, its clock, what went wrong last
  function link(told) {
    const last = told.last_error;
    const rows = [
      ["Answers after", told.delay_s === null ? "–" : `${told.delay_s < 1 ? ms(told.delay_s) : span(told.delay_s)} (median of the last 50)`],
      ["Last answer", told.heard_utc ? HL.records.when(told.heard_utc) : "none yet"], ["Its clock", clock(told.skew_s)],
      ["Last error", last ? `${HL.records.when(last.utc)}: ${last.text}` : "none"],
    ];
    if (told.again_in_s > 0) rows.push(["Asked again", `in ${span(told.again_in_s)}`]);
    return rows;
  }

  const offClock = (told) => (told.clock ? [el("p", { class: "h-row", "data-testid": "clock-off" }, icon("schedule", "m"), el("span", {}, el("b", {}, told.clock), " Times there and here do not fit together. No order depends on it."))] : []);

  // a service beside the broker: how its link is, how long it takes, what went wrong last
  function service(one) {
    const head = el("div", { class: "h-card h-sec", "data-testid": `service-${one.key}`, "data-state": one.state },
      el("div", { class: "h-row" }, icon(SIGNS[one.level], "l"), el("b", { class: "h-t18 h-b" }, one.head), el("span", { class: "h-2" }, one.state === "off" ? "" : `for ${span(one.for_s)}`)),
      el("p", {}, one.text),
      ...(one.why ? [el("p", { class: "h-2" }, one.why)] : []),
      ...(one.mend ? [el("p", {}, el("b", {}, "To do: "), one.mend)] : []), ...offClock(one));
    const title = el("h2", {}, one.name);
    if (one.state === "off") return [title, head];
    const rows = [["Address", one.url], ...link(one), ...one.facts];
    return [title, head, table(["What", "Value"], rows.map((cells) => ({ cells })))];
  }

  class Panel {
    constructor(place) {
      this.place = place;
      this.head = el("div", { class: "h-card h-sec", "data-testid": "cloud-state", role: "status" });
      this.body = el("div", { class: "h-sec" });
      this.error = el("div", { class: "h-error", role: "alert", hidden: true });
      this.services = el("div", { class: "h-sec", "data-testid": "cloud-services" });
      place.append(el("h2", {}, "Cloud"), this.error, this.head, this.body, this.services);
      this.head.append(el("span", { class: "h-2" }, "Loading"));
      this.ask();
    }

    async ask() {
      const answer = await HL.port.api("GET", "/cloud");
      if (!this.head.isConnected) return;
      if (answer.ok) this.draw(answer);
      this.error.hidden = answer.ok;
      text(this.error, answer.ok ? "" : `${answer.text || "The server did not answer."} What is below is old.`);
      setTimeout(() => this.head.isConnected && this.ask(), EVERY_MS);
    }

    draw(told) {
      this.state(told);
      this.services.replaceChildren(...(told.services ?? []).flatMap((one) => service(one)));
      if (told.state === "off") return this.body.replaceChildren(empty("Nothing goes to a cloud", "Robots, STOP and everything on these screens work without one."));
      if (!told.waiting) return this.body.replaceChildren(); // not loaded yet, or settings nothing can be done with
      this.body.replaceChildren(
        el("h2", {}, "Waiting here"), this.waiting(told.waiting, told.counts),
        ...(told.refused ? this.refused(told.refused) : []),
        el("h2", {}, "Delays"), ...this.delays(told),
        ...(told.arrivals ? [el("h2", {}, "Lost on the way"), this.losses(told.arrivals, told.counts)] : []),
        el("h2", {}, "Since the start"), this.counts(told.counts),
        el("h2", {}, "Changes made there"), this.changes(told.map),
        el("h2", {}, "Where"), table(["What", "Value"], [
          ["Broker", told.url], ["Tenant", told.tenant || "the default one"], ["Service path", told.path], ...link(told),
        ].map((cells) => ({ cells }))),
      );
    }

    state(told) {
      this.head.dataset.state = told.state;
      const key = JSON.stringify([told.state, told.why, told.mend, told.can_take_tenant, told.clock]);
      if (this.head.dataset.key !== key) {
        this.head.dataset.key = key;
        this.age = el("span", { class: "h-2" });
        this.head.replaceChildren(...[
          el("div", { class: "h-row" }, icon(SIGNS[told.level], "l"), el("b", { class: "h-t18 h-b" }, told.head), this.age),
          el("p", {}, told.text),
          told.why && el("p", { class: "h-2" }, told.why),
          told.mend && el("p", {}, el("b", {}, "To do: "), told.mend),
          ...offClock(told),
          told.can_take_tenant && el("div", {}, button("Use this tenant", () => this.take(), "cloud-take-tenant")),
        ].filter(Boolean));
      }
      text(this.age, told.for_s === undefined ? "" : `for ${span(told.for_s)}`);
    }

    waiting(waiting, counts) {
      const share = Math.round((100 * waiting.bytes) / waiting.limit_bytes);
      const rows = [
        ["Records not in the cloud yet", el("span", { "data-testid": "cloud-waiting", "data-value": waiting.count }, String(waiting.count))],
        ["Oldest", waiting.oldest_age_s === null ? "–" : el("span", { "data-testid": "cloud-oldest", "data-value": waiting.oldest_age_s }, `${span(waiting.oldest_age_s)} old`)],
        ["Room", `${size(waiting.bytes)} of ${size(waiting.limit_bytes)}, ${share} %`],
        ["Dropped", counts.dropped ? `${counts.dropped}: no room, or too old` : "none"],
      ];
      if (waiting.trouble) rows.push(["Disk", `${waiting.trouble}. New records wait in memory.`]);
      return table(["What", "Value"], rows.map((cells) => ({ cells })));
    }

    // what the cloud would not take: kept here, each with the reason, until it goes up or a person forgets it
    refused({ rows, more, is_sending: isSending }) {
      if (!rows.length) return [];
      return [el("h2", {}, "Refused by the cloud"), table(["What", "Happened", "Refused", "Why", "Kept here"], rows.map((one) => ({ hook: "cloud-refused-row", cells: [
        `${one.type}, ${one.id.split(":").at(-1)}`, one.happened_utc ? HL.records.when(one.happened_utc) : "–", HL.records.when(one.utc), one.why, one.is_kept ? `yes, ${size(one.bytes)}` : "told again when it changes"] }))),
      ...(more ? [el("p", { class: "h-2" }, `${more} more.`)] : []),
      el("div", { class: "h-row" }, button(isSending ? "Sending again" : "Send again", () => this.act("POST", "/cloud/refused/send"), "cloud-refused-send"), button("Forget", () => this.forget(rows.length + more), "cloud-refused-forget"))];
    }

    async act(method, path) {
      const answer = await HL.port.api(method, path, {});
      if (answer.ok) return this.draw(answer);
      this.error.hidden = false;
      return text(this.error, answer.text || "The server did not answer.");
    }

    forget(records) {
      HL.sheet({
        title: records === 1 ? "Forget this record?" : `Forget ${records} records?`,
        body: [el("p", { class: "h-2 h-t16" }, "The cloud will never have what is kept here; this console's own history has it all the same. The rest is told again when it changes.")],
        buttons: [["Cancel", (close) => close()], ["Forget", (close) => { close(); this.act("DELETE", "/cloud/refused"); }, true]],
      });
    }

    delays({ delays: { robot_console, robot_cloud, mission, published_mean_s }, level, heard_utc: heard }) {
      const row = (label, one, hook) => ({ hook, cells: [label, ms(one.mean_s), ms(one.p50_s), ms(one.p99_s), one.count] });
      const isOld = level === "bad" && robot_cloud.count;
      return [
        el("p", { class: "h-2", "data-testid": "cloud-delays-said" }, `How old a robot's report is when it arrives; the newest ${robot_cloud.count || "ones"} count. A published system of this kind took ${ms(published_mean_s)} to its cloud, in the mean.`),
        ...(isOld ? [el("p", { class: "h-b", "data-testid": "cloud-delays-old" }, `Nothing arrives in the cloud now: these are from before ${heard ? HL.records.when(heard) : "it was away"}.`)] : []),
        table(["From, to", "Mean", "Median", "99 of 100 below", "Times measured"], [
          row("Robot to console", robot_console, "cloud-delay-console"),
          row("Robot to cloud", robot_cloud, "cloud-delay-cloud"),
          row("Mission through the cloud, until the robot has it", mission, "cloud-delay-mission"),
        ]),
      ];
    }

    // robot to console by the numbers robots give their messages, robot to cloud by what could not be kept here
    losses(heard, counts) {
      const share = (one) => (one.lost_share ? ` (${(100 * one.lost_share).toFixed(one.lost_share < 0.01 ? 2 : 1)} %)` : "");
      const lost = (one) => `${one.lost - one.late}${share(one)}`;
      const kinds = (one) => Object.entries(one.kinds).filter(([, kind]) => kind.lost > kind.late).map(([name, kind]) => `${name} ${kind.lost - kind.late}`).join(", ");
      const row = (label, one, which, hook) => ({ hook, cells: [label, one.received, el("span", { "data-testid": `${hook}-lost`, "data-value": one.lost - one.late }, lost(one)), one.twice, one.out_of_order, one.lost_utc ? HL.records.when(one.lost_utc) : "–", which] });
      const silent = heard.not_numbered ? `${heard.not_numbered} of ${heard.numbered + heard.not_numbered} robots do not number their messages: theirs are not counted.` : "";
      return el("div", {}, el("p", { class: "h-2", "data-testid": "cloud-losses-said" }, "Since this console started. Lost never arrived. Twice came again, or was sent again since an answer was lost: it counts once."), table(["From, to", "Arrived", "Lost", "Twice", "Out of order", "Last lost", "Which"], [
        row("Robots to console", heard, kinds(heard), "cloud-lost-console"),
        ...heard.robots.map((one) => row(one.id, one, kinds(one), `cloud-lost-${one.id}`)),
        { hook: "cloud-lost-cloud", cells: ["All to the cloud", counts.states + counts.others + counts.records, counts.dropped, counts.sent_twice, "–", "–", counts.dropped ? "no room here, or too old" : ""] },
      ]), ...(silent ? [el("p", { class: "h-2" }, silent)] : []), ...(heard.more_robots ? [el("p", { class: "h-2" }, `${heard.more_robots} more robots lost fewer.`)] : []));
    }

    counts(counts) {
      return table(["What", "Value"], [
        ["Reports of robots", counts.states], ["Of field stations and cameras", counts.others], ["Events, alarms and missions", counts.records],
        ["Sent twice, since an answer was lost", counts.sent_twice],
        ["Events heard twice from robots", counts.heard_twice], ["Robot messages dropped here", counts.lost_from_robots],
        ["Refused by the cloud, each time it was tried", counts.refused ? `${counts.refused}, the last: ${counts.last_refusal}` : 0],
      ].map((cells) => ({ cells })));
    }

    changes(map) {
      const lost = map.subscription_lost ? `${map.subscription_lost}, the last ${HL.records.when(map.subscription_lost_utc)}: made again, everything read` : "never";
      const rows = [
        ["Learned", map.is_storm ? "more is told than can be looked at: everything is read every 10 s" : map.untold ? `read every five minutes: the broker does not get through to this console (${map.untold})` : map.is_told ? (map.subscribed ? "at once: the broker tells this console" : "not subscribed yet; read every five minutes") : "read every five minutes: cloud_notify_url is not set"],
        ["Proposed, see Maps", map.left_out ? `${map.proposals}; ${map.left_out} more did not fit` : map.proposals],
      ];
      if (map.is_told) rows.push(["Told by the broker", el("span", { "data-testid": "cloud-notified", "data-value": map.notifications }, String(map.notifications))], ["Of them repeated or out of order", map.old_news], ["Not let in, or not readable", map.notifications_refused], ["Subscription deleted there", el("span", { "data-testid": "cloud-subscription-lost", "data-value": map.subscription_lost }, lost)]);
      return table(["What", "Value"], rows.map((cells) => ({ cells })));
    }

    take() {
      HL.sheet({
        title: "Use this tenant?",
        body: [el("p", { class: "h-2 h-t16" }, "This console will keep the farm in this tenant from now on. If another console does too, they write over each other."), this.said = el("div", { class: "h-error", role: "alert" })],
        buttons: [["Cancel", (close) => close()], ["Use it", async (close) => {
          const answer = await HL.port.api("POST", "/cloud/tenant", {});
          if (!answer.ok) return text(this.said, answer.text || "The server did not answer.");
          return close();
        }, true]],
      });
    }
  }

  HL.AdminCloud = Panel;
})();
