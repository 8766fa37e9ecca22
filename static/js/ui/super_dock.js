// Placeholder of hl-super-dock.
(() => {
  "use strict";
  class SuperDock extends HL.LiveElement {}
  HL.superDefine("hl-super-dock", SuperDock);
})();
