"""Alarms as the lane and REST carry them: an entry for each, the summary, the words of a type."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import Any

from hmi.domain.alarm.alarm import CONSOLE
from hmi.domain.alarm.catalogue import AlarmType
from hmi.domain.alarm.live_alarm import LiveAlarm, Step
from hmi.domain.alarm.priority import Priority
from hmi.presenters.units import milliseconds

CONSOLE_NAME = "Headland"


def name_of(source: str, robot_name: str | None) -> str:
    """Return what people call the source of an alarm."""
    return CONSOLE_NAME if source == CONSOLE else robot_name or source


def entry(live: LiveAlarm, name: str) -> dict[str, Any]:
    """Return one alarm as the lane carries it; see docs/protocols/lane.md."""
    alarm, kind = live.alarm, live.type
    return {
        "code": alarm.key.code,
        "source": alarm.key.source,
        "detail": alarm.key.detail,
        "name": name,
        "title": title_of(live),
        "text": alarm.text,
        "priority": int(live.priority),
        "state": alarm.state.value,
        "raised": epoch_ms(alarm.raised_at),
        "t": milliseconds(live.raised_s),
        "returned": epoch_ms(alarm.returned_at),
        "seen_by": alarm.seen_by,
        "seen_at": epoch_ms(alarm.seen_at),
        "who": kind.who,
        "steps": words(kind, alarm.advice)["steps"] if live.priority is Priority.CRITICAL else [],
        "latching": alarm.is_latching,
        "first": live.first or live.id,
        "place": live.place,
        "group": live.group,
        "shelf": _shelf(live),
        "out_of_service": _out(live),
        "occurrences": alarm.occurrences,
        "chattering": live.is_chattering,
        "escalated": epoch_ms(live.escalated_at),
    }


def title_of(live: LiveAlarm) -> str:
    """Return the few words that name it; a fault nobody has words for is named by the robot's own."""
    if live.alarm.key.code == "robot-fault" and live.alarm.text:
        return live.alarm.text.rstrip(".")[:60]
    return live.type.title


def summary(
    counts: Mapping[Priority, tuple[int, int]], flood: tuple[datetime, int] | None, checked_s: float
) -> dict[str, Any]:
    """Return the summary: counts by priority, the flood if there is one, when the supervision last looked."""
    return {
        "counts": {str(int(level)): list(pair) for level, pair in counts.items()},
        "flood": None if flood is None else {"since": epoch_ms(flood[0]), "count": flood[1]},
        "checked": milliseconds(checked_s),
    }


def event(step: Step, name: str) -> dict[str, Any]:
    """Return one step in an alarm's life as a lane event."""
    return {
        "kind": "alarm",
        "what": step.what.value,
        "id": step.live.id,
        "priority": int(step.live.priority),
        "state": step.live.alarm.state.value,
        "title": title_of(step.live),
        "name": name,
        "by": step.by,
    }


def words(kind: AlarmType, advice: str = "") -> dict[str, Any]:
    """Return what the catalogue says about a type; ``advice`` of the source comes before its steps."""
    return {
        "code": kind.code,
        "title": kind.title,
        "priority": int(kind.priority),
        "cause": kind.cause,
        "consequence": kind.consequence,
        "steps": [*([advice] if advice else []), *kind.steps],
        "who": kind.who,
        "latching": kind.is_latching,
        "follows_from": sorted(kind.follows_from),
    }


def epoch_ms(at: datetime | None) -> int | None:
    """Return a time as UTC epoch ms, as the lane carries times of records."""
    return None if at is None else round(at.timestamp() * 1000)


def _shelf(live: LiveAlarm) -> dict[str, Any] | None:
    shelf = live.alarm.shelf
    return None if shelf is None else {"by": shelf.by, "reason": shelf.reason, "until": epoch_ms(shelf.until)}


def _out(live: LiveAlarm) -> dict[str, Any] | None:
    out = live.alarm.out_of_service
    return None if out is None else {"by": out.by, "reason": out.reason, "at": epoch_ms(out.at)}
