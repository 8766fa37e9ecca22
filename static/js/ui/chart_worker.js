// Lays charts out beside the page: {id, chart, widths, window} in, {id, layout} or {id, problem} out.
(() => {
  "use strict";
  self.onmessage = ({ data }) => {
    try {
      self.postMessage({ id: data.id, layout: globalThis.HLC.chartLayout(data.chart, data.widths, data.window) });
    } catch (error) {
      self.postMessage({ id: data.id, problem: String(error) });
    }
  };
})();
