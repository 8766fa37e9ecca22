(() => {
  "use strict";
  class SuperShare extends HL.LiveElement {}
  HL.superDefine("hl-super-share", SuperShare);
})();
