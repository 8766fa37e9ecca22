"""The journal of alarms as REST carries it: lines, a table to take away, figures against their targets."""

from __future__ import annotations

import csv
import io
import statistics
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime
from typing import Any

from hmi.domain.alarm.catalogue import AlarmType
from hmi.domain.alarm.journal import Figures, Line
from hmi.domain.alarm.live_alarm import LiveAlarm
from hmi.domain.alarm.priority import Priority
from hmi.presenters.alarms import epoch_ms

COLUMNS = ("utc", "what", "priority", "alarm", "source", "title", "text", "by", "device", "alarm_id")
DAY_S = 86_400
_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def line(one: Line) -> dict[str, Any]:
    """Return one line of the journal."""
    return {
        "seq": one.id,
        "at": epoch_ms(one.at),
        "id": one.alarm_id,
        "code": one.code,
        "source": one.source,
        "name": one.name,
        "title": one.title,
        "what": one.what,
        "priority": one.priority,
        "by": one.by,
        "device": one.device,
        "text": one.text,
    }


def table(lines: Iterable[Line], *, has_head: bool) -> str:
    """Return lines as CSV; what a spreadsheet would take for a formula is kept as words."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\r\n")
    if has_head:
        writer.writerow(COLUMNS)
    for one in lines:
        row = (one.at.isoformat(timespec="milliseconds"), one.what, one.priority, one.code, one.name, one.title,
               one.text, one.by, one.device, one.alarm_id)  # fmt: skip
        writer.writerow([_plain(str(value)) for value in row])
    return out.getvalue()


def figures(
    found: Figures,
    live: Sequence[LiveAlarm],
    now: datetime,
    per_operator_hour: float | None,
    types: Mapping[str, AlarmType],
) -> dict[str, Any]:
    """Return the figures of the alarms screen; a share or median of nothing is ``None``."""
    shown = [one for one in live if one.alarm.is_annunciated]
    unseen = [one for one in shown if one.alarm.needs_seeing]
    shelves = [one.alarm.shelf for one in live if one.alarm.shelf is not None]
    standing = [one for one in shown if _age_s(one, now) > DAY_S]
    return {
        "per_10min": [{"at": epoch_ms(at), "count": count} for at, count in found.bins],
        "last_10min": found.last_10min,
        "unacknowledged": len(unseen),
        "oldest_unacknowledged_s": round(max((_age_s(one, now) for one in unseen), default=0)) if unseen else None,
        "standing_24h": len(standing),
        "shelved": len(shelves),
        "next_return": min((epoch_ms(one.until) or 0 for one in shelves), default=None),
        "mix_7d": _mix(found),
        "answer_median_s": statistics.median(found.answers_s) if found.answers_s else None,
        "top": [{"code": code, "title": types[code].title if code in types else code, "count": count}
                for code, count in found.top],
        "per_operator_hour": None if per_operator_hour is None else round(per_operator_hour, 2),
        "flood_share": round(found.flood_s / found.span_s, 4),
        "raised_7d": found.raised,
        "stale": sum(1 for one in standing if not one.alarm.needs_seeing),
        "chattering": sum(1 for one in live if one.is_chattering),
        "targets": {"last_10min": 1, "flood": 10, "standing_24h": 5, "mix": [0.05, 0.15, 0.80], "answer_s": 120,
                    "per_operator_hour": 6, "flood_share": 0.01},
    }  # fmt: skip


def _mix(found: Figures) -> dict[str, float] | None:
    if not found.raised:
        return None
    return {str(int(level)): round(found.mix.get(int(level), 0) / found.raised, 4) for level in Priority}


def _age_s(live: LiveAlarm, now: datetime) -> float:
    return (now - live.alarm.raised_at).total_seconds() if live.alarm.raised_at is not None else 0.0


def _plain(text: str) -> str:
    return "'" + text if text.startswith(_FORMULA) else text
