"""What features of the map mean for whoever drives: closed ground, ways, and how wide what is drawn as a line is."""

from __future__ import annotations

from types import MappingProxyType

CROSSED_KINDS = ("water", "hedge", "tree")
"""Closed, but for where a road is drawn across: that is a bridge, or a gap."""

CLOSED_KINDS = ("obstacle", "building", "no-go", "no_go", "hole", *CROSSED_KINDS)
"""Where no machine may be."""

KEPT_OUT_KINDS = ("no-go", "no_go")
"""Where nothing may be, in the air neither. How high all else stands the map does not say: who flies, flies over it."""

WAY_KINDS = ("road", "yard")

WIDTHS_M = MappingProxyType({"road": 4.0, "hedge": 5.0, "tree": 5.0, "water": 4.0})
"""Width of lines without ``width_m``, and across points without ``radius_m``; as drawn."""

SLOW_MPS = 0.5
"""Speed in slow zones that do not say one; the editor begins with it."""
