"""From what is found now to what comes and goes: delays, chattering, and what is held back by design.

Knows nothing of people. All times are seconds of one monotonic clock, handed in.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

from hmi.domain.alarm.alarm import CONSOLE, AlarmKey
from hmi.domain.alarm.catalogue import AlarmType
from hmi.domain.alarm.finding import Finding
from hmi.domain.alarm.priority import Priority
from hmi.domain.alarm.steady import Chatter, Steady
from hmi.domain.alarm.tuning import MOST_ON_CRITICAL_S

REWORD_S = 5.0  # values move all the time; a person reads a new one every few seconds
CALM_S = 60.0  # less urgent counts when it was so for a minute; more urgent counts at once
MAX_AT_SOURCE = 64  # a robot can invent fault codes and nodes; so many at once are not read by anybody
MAX_CRITICAL = 128  # room of their own: more than a robot can list and tell at once, and an end all the same


class Turn(StrEnum):
    """What a condition does."""

    COMES = "comes"
    GOES = "goes"
    REWORDED = "reworded"


@dataclass(frozen=True, slots=True)
class Change:
    """A condition that came, went or has other words now."""

    turn: Turn
    key: AlarmKey
    finding: Finding
    is_chattering: bool = False


@dataclass(slots=True)
class _Track:
    key: AlarmKey
    finding: Finding
    steady: Steady
    chatter: Chatter = field(default_factory=Chatter)
    is_so: bool = False
    is_raised: bool = False
    reworded_s: float = 0.0
    suppressed_by: frozenset[str] = frozenset()
    told: Priority = Priority.LOW
    told_s: float = 0.0

    def rises(self, urgency: Priority, now_s: float) -> bool:
        """Take in how urgent it is now; return whether that is more than was told."""
        is_more = urgency < self.told
        if urgency <= self.told or now_s - self.told_s >= CALM_S:
            self.told, self.told_s = urgency, now_s
        return is_more

    def words(self) -> Finding:
        """Return what is found, as urgent as was told."""
        finding = self.finding
        return finding if finding.priority in (None, self.told) else replace(finding, priority=self.told)


class Conditions:
    """All conditions of all sources that hold, held lately, or are waited for.

    Args:
        type_of: catalogue entry of a code. What its ``suppressed_by`` names holds it back as long as that is found
            at the console, also before it counts there.
    """

    def __init__(self, type_of: Callable[[str], AlarmType]) -> None:
        self._type_of = type_of
        self._sources: dict[str, dict[tuple[str, str], _Track]] = {}
        self._left_out: dict[str, set[tuple[str, str]]] = {}
        self.dropped = 0

    def see(self, source: str, findings: Sequence[Finding], now_s: float) -> list[Change]:
        """Take in everything that holds at a source now; return what comes and goes of it."""
        tracks = self._sources.get(source)
        if tracks is None:
            if not findings:
                return []
            tracks = self._sources[source] = {}
        for track in tracks.values():
            track.is_so = False
        left_out = set()
        for one in findings:
            seen = tracks.get((one.code, one.detail))
            if seen is None:
                if not self._has_room(tracks, source, one):
                    left_out.add((one.code, one.detail))
                    continue
                seen = self._add(tracks, source, one)
            if not seen.is_so:
                seen.is_so, seen.finding = True, one
        self._count(source, left_out)
        return self._settle(source, tracks, now_s)

    def pass_time(self, now_s: float) -> list[Change]:
        """Return what comes and goes because time passed; call it about once a second."""
        return [
            change for source, tracks in list(self._sources.items()) for change in self._settle(source, tracks, now_s)
        ]

    def restore(self, key: AlarmKey, finding: Finding) -> None:
        """Take over a condition that held before a restart; it goes when somebody sees that it is gone."""
        track = self._add(self._sources.setdefault(key.source, {}), key.source, finding)
        track.steady.is_on = track.is_raised = track.is_so = True
        track.told = self._urgency(finding)

    def retune(self) -> None:
        """Go by the delays that the types have now, also where a condition is under way."""
        for tracks in self._sources.values():
            for track in tracks.values():
                kind = self._type_of(track.key.code)
                track.steady.on_s, track.steady.off_s = kind.on_s, kind.off_s

    def forget(self, source: str) -> list[Change]:
        """Let everything of a source go that is no more."""
        tracks = self._sources.pop(source, {})
        self._left_out.pop(source, None)
        return [Change(Turn.GOES, t.key, t.finding) for t in tracks.values() if t.is_raised]

    def _has_room(self, tracks: dict[tuple[str, str], _Track], source: str, finding: Finding) -> bool:
        """Say whether one more is followed; only what a robot can make without end is ever left out."""
        if source == CONSOLE or not finding.detail:
            return True
        is_critical = self._urgency(finding) is Priority.CRITICAL
        others = [one for one in tracks.values() if one.key.detail]
        alike = sum((self._urgency(one.finding) is Priority.CRITICAL) is is_critical for one in others)
        return alike < (MAX_CRITICAL if is_critical else MAX_AT_SOURCE)

    def _count(self, source: str, left_out: set[tuple[str, str]]) -> None:
        """Count what is left out, each once as long as it holds."""
        before = self._left_out.pop(source, set())
        if left_out:
            self._left_out[source] = left_out
            self.dropped += len(left_out - before)

    def _add(self, tracks: dict[tuple[str, str], _Track], source: str, finding: Finding) -> _Track:
        kind = self._type_of(finding.code)
        key = AlarmKey(finding.code, source, finding.detail)
        track = tracks[finding.code, finding.detail] = _Track(
            key, finding, Steady(kind.on_s, kind.off_s), suppressed_by=kind.suppressed_by
        )
        return track

    def _settle(self, source: str, tracks: dict[tuple[str, str], _Track], now_s: float) -> list[Change]:
        changes = []
        for name, track in list(tracks.items()):
            change = self._step(track, now_s)
            if change is not None:
                changes.append(change)
            elif not (track.is_so or track.is_raised or track.steady.is_on or track.chatter.is_remembered(now_s)):
                del tracks[name]
        if not tracks:
            self._sources.pop(source, None)
        return changes

    def _step(self, track: _Track, now_s: float) -> Change | None:
        was_on, steady, chatter = track.steady.is_on, track.steady, track.chatter
        # a type may wait longer than what a robot itself calls critical
        most_on_s = MOST_ON_CRITICAL_S if self._urgency(track.finding) is Priority.CRITICAL else math.inf
        is_on = steady.see(is_so=track.is_so, now_s=now_s, most_on_s=most_on_s)
        if is_on != was_on:
            chatter.changed(is_on=is_on, now_s=now_s)
        was_chattering, is_chattering = chatter.is_chattering, chatter.pass_time(now_s)
        if not track.is_raised:
            # what was held back and is gone meanwhile is not raised after the fact
            if not (is_on and track.is_so) or self._is_held(track):
                return None
            track.is_raised, track.reworded_s = True, now_s
            track.told, track.told_s = self._urgency(track.finding), now_s
            return Change(Turn.COMES, track.key, track.finding, is_chattering)
        if not is_on and not is_chattering:
            track.is_raised = False
            return Change(Turn.GOES, track.key, track.finding)
        rises = track.is_so and track.rises(self._urgency(track.finding), now_s)
        if rises or is_chattering != was_chattering or (track.is_so and now_s - track.reworded_s >= REWORD_S):
            track.reworded_s = now_s
            return Change(Turn.REWORDED, track.key, track.words(), is_chattering)
        return None

    def _urgency(self, finding: Finding) -> Priority:
        return finding.priority or self._type_of(finding.code).priority

    def _is_held(self, track: _Track) -> bool:
        if not track.suppressed_by:
            return False
        causes = self._sources.get(CONSOLE, {})
        return any((one.is_so or one.steady.is_on) and code in track.suppressed_by for (code, _), one in causes.items())
