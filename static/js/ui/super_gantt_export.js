// A drawing of the screen as a picture to take away: colours and fonts of now, on the ground of the card.
(() => {
  "use strict";
  const KEPT = ["fill", "stroke", "stroke-width", "stroke-dasharray", "font-size", "font-weight", "opacity", "text-anchor", "paint-order"];
  const SCALE = 2;

  function frozen(drawing, width, height) {
    const copy = drawing.cloneNode(true);
    const [from, to] = [[drawing, ...drawing.querySelectorAll("*")], [copy, ...copy.querySelectorAll("*")]];
    from.forEach((node, i) => {
      const style = getComputedStyle(node);
      to[i].removeAttribute("class");
      to[i].setAttribute("style", [...KEPT.map((name) => `${name}:${style.getPropertyValue(name)}`), "font-family:Inter,'Helvetica Neue',Arial,sans-serif"].join(";"));
    });
    copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
    copy.setAttribute("width", width);
    copy.setAttribute("height", height);
    return new XMLSerializer().serializeToString(copy);
  }

  async function png(drawing, title) {
    const { width, height } = drawing.getBoundingClientRect();
    const picture = new Image();
    picture.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(frozen(drawing, width, height))}`;
    await picture.decode();
    const canvas = document.createElement("canvas");
    const head = 36;
    canvas.width = width * SCALE;
    canvas.height = (height + head) * SCALE;
    const pen = canvas.getContext("2d");
    const style = getComputedStyle(drawing.closest(".h-card") ?? document.body);
    pen.scale(SCALE, SCALE);
    pen.fillStyle = style.backgroundColor;
    pen.fillRect(0, 0, width, height + head);
    pen.fillStyle = style.color;
    pen.font = "600 15px Inter, 'Helvetica Neue', Arial, sans-serif";
    pen.fillText(title, 14, 23);
    pen.drawImage(picture, 0, head, width, height);
    return new Promise((done) => canvas.toBlob(done, "image/png"));
  }

  function save(blob, name) {
    const link = HL.el("a", { href: URL.createObjectURL(blob), download: name });
    document.body.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }

  HL.superExport = { png, save };
})();
