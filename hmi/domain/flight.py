"""What a machine in the air flies over, and what it flies around."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hmi.domain.map_ground import FLOWN_OVER_KINDS, KEPT_OUT_KINDS, object_height_m

CLEARANCE_M = 5.0
"""Between flight height and what is flown over: a barometer drifts by some 2 m in a flight, a person's eye errs by as
much at a tree, and an aerial on a roof is on no map."""

TOLD = 3  # names in a sentence


def is_in_the_air(kind: str, properties: Mapping[str, Any], flight_height_m: float | None) -> bool:
    """Say whether a feature of the map is flown around: it reaches the flight height, or may.

    So is what stands up and has no height, and all that stands up if the robot does not say how high it flies.

    Args:
        flight_height_m: above the ground; ``None``: not known.
    """
    if kind in KEPT_OUT_KINDS:
        return True
    if kind not in FLOWN_OVER_KINDS:
        return False
    height_m = object_height_m(kind, properties)
    return height_m is None or flight_height_m is None or height_m >= flight_height_m - CLEARANCE_M


def is_height_missed(kind: str, properties: Mapping[str, Any]) -> bool:
    """Say whether a height entered on the map could let it be flown over."""
    return kind in FLOWN_OVER_KINDS and object_height_m(kind, properties) is None


def named(names: Sequence[str]) -> str:
    """Return a few names and how many more there are."""
    shown = list(dict.fromkeys(names))
    more = len(shown) - TOLD
    return ", ".join(shown[:TOLD]) + (f" and {more} more" if more > 0 else "")


def in_the_way(names: Sequence[str], unmeasured: Sequence[str], flight_height_m: float | None) -> str:
    """Say what stands in a path that is flown, and what mends it; empty if nothing does.

    Args:
        names: of what is as high as the path, or may be; ``unmeasured`` those without a height on the map.
    """
    if not names:
        return ""
    told, be = named(names), "are" if len(set(names)) > 1 else "is"
    if flight_height_m is None:
        return f"{told} {be} in its path, and the robot does not say how high it flies. Plan again."
    known = [one for one in names if one not in unmeasured]
    if known:
        be = "are" if len(set(known)) > 1 else "is"
        return f"{named(known)} {be} in its path, too high to fly over at {flight_height_m:g} m. Plan again."
    return f"{told} {be} in its path, and nobody entered how high. Enter the height on the map, or plan again."
