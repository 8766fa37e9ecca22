"""Which bands of a photo are its colours, and how they become 8-bit RGBA."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hmi.base_maps.errors import BadBaseMap

SAMPLE_PX = 1000  # edge of the small copy from which the range of 16-bit colours is taken
DARKEST, BRIGHTEST = 2.0, 98.0  # percentiles: a few bright roofs must not leave the fields black
_NO_COLOURS = "This GeoTIFF holds measurements ({what}), not a picture. Save it as an RGB picture with 8 bits a colour."


@dataclass(frozen=True, slots=True)
class Colours:
    """How a photo is looked at.

    Attributes:
        bands: numbers (from 1) of red, green and blue, or of grey.
        alpha: number of the photo's own alpha band, if it has one.
        palette: RGBA of each value of a single band.
        darkest: value that becomes 0.
        brightest: value that becomes 255.
    """

    bands: tuple[int, ...]
    alpha: int | None
    palette: npt.NDArray[np.uint8] | None
    darkest: float
    brightest: float

    @property
    def has_alpha(self) -> bool:
        """Whether the photo says itself which pixels count."""
        return self.alpha is not None

    def picture(self, laid: Any, window: Any) -> npt.NDArray[np.uint8]:
        """Return a window of the photo laid on the map, as RGBA."""
        alpha = laid.count if self.alpha is None else self.alpha
        raw = laid.read((*self.bands, alpha), window=window)
        out = np.empty((*raw.shape[1:], 4), np.uint8)
        if self.palette is not None:
            out[:] = self.palette[raw[0]]
        else:
            for i in range(3):
                out[..., i] = self._eight_bit(raw[min(i, len(self.bands) - 1)])
            out[..., 3] = 255
        full = float(np.iinfo(raw.dtype).max)
        out[raw[-1] < full / 2] = 0
        return out

    def _eight_bit(self, band: npt.NDArray[Any]) -> npt.NDArray[Any]:
        if (self.darkest, self.brightest) == (0.0, 255.0):
            return band
        scaled = (band.astype(np.float32) - self.darkest) * (255.0 / (self.brightest - self.darkest))
        clipped: npt.NDArray[Any] = np.clip(scaled, 0, 255)
        return clipped


def colours_of(photo: Any) -> Colours:
    """Return how to look at a photo; raises ``BadBaseMap`` when it is none."""
    from rasterio.enums import ColorInterp

    if len(set(photo.dtypes)) != 1 or photo.dtypes[0] not in ("uint8", "uint16"):
        raise BadBaseMap("not_a_picture", _NO_COLOURS.format(what=", ".join(sorted(set(photo.dtypes)))))
    meaning = list(photo.colorinterp)
    alpha = meaning.index(ColorInterp.alpha) + 1 if ColorInterp.alpha in meaning else None
    if meaning[0] is ColorInterp.palette and photo.dtypes[0] == "uint8":
        return Colours((1,), alpha, _palette(photo.colormap(1)), 0.0, 255.0)
    colours = [i + 1 for i, one in enumerate(meaning) if one is not ColorInterp.alpha]
    rgb = (ColorInterp.red, ColorInterp.green, ColorInterp.blue)
    if all(one in meaning for one in rgb):
        bands = tuple(meaning.index(one) + 1 for one in rgb)
    elif len(colours) >= 3:
        bands = tuple(colours[:3])
    else:
        bands = tuple(colours[:1])
    if not bands:
        raise BadBaseMap("not_a_picture", _NO_COLOURS.format(what="only transparency"))
    darkest, brightest = (0.0, 255.0) if photo.dtypes[0] == "uint8" else _range(photo, bands)
    return Colours(bands, alpha, None, darkest, brightest)


def _palette(colormap: dict[int, tuple[int, int, int, int]]) -> npt.NDArray[np.uint8]:
    table = np.zeros((256, 4), np.uint8)
    for value, colour in colormap.items():
        if 0 <= value < 256:
            table[value] = colour
    return table


def _range(photo: Any, bands: tuple[int, ...]) -> tuple[float, float]:
    shrink = max(1.0, max(photo.width, photo.height) / SAMPLE_PX)
    shape = (len(bands), max(1, int(photo.height / shrink)), max(1, int(photo.width / shrink)))
    sample = photo.read(bands, out_shape=shape, masked=True).compressed()
    if not sample.size:
        raise BadBaseMap("empty", "The photo is empty: every pixel of it is transparent or without data.")
    darkest, brightest = (float(one) for one in np.percentile(sample, (DARKEST, BRIGHTEST)))
    return darkest, max(brightest, darkest + 1.0)
