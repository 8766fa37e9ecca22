// Placeholder of hl-super-logs.
(() => {
  "use strict";
  class SuperLogs extends HL.LiveElement {}
  HL.superDefine("hl-super-logs", SuperLogs);
})();
