"""Which alarm came first and which ones follow from it, so that one cause is one line.

An alarm follows from another one of the same source if its type says so in the catalogue and it came at most a
while after. What came before its supposed cause is a cause of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import timedelta

from hmi.domain.alarm.alarm import Alarm

FOLLOWS_WITHIN = timedelta(seconds=30)
JITTER = timedelta(milliseconds=200)  # the same moment, seen by two parts of the console
FollowsFrom = Callable[[str], frozenset[str]]
"""Type code to the codes it may follow from."""


@dataclass(frozen=True, slots=True)
class FirstOut:
    """A cause and what follows from it, in the order in which they came."""

    first: Alarm
    follows: tuple[Alarm, ...] = ()


def first_outs(alarms: Sequence[Alarm], follows_from: FollowsFrom) -> list[FirstOut]:
    """Group raised alarms under their causes; groups in the order of their first alarm.

    Each alarm is in exactly one group; chains of consequences end in one group under the first of them.
    """
    by_source: dict[str, list[Alarm]] = {}
    for one in alarms:
        by_source.setdefault(one.key.source, []).append(one)
    found = [group for some in by_source.values() for group in _of_one_source(some, follows_from)]
    return sorted(found, key=lambda group: _came(group.first))


def _of_one_source(alarms: Sequence[Alarm], follows_from: FollowsFrom) -> list[FirstOut]:
    ordered = sorted((one for one in alarms if one.raised_at is not None), key=_came)
    causes = [_cause(ordered, index, follows_from(one.key.code)) for index, one in enumerate(ordered)]
    roots = [_root(index, causes) for index in range(len(ordered))]
    groups: dict[int, list[Alarm]] = {}
    for index, root in enumerate(roots):
        if root != index:
            groups.setdefault(root, []).append(ordered[index])
    return [FirstOut(ordered[i], tuple(groups.get(i, ()))) for i, root in enumerate(roots) if root == i]


def _root(index: int, causes: Sequence[int | None]) -> int:
    """Follow the causes to the first; where they lead in a circle, the earliest of it counts as first."""
    path = [index]
    while (cause := causes[path[-1]]) is not None:
        if cause in path:
            return min(path[path.index(cause) :])
        path.append(cause)
    return path[-1]


def _came(alarm: Alarm) -> tuple[float, str, str, str]:
    assert alarm.raised_at is not None
    return alarm.raised_at.timestamp(), alarm.key.code, alarm.key.source, alarm.key.detail


def _cause(ordered: Sequence[Alarm], index: int, causes: frozenset[str]) -> int | None:
    mine = ordered[index]
    assert mine.raised_at is not None
    best: int | None = None
    for other, alarm in enumerate(ordered):
        if other == index or alarm.key.code not in causes:
            continue
        assert alarm.raised_at is not None
        if alarm.raised_at - JITTER <= mine.raised_at <= alarm.raised_at + FOLLOWS_WITHIN:
            best = other if best is None else min(best, other)
    return best
