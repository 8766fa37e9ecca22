"""What moves an alarm on. Each function takes an alarm and gives the next one; what is not allowed says why.

::

    condition comes    normal, returned, latched -> unacknowledged
    condition goes     unacknowledged -> returned
                       acknowledged -> latched if it latches, else normal
    seen               unacknowledged -> acknowledged
                       returned -> latched if it latches, else normal
    cleared            latched -> normal
    more urgent        acknowledged -> unacknowledged; critical ends shelf and, unless an admin set it, out of service

Acknowledging means "I have seen it". Nothing here resets or moves a machine.
Source: ANSI/ISA-18.2-2016, figure of the alarm state transition; IEC 62682:2022.
"""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime, timedelta

from hmi.domain.alarm.alarm import Alarm, AlarmState, OutOfService, Phase, Shelf
from hmi.domain.alarm.priority import Priority

MAX_SHELF = timedelta(hours=12)  # a shift; what lasts longer is taken out of service, with a work order
MIN_REASON, MAX_REASON = 3, 200


class AlarmRefused(Exception):
    """An alarm cannot be moved on like this now.

    Args:
        code: stable machine-readable reason.
        text: one sentence for a person.
    """

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code, self.text = code, text


def condition_comes(alarm: Alarm, at: datetime, text: str = "") -> Alarm:
    """The condition holds. While it held already, only the words change."""
    if alarm.is_active:
        return replace(alarm, text=text or alarm.text)
    return replace(
        alarm,
        phase=Phase.UNACKNOWLEDGED,
        text=text or alarm.text,
        raised_at=at,
        returned_at=None,
        seen_by="",
        seen_at=None,
        occurrences=alarm.occurrences + 1,
    )


def condition_goes(alarm: Alarm, at: datetime) -> Alarm:
    """The condition holds no more. One that nobody saw stays until somebody has."""
    if not alarm.is_active:
        return alarm
    if alarm.phase is Phase.UNACKNOWLEDGED:
        return replace(alarm, phase=Phase.RETURNED, returned_at=at)
    return _gone(replace(alarm, returned_at=at))


def priority_rises(alarm: Alarm, to: Priority) -> Alarm:
    """It is more urgent than what people answered: they answer anew, and what is critical is not put aside."""
    out = alarm.out_of_service
    if to is Priority.CRITICAL:
        out = out if out is not None and out.holds_critical else None
        alarm = replace(alarm, shelf=None, out_of_service=out)
    if alarm.phase is not Phase.ACKNOWLEDGED:
        return alarm
    return replace(alarm, phase=Phase.UNACKNOWLEDGED, seen_by="", seen_at=None)


def acknowledge(alarm: Alarm, by: str, at: datetime) -> Alarm:
    """Note that a person has seen it; seen twice is seen once.

    Raises:
        AlarmRefused: it is not shown to people now.
    """
    if alarm.state in (AlarmState.SHELVED, AlarmState.SUPPRESSED, AlarmState.OUT_OF_SERVICE):
        raise AlarmRefused("not_shown", f"It is {_WORDS[alarm.state]}. Bring it back first.")
    if not alarm.needs_seeing:
        return alarm
    seen = replace(alarm, seen_by=by, seen_at=at)
    return replace(seen, phase=Phase.ACKNOWLEDGED) if alarm.is_active else _gone(seen)


def clear(alarm: Alarm) -> Alarm:
    """End one that latches, after its condition went away and it was seen.

    Raises:
        AlarmRefused: the condition still holds, or nobody has seen it.
    """
    if alarm.is_active:
        raise AlarmRefused("still_active", "What raised it is still so. Mend that first.")
    if alarm.phase is Phase.RETURNED:
        raise AlarmRefused("not_seen", "Acknowledge it first.")
    return _normal(alarm) if alarm.phase is Phase.LATCHED else alarm


def shelve(alarm: Alarm, priority: Priority, by: str, reason: str, at: datetime, until: datetime) -> Alarm:
    """Put it aside for a while.

    Raises:
        AlarmRefused: it is critical, the time is not between now and 12 h, or no reason is given.
    """
    if priority is Priority.CRITICAL:
        raise AlarmRefused("critical", "An alarm of priority 1 cannot be shelved.")
    if not at < until <= at + MAX_SHELF:
        raise AlarmRefused("bad_time", "Shelve it for up to 12 hours.")
    if alarm.out_of_service is not None:
        raise AlarmRefused("out_of_service", "It is out of service already.")
    return replace(alarm, shelf=Shelf(by, _reason(reason), at, until))


def unshelve(alarm: Alarm) -> Alarm:
    """Bring it back; one whose condition holds asks for attention again."""
    return alarm if alarm.shelf is None else _shown_again(replace(alarm, shelf=None))


def pass_time(alarm: Alarm, now: datetime) -> Alarm:
    """Bring it back when its time on the shelf is over, or the clock was set to before it was put there."""
    shelf = alarm.shelf
    return alarm if shelf is None or shelf.at <= now < shelf.until else unshelve(alarm)


def suppress(alarm: Alarm, cause: str) -> Alarm:
    """Say nothing of it while ``cause`` lasts: it follows from that by design."""
    return replace(alarm, suppressed_by=alarm.suppressed_by | {cause})


def end_suppression(alarm: Alarm, cause: str) -> Alarm:
    """Let it speak again once the last cause is gone."""
    if cause not in alarm.suppressed_by:
        return alarm
    rest = replace(alarm, suppressed_by=alarm.suppressed_by - {cause})
    return rest if rest.suppressed_by else _shown_again(rest)


def take_out(alarm: Alarm, by: str, reason: str, at: datetime, *, holds_critical: bool = False) -> Alarm:
    """Take it out of service until somebody puts it back; it leaves the shelf.

    Raises:
        AlarmRefused: no reason is given.
    """
    return replace(alarm, out_of_service=OutOfService(by, _reason(reason), at, holds_critical), shelf=None)


def put_back(alarm: Alarm) -> Alarm:
    """Put it back into service; one whose condition holds asks for attention again."""
    return alarm if alarm.out_of_service is None else _shown_again(replace(alarm, out_of_service=None))


def _gone(alarm: Alarm) -> Alarm:
    return replace(alarm, phase=Phase.LATCHED) if alarm.is_latching else _normal(alarm)


def _normal(alarm: Alarm) -> Alarm:
    return replace(alarm, phase=Phase.NORMAL, occurrences=0)


def _shown_again(alarm: Alarm) -> Alarm:
    """What was seen before it was hidden has to be seen anew: somebody else may sit here now."""
    if alarm.phase is not Phase.ACKNOWLEDGED or not alarm.is_annunciated:
        return alarm
    return replace(alarm, phase=Phase.UNACKNOWLEDGED, seen_by="", seen_at=None)


def _reason(text: str) -> str:
    reason = " ".join(text.split())
    if not MIN_REASON <= len(reason) <= MAX_REASON:
        raise AlarmRefused("no_reason", "Say why, in 3 to 200 characters.")
    return reason


_WORDS = {
    AlarmState.SHELVED: "shelved",
    AlarmState.SUPPRESSED: "suppressed by design",
    AlarmState.OUT_OF_SERVICE: "out of service",
}
