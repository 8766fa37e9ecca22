"""AgriParcelOperation (dataModel.Agrifood): a mission, from planning to its result."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

from hmi.domain.mission import MissionStatus
from hmi.fiware.urn import OWN, KeyValues, Urns, moment, told

_S = MissionStatus
_STATUS = {
    _S.DRAFT: "planned", _S.VALIDATED: "planned", _S.QUEUED: "scheduled", _S.WAITING: "scheduled",
    _S.SENT: "scheduled", _S.ACCEPTED: "scheduled", _S.RUNNING: "ongoing", _S.PAUSED: "ongoing",
    _S.RESUMING: "ongoing", _S.DONE: "finished", _S.ABORTED: "cancelled", _S.FAILED: "cancelled",
}  # fmt: skip
_RESULT = {_S.DONE: "ok", _S.ABORTED: "aborted", _S.FAILED: "failed"}


@dataclass(frozen=True, slots=True)
class Operation:
    """What the cloud is told of a mission.

    Args:
        field_id: id of its parcel on our map, empty if it is drawn free of one.
        planned_at: when it was planned; its work is planned to take ``duration_s``.
        changed_at: when it came into its present status.
        robot_model: model of the robot's entity, e.g. ``StateMessage``.
        started_at, ended_at: of its newest life, ``None`` if not known.
    """

    mission_id: str
    name: str
    status: MissionStatus
    revision: int
    sha256: str
    planned_at: datetime
    changed_at: datetime
    duration_s: float = 0.0
    field_id: str = ""
    robot_id: str = ""
    robot_model: str = "StateMessage"
    operation: str = "other"
    started_at: datetime | None = None
    ended_at: datetime | None = None
    why: str = ""


def operation_entity(urns: Urns, work: Operation) -> KeyValues:
    """Return the mission; a mission without a parcel is said to be on the farm as a whole."""
    return told(
        {
            "id": urns.of("AgriParcelOperation", work.mission_id),
            "type": "AgriParcelOperation",
            "description": work.name,
            "hasAgriParcel": urns.of("AgriParcel", work.field_id) if work.field_id else urns.farm,
            "operationType": work.operation,
            "plannedStartAt": moment(work.planned_at),
            "plannedEndAt": moment(work.planned_at + timedelta(seconds=work.duration_s)),
            "status": _STATUS[work.status],
            "result": _RESULT.get(work.status),
            "startedAt": moment(work.started_at) if work.started_at else None,
            "endedAt": moment(work.ended_at) if work.ended_at else None,
            "reportedAt": moment(work.changed_at),
            "hasOperator": urns.of(work.robot_model, work.robot_id) if work.robot_id else None,
            OWN: _own(work),
        }
    )


def operation_deleted(entity: KeyValues) -> KeyValues:
    """Return the entity of a mission that was deleted here before it ran."""
    return {**entity, "status": "cancelled", OWN: {**entity[OWN], "status": "deleted"}}


def read_operation(urns: Urns, entity: KeyValues) -> tuple[str, MissionStatus] | None:
    """Return which mission of ours an entity is and its status there, ``None`` if it is none of ours."""
    mission_id = urns.name_of("AgriParcelOperation", str(entity.get("id", "")))
    own = entity.get(OWN)
    if mission_id is None or not isinstance(own, dict) or own.get("status") not in set(MissionStatus):
        return None
    return mission_id, MissionStatus(str(own["status"]))


def _own(work: Operation) -> dict[str, Any]:
    own = {"status": work.status.value, "revision": work.revision, "sha256": work.sha256}
    return own | ({"robot": work.robot_id} if work.robot_id else {}) | ({"why": work.why} if work.why else {})
