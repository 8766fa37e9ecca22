// Placeholder of hl-super-functions.
(() => {
  "use strict";
  class SuperFunctions extends HL.LiveElement {}
  HL.superDefine("hl-super-functions", SuperFunctions);
})();
