"""What changed between two maps, in sentences."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from hmi.mapping.attributes import LABELS, RANGES
from hmi.mapping.coordinates import Position, is_ring, paths
from hmi.mapping.feature import MapFeature
from hmi.mapping.ground import frame_of
from hmi.mapping.kinds import KINDS, LINE
from hmi.mapping.measures import area_m2, area_text, edge_m
from hmi.planning.projection import LocalFrame

SAME_M = 0.005  # corners that moved alike to within this moved as one
DECIMALS = {"row_bearing_deg": 1, "heading_deg": 1}


@dataclass(frozen=True, slots=True)
class Difference:
    """One thing that changed.

    Args:
        id, name, kind: of the feature, as it is now; of a removed one as it was.
        what: ``added``, ``removed``, ``moved`` or ``changed``.
        text: such as ``Corner 2 moved 1.4 m``; corners are numbered from 1.
    """

    id: str
    name: str
    kind: str
    what: str
    text: str

    def as_json(self) -> dict[str, str]:
        """Return one of ``differences`` of docs/protocols/map.md."""
        return {"id": self.id, "name": self.name, "kind": self.kind, "what": self.what, "text": self.text}


def compare(old: Iterable[MapFeature], new: Iterable[MapFeature]) -> list[Difference]:
    """Return what changed from one map to another, in the order of the new map, removed features last."""
    before, after = {one.id: one for one in old}, {one.id: one for one in new}
    found: list[Difference] = []
    for key, one in after.items():
        if key not in before:
            found.append(Difference(one.id, one.name, one.kind, "added", f"Added{_size(one)}"))
        elif before[key] != one:
            found += [
                Difference(one.id, one.name, one.kind, what, text) for what, text in _differences(before[key], one)
            ]
    for key, one in before.items():
        if key not in after:
            found.append(Difference(one.id, one.name, one.kind, "removed", f"Removed{_size(one)}"))
    return found


def _size(feature: MapFeature) -> str:
    if is_ring(feature.geometry):
        return f", {area_text(area_m2(feature))}"
    return f", {edge_m(feature):.0f} m" if feature.geometry["type"] == LINE else ""


def _differences(old: MapFeature, new: MapFeature) -> Iterator[tuple[str, str]]:
    if old.name != new.name:
        yield "changed", _value_text("Name", old.name or None, new.name or None)
    if old.kind != new.kind:
        yield "changed", f"Kind {KINDS[old.kind].noun} to {KINDS[new.kind].noun}"
    if old.geometry != new.geometry:
        yield from _shape(old, new)
    for key in dict.fromkeys((*old.properties, *new.properties)):
        a, b = old.properties.get(key), new.properties.get(key)
        if a != b:
            yield "changed", _attribute(key, a, b)


def _shape(old: MapFeature, new: MapFeature) -> Iterator[tuple[str, str]]:
    if old.geometry["type"] != new.geometry["type"]:
        yield "changed", f"Shape {old.geometry['type']} to {new.geometry['type']}"
        return
    frame, closed = frame_of([old]), is_ring(old.geometry)
    before, after = ([path[:-1] if closed else path for path in paths(one.geometry)] for one in (old, new))
    if len(before) == len(after):
        way = _moved_as_one(before, after, frame)
        if way is not None and (way >= SAME_M or not closed):
            yield "moved", f"Moved {_metres(way)}"
        else:
            for number, (a, b) in enumerate(zip(before, after, strict=True)):
                if a != b:
                    yield "moved", _path(a, b, frame, closed) + _of(number, closed)
    else:
        yield from _path_count(before, after, frame, closed)
    if closed and (was := area_text(area_m2(old))) != (now := area_text(area_m2(new))):
        yield "changed", f"Area {was} to {now}"


def _path_count(
    before: list[list[Position]], after: list[list[Position]], frame: LocalFrame, closed: bool
) -> Iterator[tuple[str, str]]:
    if closed and before[0] != after[0]:
        yield "moved", _path(before[0], after[0], frame, closed)
    noun = "hole" if closed else "line"
    more, what = len(after) - len(before), "added" if len(after) > len(before) else "removed"
    yield "changed", f"{noun.capitalize()} {what}" if abs(more) == 1 else f"{abs(more)} {noun}s {what}"


def _moved_as_one(before: list[list[Position]], after: list[list[Position]], frame: LocalFrame) -> float | None:
    """Return how far everything moved alike, metres; ``None`` if it did not."""
    if [len(a) for a in before] != [len(b) for b in after]:
        return None
    steps = np.vstack([frame.to_local(b) - frame.to_local(a) for a, b in zip(before, after, strict=True)])
    if np.ptp(steps, axis=0).max() > SAME_M:
        return None
    return float(np.hypot(*steps.mean(axis=0)))


def _path(old: list[Position], new: list[Position], frame: LocalFrame, closed: bool) -> str:
    a, b = list(map(tuple, old)), list(map(tuple, new))
    if sorted(a) == sorted(b):
        turned = a[:1] + a[:0:-1] if closed else a[::-1]
        return "Direction turned round" if b == turned else "Order of corners changed"
    if len(a) == len(b):
        far = np.hypot(*(frame.to_local(new) - frame.to_local(old)).T)
        moved = np.flatnonzero([p != q for p, q in zip(a, b, strict=True)])
        if len(moved) == 1:
            return f"Corner {moved[0] + 1} moved {_metres(float(far[moved[0]]))}"
        return f"{len(moved)} corners moved, up to {_metres(float(far.max()))}"
    was, now = set(a), set(b)
    added, removed = [n for n, p in enumerate(b) if p not in was], [n for n, p in enumerate(a) if p not in now]
    said = [_count(added, "added"), _count(removed, "removed")]
    return ", ".join(one for one in said if one) or "Order of corners changed"


def _count(numbers: list[int], what: str) -> str:
    if not numbers:
        return ""
    return f"Corner {numbers[0] + 1} {what}" if len(numbers) == 1 else f"{len(numbers)} corners {what}"


def _of(number: int, closed: bool) -> str:
    if not number:
        return ""
    return f" (hole {number})" if closed else f" (line {number + 1})"


def _attribute(key: str, old: Any, new: Any) -> str:
    unit = f" {RANGES[key].unit}" if key in RANGES else ""
    label = LABELS.get(key, key)
    if key in RANGES and isinstance(old, (int, float)) and isinstance(new, (int, float)):
        digits = DECIMALS.get(key, 2)
        a, b = f"{old:.{digits}f}", f"{new:.{digits}f}"
        return f"{label} {a} to {b}{unit}" if a != b else f"{label} {old:g} to {new:g}{unit}"
    return _value_text(label, old, new, unit)


def _value_text(label: str, old: Any, new: Any, unit: str = "") -> str:
    if old is None:
        return f"{label} set to {_shown(new)}{unit}"
    if new is None:
        return f"{label} removed, was {_shown(old)}{unit}"
    return f"{label} {_shown(old)} to {_shown(new)}{unit}"


def _shown(value: Any) -> str:
    if isinstance(value, (dict, list)):
        return "other values"
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return text if len(text) <= 60 else text[:59] + "…"


def _metres(length: float) -> str:
    if length < 0.1:
        return f"{max(length, 0.001) * 100:.1f} cm"
    return f"{length:.1f} m" if length < 1000 else f"{length / 1000:.1f} km"
