// Lays charts out beside the page: {id, chart, widths, window} in; {id, placed} and then {id, layout}, or {id, problem} out.
(() => {
  "use strict";
  self.onmessage = ({ data }) => {
    try {
      const placed = (layout) => self.postMessage({ id: data.id, placed: layout });
      self.postMessage({ id: data.id, layout: globalThis.HLC.chartLayout(data.chart, data.widths, data.window, placed) });
    } catch (error) {
      self.postMessage({ id: data.id, problem: String(error) });
    }
  };
})();
