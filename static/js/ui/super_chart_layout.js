// Asks the worker for the layout of a chart, once for each chart and shape of window; kept as long as the page lives.
(() => {
  "use strict";
  const FONT_PX = 14;
  const TIME_PX = 12.5;
  const PAD_PX = 26;
  const kept = new Map();
  const asked = new Map();
  let worker = null;
  let number = 0;

  function start() {
    worker = new Worker(document.querySelector("[data-layout]").dataset.layout);
    worker.onmessage = ({ data }) => {
      const { done, failed, placed } = asked.get(data.id) ?? {};
      if (data.placed) return void placed?.(data.placed);
      asked.delete(data.id);
      if (data.layout) done?.(data.layout);
      else failed?.(new Error(data.problem));
    };
    worker.onerror = (event) => {
      for (const { failed } of asked.values()) failed(new Error(event.message || "the layout did not load"));
      asked.clear();
      worker = null;
    };
  }

  // px that the words of each state need, its longest time included
  function widths(chart) {
    const pen = document.createElement("canvas").getContext("2d");
    const family = getComputedStyle(document.body).fontFamily;
    return Object.fromEntries(chart.states.map((state) => {
      pen.font = `700 ${FONT_PX}px ${family}`;
      const label = pen.measureText(state.label).width;
      pen.font = `600 ${TIME_PX}px ${family}`;
      const time = state.normal_s ? pen.measureText(`59:59, normal ${HL.chartFacts.span(state.normal_s)}`).width : 0;
      return [state.id, Math.max(label + PAD_PX, time + 12)];
    }));
  }

  // the shape counts, not each pixel: a scroll bar must not move the states
  const shape = ({ w, h }) => Math.round(Math.log(w / h) * 4);

  // {key, layout}; placed is called before with the states alone, where it is not known yet
  function of(chart, window, placed) {
    const key = `${chart.hash}.${shape(window)}`;
    if (!kept.has(key)) {
      const made = document.fonts.ready.then(() => new Promise((done, failed) => {
        if (!worker) start();
        number += 1;
        asked.set(number, { done, failed, placed });
        worker.postMessage({ id: number, chart, widths: widths(chart), window });
      }));
      made.catch(() => kept.delete(key));
      kept.set(key, made);
    }
    return { key, layout: kept.get(key) };
  }

  HL.chartLayouts = { of };
})();
