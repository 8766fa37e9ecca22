"""Alert (dataModel.Alert): an alarm of the console while it stands, and when it went."""

from __future__ import annotations

from datetime import datetime

from hmi.domain.alarm.priority import Priority
from hmi.fiware.urn import OWN, KeyValues, Urns, moment, told

_SEVERITY = {
    Priority.CRITICAL: "critical", Priority.HIGH: "high", Priority.MEDIUM: "medium", Priority.LOW: "low",
}  # fmt: skip


def alert_entity(
    urns: Urns,
    alarm_id: str,
    source: str,
    text: str,
    *,
    priority: Priority,
    raised_at: datetime,
    state: str,
    ended_at: datetime | None = None,
) -> KeyValues:
    """Return one occurrence of an alarm: raised again, it is another entity, so that none is forgotten.

    Args:
        source: id of the robot or station, or ``console``.
        ended_at: when its condition went away; ``validTo`` then, and it is over.
    """
    return told(
        {
            "id": urns.of("Alert", f"{alarm_id}:{int(raised_at.timestamp() * 1000)}"),
            "type": "Alert",
            "category": "agriculture",
            "severity": _SEVERITY[priority],
            "alertSource": urns.of("Headland", source),
            "description": text,
            "dateIssued": moment(raised_at),
            "validFrom": moment(raised_at),
            "validTo": moment(ended_at) if ended_at is not None else None,
            OWN: {"state": state, "source": source},
        }
    )
