"""All alarms that are not normal, or put aside, with a revision that tells what changed since when.

Lives on the event loop; nothing here blocks or waits. Every step in the life of an alarm is told to ``listeners``,
who keep the journal, tell the screens and notify people.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from datetime import datetime, timedelta

from hmi.clock import Clock
from hmi.domain.alarm import life
from hmi.domain.alarm.alarm import CONSOLE, Alarm, AlarmKey, Phase
from hmi.domain.alarm.catalogue import AlarmType
from hmi.domain.alarm.conditions import Change, Turn
from hmi.domain.alarm.first_out import first_outs
from hmi.domain.alarm.flood import Flood
from hmi.domain.alarm.live_alarm import LiveAlarm, Step, What
from hmi.domain.alarm.priority import Priority
from hmi.store.errors import NotFound

MAX_BACKDATE_S = 60.0  # a condition is noticed within seconds; an older beginning is a clock gone wrong
MAX_ALARMS = 5000  # 1,000 robots with five each; what comes beyond is counted, and listed when there is room
ESCALATE_AFTER_S: Mapping[Priority, float] = {
    Priority.CRITICAL: 60.0,
    Priority.HIGH: 300.0,
    Priority.MEDIUM: 1800.0,
}
Listener = Callable[[Step], None]


ESCALATION = "escalation"


def escalation_of(stored: Mapping[str, float | None] | None) -> dict[Priority, float]:
    """Return the limits of a stored setting; what it does not name stays as it is by default, null is never."""
    given = {str(int(level)): ESCALATE_AFTER_S.get(level) for level in Priority} | dict(stored or {})
    return {Priority(int(level)): float(after) for level, after in given.items() if after is not None}


@dataclass(frozen=True, slots=True)
class Person:
    """Who acts on an alarm."""

    name: str
    device: str = ""


class AlarmStore:
    """Live alarms of one console.

    Args:
        types: the catalogue.
    """

    def __init__(self, clock: Clock, types: Mapping[str, AlarmType]) -> None:
        self._clock, self._types = clock, types
        self._live: dict[str, LiveAlarm] = {}
        self._at: dict[str, set[str]] = {}
        self._changed: dict[str, int] = {}
        self._flood = Flood()
        self.escalate_after_s: Mapping[Priority, float] = ESCALATE_AFTER_S
        self.listeners: list[Listener] = []
        self.revision = 0
        self.checked_s = clock.mono_s()
        self.dropped = 0
        self._left_out: dict[str, Change] = {}

    def get(self, alarm_id: str) -> LiveAlarm:
        """Return one alarm; raises ``NotFound`` when it is normal or never was."""
        try:
            return self._live[alarm_id]
        except KeyError:
            raise NotFound(f"there is no alarm {alarm_id!r} now") from None

    def find(self, alarm_id: str) -> LiveAlarm | None:
        """Return one alarm, ``None`` when it is normal."""
        return self._live.get(alarm_id)

    def all(self) -> list[LiveAlarm]:
        """Return every alarm that is not normal or put aside, oldest first."""
        return sorted(self._live.values(), key=lambda one: one.raised_s)

    def of(self, source: str) -> list[LiveAlarm]:
        """Return the alarms of a robot, a station or the console."""
        return [self._live[i] for i in sorted(self._at.get(source, ()))]

    def since(self, revision: int) -> dict[str, LiveAlarm | None]:
        """Return what changed after ``revision``; ``None`` is normal again."""
        found: dict[str, LiveAlarm | None] = {}
        for alarm_id in reversed(self._changed):
            if self._changed[alarm_id] <= revision:
                break
            found[alarm_id] = self._live.get(alarm_id)
        return found

    def flood(self) -> tuple[float, int] | None:
        """Return since when (monotonic seconds) more alarms come than a person reads, and how many; else ``None``."""
        now_s = self._clock.mono_s()
        count = self._flood.count(now_s)
        return None if self._flood.since_s is None else (self._flood.since_s, count)

    def counts(self) -> dict[Priority, tuple[int, int]]:
        """Return for each priority how many are shown as active, and how many of all shown nobody has seen."""
        active, unseen = dict.fromkeys(Priority, 0), dict.fromkeys(Priority, 0)
        for one in self._live.values():
            if one.alarm.is_annunciated:
                active[one.priority] += one.alarm.is_active
                unseen[one.priority] += one.alarm.awaits_answer
        return {level: (active[level], unseen[level]) for level in Priority}

    # ---- conditions ----

    def apply(self, changes: Iterable[Change]) -> None:
        """Take over what came and went."""
        for change in changes:
            match change.turn:
                case Turn.COMES:
                    self._comes(change)
                case Turn.GOES:
                    self._goes(change)
                case Turn.REWORDED:
                    self._reworded(change)
            if change.key.source == CONSOLE and change.turn is not Turn.REWORDED:
                self._suppress_by(change.key.code, is_on=change.turn is Turn.COMES)

    def restore(
        self, alarm: Alarm, unanswered_at: datetime | None = None, escalated_at: datetime | None = None
    ) -> bool:
        """Take over an alarm from before a restart; ``False`` if the catalogue does not know it any more.

        What a cause at the console kept silent then is silent again, whichever of them is restored first.
        """
        kind = self._types.get(alarm.key.code)
        if kind is None:
            return False
        live = LiveAlarm(alarm, kind, self._mono_of(alarm.raised_at))
        if alarm.awaits_answer:
            waits = unanswered_at or self._clock.utc()
            live = replace(live, unanswered_at=waits, unanswered_s=self._mono_of(waits), escalated_at=escalated_at)
        self._keep(live)
        causes = {one.alarm.key.code for one in self.of(CONSOLE) if one.alarm.is_active}
        for one in list(self._live.values()) if alarm.key.source == CONSOLE else [live]:
            if hiding := causes & one.type.suppressed_by:
                hidden = replace(one.alarm, suppressed_by=one.alarm.suppressed_by | hiding)
                self._keep(replace(one, alarm=hidden, unanswered_at=None, escalated_at=None))
        self._regroup(alarm.key.source)
        return True

    # ---- people ----

    def acknowledge(self, alarm_id: str, by: Person) -> LiveAlarm:
        """Note that somebody has seen it; raises ``NotFound``, ``AlarmRefused``."""
        live, now = self.get(alarm_id), self._clock.utc()
        seen = life.acknowledge(live.alarm, by.name, now)
        return live if seen is live.alarm else self._step(What.ACKNOWLEDGED, live, seen, by)

    def clear(self, alarm_id: str, by: Person) -> LiveAlarm:
        """End one that latches; raises ``NotFound``, ``AlarmRefused``."""
        live = self.get(alarm_id)
        cleared = life.clear(live.alarm)
        return live if cleared is live.alarm else self._step(What.CLEARED, live, cleared, by)

    def shelve(self, alarm_id: str, by: Person, reason: str, until: datetime) -> LiveAlarm:
        """Put one aside for a while; raises ``NotFound``, ``AlarmRefused``."""
        live, now = self.get(alarm_id), self._clock.utc()
        shelved = life.shelve(live.alarm, live.priority, by.name, reason, now, until)
        return self._step(What.SHELVED, live, shelved, by, reason)

    def unshelve(self, alarm_id: str, by: Person) -> LiveAlarm:
        """Bring one back; raises ``NotFound``."""
        live = self.get(alarm_id)
        back = life.unshelve(live.alarm)
        return live if back is live.alarm else self._step(What.UNSHELVED, live, back, by)

    def take_out(self, alarm_id: str, by: Person, reason: str, *, holds_critical: bool = False) -> LiveAlarm:
        """Take one out of service; raises ``NotFound``, ``AlarmRefused``."""
        live = self.get(alarm_id)
        out = life.take_out(live.alarm, by.name, reason, self._clock.utc(), holds_critical=holds_critical)
        return self._step(What.OUT_OF_SERVICE, live, out, by, reason)

    def put_back(self, alarm_id: str, by: Person) -> LiveAlarm:
        """Put one back into service; raises ``NotFound``."""
        live = self.get(alarm_id)
        back = life.put_back(live.alarm)
        return live if back is live.alarm else self._step(What.IN_SERVICE, live, back, by)

    def release(self, source: str, text: str) -> None:
        """End what was put aside at a source that is no more; the next one of its name begins with nothing aside."""
        for live in self.of(source):
            if live.alarm.shelf is not None:
                self._step(What.UNSHELVED, live, life.unshelve(live.alarm), text=text)
            elif live.alarm.out_of_service is not None:
                self._step(What.IN_SERVICE, live, life.put_back(live.alarm), text=text)

    # ---- time and design ----

    def pass_time(self) -> None:
        """Bring back what lay on the shelf long enough, escalate what nobody answers; call it once a second."""
        now, now_s = self._clock.utc(), self._clock.mono_s()
        self.checked_s = now_s
        self._flood.pass_time(now_s)
        self._let_in()
        for live in list(self._live.values()):
            back = life.pass_time(live.alarm, now)
            if back is not live.alarm:
                self._step(What.UNSHELVED, live, back)
            elif self._waits_too_long(live, now_s):
                self._step(What.ESCALATED, replace(live, escalated_at=now), live.alarm)

    def _suppress_by(self, cause: str, *, is_on: bool) -> None:
        """Say nothing more of what was raised already and follows by design from a cause at the console."""
        for live in list(self._live.values()):
            if is_on and cause in live.type.suppressed_by and cause not in live.alarm.suppressed_by:
                self._step(What.SUPPRESSED, live, life.suppress(live.alarm, cause), text=cause)
            elif not is_on and cause in live.alarm.suppressed_by:
                self._step(What.UNSUPPRESSED, live, life.end_suppression(live.alarm, cause), text=cause)

    def _mono_of(self, at: datetime | None) -> float:
        """Return a moment before the restart on the monotonic clock of now."""
        now = self._clock.utc()
        return self._clock.mono_s() - max(0.0, (now - (at or now)).total_seconds())

    def _waits_too_long(self, live: LiveAlarm, now_s: float) -> bool:
        limit_s = self.escalate_after_s.get(live.priority)
        is_waiting = live.escalated_at is None and live.alarm.awaits_answer
        return is_waiting and limit_s is not None and now_s - live.unanswered_s >= limit_s

    def _comes(self, change: Change) -> None:
        kind, finding = self._types[change.key.code], change.finding
        live = self._live.get(change.key.id)
        if live is None and not self._has_room(change):
            self.dropped += change.key.id not in self._left_out
            self._left_out[change.key.id] = change
            return
        self._left_out.pop(change.key.id, None)
        now, now_s = self._clock.utc(), self._clock.mono_s()
        since_s = finding.since_s if finding.since_s is not None else now_s
        since_s = min(now_s, max(since_s, now_s - MAX_BACKDATE_S))
        before = live.alarm if live is not None else Alarm(change.key, is_latching=kind.is_latching)
        raised = life.condition_comes(before, now - timedelta(seconds=now_s - since_s), finding.text)
        raised = replace(raised, priority=finding.priority, advice=finding.advice)
        new = LiveAlarm(raised, kind, since_s, is_chattering=change.is_chattering)
        if live is not None:
            new = replace(new, escalated_at=live.escalated_at)
        text = ""
        if live is not None and new.priority < live.priority:
            raised, text = life.priority_rises(raised, new.priority), _was(live, raised.text)
        if raised.is_annunciated:
            self._flood.raised(now_s)
        self._step(What.RAISED, new, raised, text=text)

    def _has_room(self, change: Change) -> bool:
        """Say whether one more is listed. Priority 1 and the console's own always are, but what a robot can invent."""
        finding = change.finding
        is_urgent = (finding.priority or self._types[change.key.code].priority) is Priority.CRITICAL
        is_urgent = is_urgent or change.key.source == CONSOLE
        if finding.detail:
            return len(self._live) < (2 * MAX_ALARMS if is_urgent else MAX_ALARMS)
        return is_urgent or len(self._live) < MAX_ALARMS

    def _let_in(self) -> None:
        """List what found no room when it came and holds still, the oldest first."""
        while self._left_out and len(self._live) < MAX_ALARMS:
            self._comes(next(iter(self._left_out.values())))

    def _goes(self, change: Change) -> None:
        self._left_out.pop(change.key.id, None)
        live = self._live.get(change.key.id)
        if live is not None and live.alarm.is_active:
            gone = life.condition_goes(live.alarm, self._clock.utc())
            self._step(What.RETURNED, replace(live, is_chattering=False), gone)

    def _reworded(self, change: Change) -> None:
        live = self._live.get(change.key.id)
        if live is None:
            if change.key.id in self._left_out:
                self._comes(change)
            return
        said = replace(live.alarm, text=change.finding.text or live.alarm.text, priority=change.finding.priority)
        new = replace(live, alarm=said, is_chattering=change.is_chattering)
        if new.priority < live.priority:
            self._rises(live, new)
        elif new != live:
            self._keep(new)

    def _rises(self, before: LiveAlarm, new: LiveAlarm) -> None:
        risen = life.priority_rises(new.alarm, new.priority)
        if risen.is_annunciated:
            self._flood.raised(self._clock.mono_s())
        self._step(What.RAISED, new, risen, text=_was(before, risen.text), rose_from=before.priority)

    def _step(
        self,
        what: What,
        live: LiveAlarm,
        after: Alarm,
        by: Person | None = None,
        text: str = "",
        rose_from: Priority | None = None,
    ) -> LiveAlarm:
        now = self._clock.utc()
        before = self._live.get(live.id)
        unanswered_at = before.unanswered_at if before is not None else None
        is_begun = what is What.RAISED and rose_from is None
        new = self._waiting(replace(live, alarm=after), before, now, is_begun=is_begun)
        if rose_from is not None:
            new = replace(new, escalated_at=None)  # it is judged by another limit now
        self._keep(new)
        self._regroup(after.key.source)
        new = self._live.get(new.id, new)
        person = by or Person("")
        step = Step(what, new, now, person.name, person.device, text, unanswered_at, rose_from)
        for listener in self.listeners:
            listener(step)
        return new

    def _waiting(self, live: LiveAlarm, before: LiveAlarm | None, now: datetime, *, is_begun: bool) -> LiveAlarm:
        """Note since when it waits for an answer; coming back before anybody saw it begins no new wait."""
        if not live.alarm.awaits_answer:
            return replace(live, unanswered_at=None, escalated_at=None)
        if before is not None and before.unanswered_at is not None:
            return replace(live, unanswered_at=before.unanswered_at, unanswered_s=before.unanswered_s)
        if is_begun:
            return replace(live, unanswered_at=live.alarm.raised_at, unanswered_s=live.raised_s)
        return replace(live, unanswered_at=now, unanswered_s=self._clock.mono_s())

    def _keep(self, live: LiveAlarm) -> None:
        alarm = live.alarm
        is_kept = alarm.phase is not Phase.NORMAL or alarm.shelf is not None or alarm.out_of_service is not None
        if is_kept:
            self._live[live.id] = live
            self._at.setdefault(alarm.key.source, set()).add(live.id)
        elif self._live.pop(live.id, None) is not None:
            self._at[alarm.key.source].discard(live.id)
        self._touch(live.id)

    def _touch(self, alarm_id: str) -> None:
        self.revision += 1
        self._changed.pop(alarm_id, None)
        self._changed[alarm_id] = self.revision
        if len(self._changed) > 2 * MAX_ALARMS:
            gone = [i for i in self._changed if i not in self._live]
            for one in gone[: MAX_ALARMS // 2]:
                del self._changed[one]

    def _regroup(self, source: str) -> None:
        """Number the alarms of a source anew under what came first."""
        here = {i: self._live[i] for i in self._at.get(source, ()) if self._live[i].alarm.phase is not Phase.NORMAL}
        if len(here) == 1:
            self._place(next(iter(here.values())), "", 1, 1)
            return
        by_key: dict[AlarmKey, str] = {one.alarm.key: i for i, one in here.items()}
        for group in first_outs([one.alarm for one in here.values()], self._follows_from):
            members = [group.first, *group.follows]
            for place, alarm in enumerate(members, 1):
                self._place(here[by_key[alarm.key]], group.first.key.id, place, len(members))

    def _place(self, live: LiveAlarm, first: str, place: int, group: int) -> None:
        if (live.first or live.id, live.place, live.group) != (first or live.id, place, group):
            self._live[live.id] = replace(live, first=first or live.id, place=place, group=group)
            self._touch(live.id)

    def _follows_from(self, code: str) -> frozenset[str]:
        return self._types[code].follows_from


def _was(before: LiveAlarm, text: str) -> str:
    """Return the words of the journal for an alarm that is more urgent than it was."""
    return f"Was priority {int(before.priority)}, {before.alarm.state.value.replace('_', ' ')}. {text}".strip()
