// Placeholder of hl-super-nodes.
(() => {
  "use strict";
  class SuperNodes extends HL.LiveElement {}
  HL.superDefine("hl-super-nodes", SuperNodes);
})();
