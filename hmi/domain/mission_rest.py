"""What is left of a mission: where it was interrupted, the pieces still to do, and a wish for the rest."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Protocol

from hmi.domain.mission_document import Document
from hmi.domain.mission_plan import Geometry, PlanRefused, Surroundings
from hmi.domain.robot import Factsheet, Order

SAME_M = 0.005  # nearer to a segment's end than this the cut lies between two segments
DIGITS = 3  # of coordinates: millimetres, as planned
WORK_KINDS = ("row", "headland")
LEAVE_OUT, OBSTACLE = "leave_out", "obstacle"
Segment = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a robot has come on the document ``sha256``; ``segment`` counts from 0, metres along it."""

    sha256: str
    segment: int
    segment_s_m: float
    row: int = 0
    rows: int = 0
    area_m2: float = 0.0
    area_done_m2: float = 0.0

    @classmethod
    def of(cls, order: Order) -> Progress:
        """Return the progress a robot reports."""
        return cls(
            order.sha256,
            order.segment,
            order.segment_s_m,
            order.row,
            order.rows,
            order.area_m2,
            order.area_done_m2,
        )

    @property
    def is_begun(self) -> bool:
        """Whether anything would be lost by starting fresh."""
        return self.area_done_m2 > 0 or self.row > 0

    def as_json(self) -> dict[str, Any]:
        """Return what is stored."""
        return {name: getattr(self, name) for name in self.__slots__}

    @classmethod
    def from_json(cls, raw: Mapping[str, Any] | None) -> Progress | None:
        """Return what was stored, ``None`` if nothing was."""
        return None if not raw else cls(**{name: raw[name] for name in cls.__slots__ if name in raw})


def kept_of(document: Mapping[str, Any]) -> int:
    """Return how many segments the rest of a mission kept of the one before, 0 for a whole mission.

    Of a rest that was changed under way the last of them are still ahead of the robot.
    """
    return int((document.get("continues") or {}).get("segments", 0))


def kept_behind(kept: int, flown: int | None) -> int:
    """Return how many of the segments that a rest kept are behind the robot: all, where nobody knows how far it is."""
    return kept if flown is None else min(flown, kept)


@dataclass(frozen=True, slots=True)
class Piece:
    """A row or headland lap still to do, or a piece of one.

    Args:
        number: its segment in the document, from 0.
        row: 0 off the rows; ``lap`` then says which lap of those that are left, from 1.
    """

    number: int
    kind: str
    row: int
    length_m: float
    is_present: bool = False
    lap: int = 0

    @property
    def name(self) -> str:
        """What people call it."""
        return f"Row {self.row}" if self.row else "Headland lap"


@dataclass(frozen=True, slots=True)
class DrawnArea:
    """Ground somebody drew on one mission.

    Args:
        kind: ``leave_out`` is driven through with the tool off, ``obstacle`` is never entered.
        outline: corners, longitude and latitude; the last one is joined to the first.
        clearance_m: kept around an obstacle, on top of the machine's own margin.
    """

    kind: str
    outline: tuple[tuple[float, float], ...]
    clearance_m: float = 0.0

    @property
    def geometry(self) -> Geometry:
        """The outline as GeoJSON."""
        return {"type": "Polygon", "coordinates": [[list(p) for p in (*self.outline, self.outline[0])]]}

    def as_json(self) -> dict[str, Any]:
        """Return what is stored."""
        outline = [list(p) for p in self.outline]
        return {"kind": self.kind, "outline": outline, "clearance_m": self.clearance_m}

    @classmethod
    def from_json(cls, raw: Mapping[str, Any]) -> DrawnArea:
        """Return what was stored."""
        return cls(raw["kind"], tuple((lon, lat) for lon, lat in raw["outline"]), raw["clearance_m"])


@dataclass(frozen=True, slots=True)
class RestWish:
    """How the rest of a mission is wished for. Positions are longitude and latitude, angles ENU radians.

    Args:
        base: the document the robot has; ``base_sha256`` its hash.
        revision: of the new document.
        progress: how far it is.
        is_running: the robot drives on while this is planned.
        stand: longitude, latitude and heading, to take it up again from there; ``None``: it stands on its path.
        leave_out: pieces that are not done, by number.
        areas: ground drawn on this mission.
        is_reversed: the last piece first, each the other way round.
        row_speed_mps: another working speed; ``None`` keeps it.
        end: ``as_planned``, ``stay`` or ``home``.
        home: another home; ``None`` keeps it.
        field_now: the field as the map shows it now; what the base has beyond it is closed. ``None`` keeps the base's.
        around_before: what stood around it on the map that the base was planned on, ``None`` if that is not known.
        map_version: number and hash of the map whose obstacles and roads count.
        lead_m: how long the tool is on before and after treated ground in ``base``; ``None``: as long as this tool is.
    """

    base: Document
    base_sha256: str
    revision: int
    progress: Progress
    is_running: bool = False
    stand: tuple[float, float, float] | None = None
    leave_out: tuple[int, ...] = ()
    areas: tuple[DrawnArea, ...] = ()
    is_reversed: bool = False
    row_speed_mps: float | None = None
    end: str = "as_planned"
    home: tuple[float, float] | None = None
    field_now: Geometry | None = None
    surroundings: Surroundings = field(default_factory=Surroundings)
    around_before: Surroundings | None = None
    robot: Factsheet | None = None
    map_version: Mapping[str, Any] | None = None
    lead_m: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class PlannedRest:
    """A document ready to send, and what it changes.

    Args:
        statistics: of the whole mission as it is now, SI.
        difference: ``before`` and ``after`` (duration_s, energy_j, battery_share, area_m2, rows, length_m),
            ``left_out`` and ``notes`` in words, ``kept_until`` in words, ``way_m`` of the way back, ``missed_m2``
            that were to be worked and are not any more though nobody left them out; when it was asked for through
            ``MissionRests`` also ``progress``, how far the robot was then.
    """

    document: Document
    sha256: str
    statistics: dict[str, Any]
    difference: dict[str, Any]


class RestPlanner(Protocol):
    """Plans rests off the event loop."""

    async def rest(self, wish: RestWish) -> PlannedRest:
        """Return the new document.

        Raises:
            PlanRefused: it cannot be planned, or took too long.
        """
        ...


def cut(segments: Sequence[Segment], number: int, s_m: float) -> tuple[list[Document], list[Document], int]:
    """Cut a path after ``s_m`` metres of segment ``number``.

    Returns:
        What lies before, what lies after, and the number of the segment the second part begins with.

    Raises:
        PlanRefused: there is no such segment.
    """
    if not 0 <= number < len(segments):
        raise PlanRefused("bad_progress", "The robot's place on the path is not known. Wait for its next report.")
    whole = dict(segments[number])
    points = [tuple(p) for p in whole["points"]]
    before, after = _split(points, s_m)
    if before is None:
        return [dict(s) for s in segments[:number]], [dict(s) for s in segments[number:]], number
    if after is None:
        return [dict(s) for s in segments[: number + 1]], [dict(s) for s in segments[number + 1 :]], number + 1
    head = [*map(dict, segments[:number]), {**whole, "points": before}]
    first = {key: value for key, value in whole.items() if key != "jump"}
    return head, [{**first, "points": after, "pivot": False}, *map(dict, segments[number + 1 :])], number


def pieces_of(document: Mapping[str, Any], progress: Progress) -> list[Piece]:
    """Return the rows and laps that are left, in driving order."""
    head, tail, first = cut(document["segments"], progress.segment, progress.segment_s_m)
    is_inside = len(head) > first
    laps = _laps(tail)
    return [
        Piece(number, one["kind"], one["row"], length_m(one), is_inside and number == first, lap)
        for number, (one, lap) in enumerate(zip(tail, laps, strict=True), first)
        if is_work(one)
    ]


def _laps(segments: Sequence[Segment]) -> list[int]:
    """Return for each segment which lap it is of, 0 off the laps; where the tool switches a lap goes on.

    So it does in its corners, on the spot too: two laps never follow one another with the tool off.
    """
    found: list[int] = []
    count = 0
    for k, one in enumerate(segments):
        is_lap = one["kind"] == "headland"
        is_corner = k > 0 and not (one.get("tool_on") and segments[k - 1].get("tool_on"))
        goes_on = is_lap and k > 0 and found[k - 1] > 0 and (is_corner or not one.get("pivot"))
        count += is_lap and not goes_on
        found.append(count if is_lap else 0)
    return found


def is_work(segment: Segment) -> bool:
    """Say whether the tool works on a segment."""
    return bool(segment.get("tool_on")) and segment["kind"] in WORK_KINDS


def length_m(segment: Segment) -> float:
    """Return the length of a segment."""
    points = segment["points"]
    return sum(math.dist(a, b) for a, b in pairwise(points))


def _split(points: list[tuple[float, ...]], s_m: float) -> tuple[list[Any] | None, list[Any] | None]:
    """Return the points before and after ``s_m``; ``None`` for a part without length."""
    if s_m < SAME_M:
        return None, points
    done = 0.0
    for i, (a, b) in enumerate(pairwise(points)):
        step = math.dist(a, b)
        if done + step >= s_m and step > 0:
            t = (s_m - done) / step
            there = [round(a[0] + t * (b[0] - a[0]), DIGITS), round(a[1] + t * (b[1] - a[1]), DIGITS)]
            before = [list(p) for p in points[: i + 1]]
            after = [list(p) for p in points[i + 1 :]]
            if math.dist(before[-1], there) >= SAME_M or len(before) == 1:
                before.append(there)
            else:
                there = before[-1]
            is_at_end = math.dist(there, after[0]) < SAME_M and len(after) == 1
            return before, None if is_at_end else [there, *after]
        done += step
    return [list(p) for p in points], None
