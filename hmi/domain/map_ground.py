"""What features of the map mean for whoever drives: closed ground, ways, and how wide what is drawn as a line is."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

CROSSED_KINDS = ("water", "hedge", "tree")
"""Closed, but for where a road is drawn across: that is a bridge, or a gap."""

CLOSED_KINDS = ("obstacle", "building", "no-go", "no_go", "hole", *CROSSED_KINDS)
"""Where no machine may be."""

KEPT_OUT_KINDS = ("no-go", "no_go")
"""Where nothing may be, in the air neither."""

FLOWN_OVER_KINDS = ("obstacle", "building", "hedge", "tree")
"""What stands up and may have a height, ``object_height_m``."""

HIGHEST_M = 300.0

WAY_KINDS = ("road", "yard")

WIDTHS_M = MappingProxyType({"road": 4.0, "hedge": 5.0, "tree": 5.0, "water": 4.0})
"""Width of lines without ``width_m``, and across points without ``radius_m``; as drawn."""

SLOW_MPS = 0.5
"""Speed in slow zones that do not say one; the editor begins with it."""


def object_height_m(kind: str, properties: Mapping[str, Any]) -> float | None:
    """Return how high a feature of the map stands, metres above the ground it stands on.

    ``None`` is not known: nobody said it, it is no height (more than 0, at most ``HIGHEST_M``), or the kind has none.
    """
    height = properties.get("height_m")
    if kind not in FLOWN_OVER_KINDS or isinstance(height, bool) or not isinstance(height, int | float):
        return None
    return float(height) if 0 < height <= HIGHEST_M else None
