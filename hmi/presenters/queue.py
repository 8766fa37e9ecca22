"""Rows of the queue for screens and programs; times UTC, numbers SI."""

from __future__ import annotations

from dataclasses import asdict
from datetime import date, datetime
from typing import Any

from hmi.domain.queue.arming import Arming
from hmi.domain.queue.blackout import Blackout
from hmi.domain.queue.entry import Entry
from hmi.domain.queue.facts import Weather
from hmi.domain.queue.repeat import Repeat, RepeatKind
from hmi.domain.queue.waiting import Verdict


def utc_text(at: datetime | None) -> str | None:
    """Return a time as ISO 8601 with milliseconds."""
    return None if at is None else at.isoformat(timespec="milliseconds")


def entry_row(entry: Entry) -> dict[str, Any]:
    """Return an entry without what it waits for."""
    return {
        "id": entry.id,
        "robot_id": entry.robot_id,
        "mission_id": entry.mission_id,
        "is_unattended": entry.is_unattended,
        "earliest_utc": utc_text(entry.earliest),
        "window_s": entry.window_s,
        "repeat": None if entry.repeat is None else _repeat(entry.repeat),
        "conditions": asdict(entry.conditions),
        "state": entry.state.value,
        "why": entry.why,
        "added_by": entry.added_by,
        "added_utc": utc_text(entry.added_at),
        "started_utc": utc_text(entry.started_at),
        "ended_utc": utc_text(entry.ended_at),
    }


def waiting_row(verdict: Verdict, since: datetime) -> dict[str, Any]:
    """Return the one reason, with the next step of the queue."""
    waiting = verdict.waiting
    return {
        "code": waiting.code,
        "text": f"{waiting.text} {waiting.outlook}".strip(),
        "outlook": waiting.outlook,
        "clears": waiting.clears,
        "who": waiting.who.value,
        "clears_utc": utc_text(waiting.clears_at),
        "since_utc": utc_text(since),
        "step": verdict.step.value,
    }


def blackout_row(window: Blackout) -> dict[str, Any]:
    """Return a window; minutes on the farm's clock."""
    return {
        "id": window.id,
        "name": window.name,
        "days": sorted(window.days),
        "from_min": window.from_min,
        "to_min": window.to_min,
        "robots": list(window.robots),
    }


def arming_row(arming: Arming | None) -> dict[str, Any] | None:
    """Return who armed a queue and until when."""
    if arming is None:
        return None
    return {
        "id": arming.id,
        "by": arming.by,
        "revision": arming.revision,
        "armed_utc": utc_text(arming.armed_at),
        "until_utc": utc_text(arming.until),
    }


def weather_row(weather: Weather | None) -> dict[str, Any] | None:
    """Return the newest report of a station."""
    if weather is None:
        return None
    return {
        "station": weather.station,
        "utc": utc_text(weather.at),
        "rain_mm_h": weather.rain_mm_h,
        "wind_mps": weather.wind_mps,
    }


def repeat_of(fields: dict[str, Any]) -> Repeat:
    """Return the rule of plain values; raises ``ValueError`` for one that is none."""
    until = fields.get("until")
    last = None if until is None else date.fromisoformat(until)
    return Repeat(RepeatKind(fields["kind"]), frozenset(fields["days"]), fields["every_days"], last)


def _repeat(rule: Repeat) -> dict[str, Any]:
    until = None if rule.until is None else rule.until.isoformat()
    return {"kind": rule.kind.value, "days": sorted(rule.days), "every_days": rule.every_days, "until": until}
