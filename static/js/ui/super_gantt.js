(() => {
  "use strict";
  class SuperGantt extends HL.LiveElement {}
  HL.superDefine("hl-super-gantt", SuperGantt);
})();
