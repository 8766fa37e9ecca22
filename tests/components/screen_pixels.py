"""Read the colours of a screenshot; the browser that took it decodes it, so no image library is needed."""

from __future__ import annotations

import base64

from playwright.sync_api import Page

Colour = tuple[int, int, int]

DECODE = """async (png) => {
    const bytes = Uint8Array.from(atob(png), (c) => c.charCodeAt(0));
    const picture = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
    const canvas = new OffscreenCanvas(picture.width, picture.height);
    const context = canvas.getContext('2d', { willReadFrequently: true });
    context.drawImage(picture, 0, 0);
    const { data } = context.getImageData(0, 0, picture.width, picture.height);
    const parts = [];
    for (let i = 0; i < data.length; i += 30000) parts.push(String.fromCharCode(...data.subarray(i, i + 30000)));
    return [picture.width, picture.height, btoa(parts.join(''))];
}"""


class Pixels:
    """What a page shows; ``at(x, y)`` is the colour in CSS px (scale factor 1)."""

    def __init__(self, page: Page) -> None:
        png = base64.b64encode(page.screenshot()).decode()
        self.width, self.height, data = page.evaluate(DECODE, png)
        self._data = base64.b64decode(data)

    def at(self, x: float, y: float) -> Colour:
        """Return the colour under a point."""
        i = (int(y) * self.width + int(x)) * 4
        return self._data[i], self._data[i + 1], self._data[i + 2]


def is_close(one: Colour, other: Colour, tolerance: int = 10) -> bool:
    """Return whether two colours look alike."""
    return max(abs(a - b) for a, b in zip(one, other, strict=True)) <= tolerance


def from_hex(text: str) -> Colour:
    """Return the colour of ``#rrggbb``."""
    return int(text[1:3], 16), int(text[3:5], 16), int(text[5:7], 16)
