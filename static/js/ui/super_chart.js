(() => {
  "use strict";
  class SuperChart extends HL.LiveElement {}
  HL.superDefine("hl-super-chart", SuperChart);
})();
