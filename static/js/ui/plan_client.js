// Asking for plans: one request, an answer for each row order as it is made; leaving it frees the planner.
(() => {
  "use strict";
  const SILENCE_MS = 75000; // the planner gives up a plan after 60 s and says so
  const NAMES = { row_by_row: "Row by row", skip_rows: "Skip rows", spiral: "Spiral", shortest: "Shortest" };

  async function refusal(response) {
    const body = await response.json().catch(() => null);
    return { text: body?.text || `The server answered ${response.status}.`, field: body?.field ?? null };
  }

  // whole lines out of a stream of bytes
  async function* linesOf(body, onHeard) {
    const reader = body.pipeThrough(new TextDecoderStream()).getReader();
    let rest = "";
    for (;;) {
      const { value, done } = await reader.read();
      onHeard();
      if (done) return;
      const lines = (rest + value).split("\n");
      rest = lines.pop();
      yield* lines.filter(Boolean);
    }
  }

  // compare(wish, {line(answer), failed({text, field}), ended()}) -> cancel()
  function compare(wish, on) {
    const abort = new AbortController();
    let isCancelled = false;
    let timer = 0;
    const heard = () => {
      clearTimeout(timer);
      timer = setTimeout(() => abort.abort(), SILENCE_MS);
    };
    const run = async () => {
      heard();
      try {
        const response = await fetch(`${HL.config.apiPath || "/api/v1"}/missions/candidates`, {
          method: "POST", credentials: "same-origin", cache: "no-store", signal: abort.signal, body: JSON.stringify(wish),
          headers: { Accept: "application/x-ndjson", "Content-Type": "application/json", "X-Headland-CSRF": HL.config.csrf || "" },
        });
        if (!response.ok) return on.failed(await refusal(response));
        let isWhole = false;
        for await (const line of linesOf(response.body, heard)) {
          const answer = JSON.parse(line);
          isWhole = answer.state === "done";
          if (!isCancelled) on.line(answer);
        }
        if (!isWhole && !isCancelled) on.failed({ text: "Planning broke off. Try again.", field: null });
      } catch {
        if (!isCancelled) on.failed({ text: abort.signal.aborted ? "The planner did not answer in time. Try again." : "Not planned: the server cannot be reached.", field: null });
      } finally {
        clearTimeout(timer);
        if (!isCancelled) on.ended();
      }
    };
    run();
    return () => {
      isCancelled = true;
      abort.abort();
    };
  }

  HL.planner = { compare, NAMES };
})();
