// Moving a thing among its fellows with finger or mouse; `Alt` and arrows do the same, and so do the buttons.
(() => {
  "use strict";
  const START_PX = 8; // less is a tap
  const SWALLOW_MS = 400; // a busy tablet sends the click a good while after the finger is up

  // options: {axis: "x"|"y", fellows: () => [nodes in order, this one included], drop: (index) => {}}
  function draggable(node, handle, { axis, fellows, drop }) {
    const at = (event) => (axis === "x" ? event.clientX : event.clientY);
    const middle = (box) => (axis === "x" ? box.left + box.width / 2 : box.top + box.height / 2);
    handle.style.touchAction = axis === "x" ? "pan-y" : "none";
    handle.addEventListener("pointerdown", (event) => {
      if (event.button > 0) return;
      const from = at(event);
      let isMoving = false;
      const shift = (move) => {
        const by = at(move) - from;
        if (!isMoving && Math.abs(by) < START_PX) return;
        if (!isMoving) {
          isMoving = true;
          handle.setPointerCapture(event.pointerId);
          node.classList.add("moving");
        }
        move.preventDefault();
        node.style.transform = axis === "x" ? `translateX(${by}px)` : `translateY(${by}px)`;
      };
      const end = (last) => {
        for (const [name, listener] of pairs) handle.removeEventListener(name, listener);
        node.classList.remove("moving");
        const own = middle(node.getBoundingClientRect());
        node.style.transform = "";
        if (!isMoving || last.type === "pointercancel") return;
        // the click that ends a drag opens nothing
        const swallow = (click) => (click.stopImmediatePropagation(), click.preventDefault());
        handle.addEventListener("click", swallow, true);
        setTimeout(() => handle.removeEventListener("click", swallow, true), SWALLOW_MS);
        const others = fellows().filter((one) => one !== node);
        drop(others.filter((one) => middle(one.getBoundingClientRect()) < own).length);
      };
      const pairs = [["pointermove", shift], ["pointerup", end], ["pointercancel", end]];
      for (const [name, listener] of pairs) handle.addEventListener(name, listener);
    });
  }

  // Alt and an arrow: one place earlier or later
  function keyed(node, move) {
    node.addEventListener("keydown", (event) => {
      if (!event.altKey || !["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"].includes(event.key)) return;
      event.preventDefault();
      move(["ArrowLeft", "ArrowUp"].includes(event.key) ? -1 : 1);
    });
  }

  HL.queueDrag = { draggable, keyed };
})();
