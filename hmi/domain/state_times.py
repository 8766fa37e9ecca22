"""How long a robot was in which state of its supervisor, from what it told: pure.

A robot tells that it entered and left a state; the second carries how long it was in it. Either may be lost, a
robot may start anew without a word, and a state may still be active. What had to be guessed is marked.
"""

from __future__ import annotations

import bisect
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta

from hmi.domain.event import RobotEvent
from hmi.domain.state_chart import Chart, ChartState

SAME_S = 1.0
"""An entry and the start told at the end are one: both are mapped on our clock, which drifts by less."""
NEAR_S = 5.0
"""A stay that began this shortly after a robot was heard last began before the silence: it is heard once a second."""
ENTERED, LEFT = "state_entered", "state_left"


@dataclass(frozen=True, slots=True)
class Mark:
    """A state was entered or left."""

    at: datetime
    is_entry: bool
    state: str
    label: str
    subsystem: str
    path: tuple[str, ...]
    is_leaf: bool
    duration_s: float | None
    result: str


@dataclass(frozen=True, slots=True)
class Interval:
    """A stay in a state. ``end`` is ``None`` while it lasts; ``is_guessed``: its end was not told."""

    state: str
    label: str
    subsystem: str
    path: tuple[str, ...]
    is_leaf: bool
    start: datetime
    end: datetime | None
    result: str = ""
    is_guessed: bool = False

    def seconds(self, start: datetime, end: datetime) -> float:
        """Return how much of it lies in a span."""
        until = end if self.end is None else min(self.end, end)
        return max(0.0, (until - max(self.start, start)).total_seconds())


@dataclass(frozen=True, slots=True)
class Silence:
    """Nothing was heard of the robot from one moment to another: it may have been off."""

    start: datetime
    end: datetime


def mark_of(event: RobotEvent) -> Mark | None:
    """Return what an event says about a state; ``None`` for any other, and for one that makes no sense."""
    if event.kind not in (ENTERED, LEFT):
        return None
    data = event.data
    told = data.get("path")
    path = tuple(str(part) for part in told) if isinstance(told, list) and told else tuple(event.name.split(" > "))
    state = data.get("state")
    is_charted = isinstance(state, str) and bool(state)
    return Mark(
        at=event.at_utc,
        is_entry=event.kind == ENTERED,
        state=str(state) if is_charted else " > ".join(path),
        label=event.name if is_charted else path[-1],
        subsystem=str(data.get("subsystem") or "") if is_charted else path[0],
        path=path,
        is_leaf=data.get("is_leaf") is not False,
        duration_s=_duration_s(data.get("duration_ms")) if event.kind == LEFT else None,
        result=str(data.get("result") or ""),
    )


def intervals(
    marks: Iterable[Mark],
    chart: Chart | None = None,
    active: Mapping[str, datetime] | None = None,
    heard: datetime | None = None,
    silences: Sequence[Silence] = (),
) -> list[Interval]:
    """Return all stays, leaves and what holds them, by start.

    Args:
        chart: tells which states exclude each other; without one, those of the same parent path do.
        active: what the robot says is active now, since when; ``None`` if nothing is known of now.
        heard: when it was heard last: a stay whose end nobody told and that is over ended then at the latest.
        silences: when nothing was heard of it; the same holds for the one after such a stay began.
    """
    states = {one.id: one for one in chart.states} if chart else {}
    by_state: dict[str, list[Mark]] = defaultdict(list)
    for mark in sorted(marks, key=lambda one: one.at):
        by_state[mark.state].append(mark)
    told: list[Interval] = []
    begun: list[Interval] = []
    for same in by_state.values():
        ended, open_ones = _matched(same)
        told += ended
        begun += open_ones
    found = _closed(told, begun, states, active, heard, silences)
    found += _still_active(found, active or {}, states)
    return _apart(sorted(found, key=lambda one: (one.start, len(one.path))), states)


def _duration_s(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < 1e12:
        return None
    return value / 1000


def _matched(marks: Sequence[Mark]) -> tuple[list[Interval], list[Interval]]:
    """Return the stays of one state whose end was told, and those of which only the entry was."""
    entries = [one for one in marks if one.is_entry]
    taken = [False] * len(entries)
    times = [one.at for one in entries]
    ended = []
    for one in marks:
        if one.is_entry:
            continue
        start = one.at if one.duration_s is None else one.at - timedelta(seconds=one.duration_s)
        at = _entry_of(times, taken, start, one.at, is_exact=one.duration_s is not None)
        if at is not None:
            taken[at] = True
            start = times[at] if one.duration_s is None else start
        ended.append(_stay(one, start, one.at, one.result))
    return ended, [_stay(one, one.at, None, "") for one, is_taken in zip(entries, taken, strict=True) if not is_taken]


def _entry_of(
    times: Sequence[datetime], taken: Sequence[bool], start: datetime, end: datetime, *, is_exact: bool
) -> int | None:
    """Return which entry began a stay: the nearest to its start, or the last before its end."""
    if not is_exact:
        last = bisect.bisect_right(times, end) - 1
        return last if last >= 0 and not taken[last] else None
    near = timedelta(seconds=SAME_S)
    low, high = bisect.bisect_left(times, start - near), bisect.bisect_right(times, start + near)
    free = [i for i in range(low, high) if not taken[i]]
    return min(free, key=lambda i: abs(times[i] - start)) if free else None


def _stay(mark: Mark, start: datetime, end: datetime | None, result: str) -> Interval:
    return Interval(mark.state, mark.label, mark.subsystem, mark.path, mark.is_leaf, start, end, result)


def _group(one: Interval, states: Mapping[str, ChartState]) -> tuple[str, ...] | None:
    """Return what one of whose states is active at a time; ``None`` where several may be."""
    known = states.get(one.state)
    if known is None:
        return ("path", *one.path[:-1]) if one.state != " > ".join(one.path) else ("paths",)
    parent = states.get(known.parent) if known.parent else None
    if parent is not None and parent.kind == "parallel":
        return None
    return ("chart", known.parent or "")


class _Holders:
    """Stays of states that hold others, by path and start."""

    def __init__(self, stays: Iterable[Interval]) -> None:
        self._by_path: dict[tuple[str, ...], list[Interval]] = defaultdict(list)
        for one in stays:
            self.add(one)

    def add(self, one: Interval) -> None:
        """Take a stay in, if something may be in it."""
        if not one.is_leaf:
            bisect.insort(self._by_path[one.path], one, key=lambda other: other.start)

    def ends(self, one: Interval) -> list[datetime]:
        """Return when what holds a stay ended."""
        found = []
        for depth in range(1, len(one.path)):
            same = self._by_path.get(one.path[:depth], [])
            # entered together: told a moment apart
            until = one.start + timedelta(seconds=SAME_S)
            at = bisect.bisect_right(same, until, key=lambda other: other.start) - 1
            end = same[at].end if at >= 0 else None
            if end is not None and end >= one.start:
                found.append(end)
        return found


def _closed(
    told: list[Interval],
    begun: list[Interval],
    states: Mapping[str, ChartState],
    active: Mapping[str, datetime] | None,
    heard: datetime | None,
    silences: Sequence[Silence],
) -> list[Interval]:
    """Give every stay without a told end the earliest end that follows from the others."""
    starts: dict[tuple[str, ...], list[datetime]] = defaultdict(list)
    for one in (*told, *begun):
        group = _group(one, states)
        if group is not None:
            starts[group].append(one.start)
    for times in starts.values():
        times.sort()
    found, holders = list(told), _Holders(told)
    is_now_unknown = active is None and heard is None
    for one in sorted(begun, key=lambda one: (len(one.path), one.start)):  # what holds others first
        group = _group(one, states)
        after = _after(starts[group], one.start) if group is not None else None
        ends = [*holders.ends(one), *([after] if after is not None else [])]
        is_on = _is_since((active or {}).get(one.state), one.start)
        if not is_on:
            ends += _fell_silent(silences, one.start)
        stay = one
        if ends or not (is_now_unknown or is_on):
            stay = replace(one, end=min(ends) if ends else max(one.start, heard or one.start), is_guessed=True)
        found.append(stay)
        holders.add(stay)
    return found


def _fell_silent(silences: Sequence[Silence], start: datetime) -> list[datetime]:
    """Return when the robot fell silent in a stay; one that began while it was silent was told later, it was on."""
    near = timedelta(seconds=NEAR_S)
    return [max(start, one.start) for one in silences if one.start >= start - near][:1]


def _is_since(since: datetime | None, start: datetime) -> bool:
    return since is not None and abs((since - start).total_seconds()) <= SAME_S


def _after(times: Sequence[datetime], start: datetime) -> datetime | None:
    at = bisect.bisect_right(times, start)
    return times[at] if at < len(times) else None


def _still_active(
    found: Sequence[Interval], active: Mapping[str, datetime], states: Mapping[str, ChartState]
) -> list[Interval]:
    """Return the stays that last now and whose entry was lost."""
    lasting = {one.state for one in found if one.end is None}
    parents = {one.parent for one in states.values()}
    return [
        Interval(
            state,
            states[state].label,
            states[state].subsystem,
            path_of(state, states),
            state not in parents,
            since,
            None,
        )
        for state, since in active.items()
        if state in states and state not in lasting
    ]


def path_of(state: str, states: Mapping[str, ChartState]) -> tuple[str, ...]:
    """Return the labels of a state and what holds it, outermost first."""
    labels: list[str] = []
    seen: set[str] = set()
    at: str | None = state
    while at is not None and at in states and at not in seen:
        seen.add(at)
        labels.append(states[at].label)
        at = states[at].parent
    return tuple(reversed(labels))


def _apart(found: list[Interval], states: Mapping[str, ChartState]) -> list[Interval]:
    """Let states that exclude each other not overlap: the later one is right about when it began."""
    last: dict[tuple[str, ...], int] = {}
    for at, one in enumerate(found):
        group = _group(one, states)
        if group is None:
            continue
        before = last.get(group)
        if before is not None:
            previous = found[before]
            if previous.end is None or previous.end > one.start:
                is_slip = previous.end is not None and (previous.end - one.start).total_seconds() <= SAME_S
                is_guessed = previous.is_guessed or not is_slip
                found[before] = replace(previous, end=max(previous.start, one.start), is_guessed=is_guessed)
        last[group] = at
    return found
