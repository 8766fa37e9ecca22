"""What happens once and must reach the cloud, made into pieces of the outbox as it happens."""

from __future__ import annotations

import json
from collections.abc import Callable
from datetime import datetime

from hmi.clock import Clock
from hmi.cloud.outbox import Piece, Rank
from hmi.domain.alarm.live_alarm import Step, What
from hmi.domain.event import RobotEvent
from hmi.domain.family import Family
from hmi.domain.mission import ENDED, UNDER_WAY, MissionStatus
from hmi.fiware.alert import alert_entity
from hmi.fiware.device import event_entity
from hmi.fiware.operation import Operation, operation_deleted, operation_entity
from hmi.fiware.urn import KeyValues, Urns
from hmi.store.missions import Mission

KEPT_EVENTS = frozenset({"alarm_raised", "alarm_cleared", "treatment", "mission", "safety", "mode"})
"""Not each state of a supervisor: a planter changes its states 46,000 times a day."""
_ALARM_STEPS = frozenset({What.RAISED, What.RETURNED, What.CLEARED})
_NOT_STANDING = frozenset({What.RETURNED, What.CLEARED})


class CloudNews:
    """Hears of events, missions and alarms on the event loop; never waits.

    Args:
        put: takes pieces, e.g. ``Backlog.put``.
        family_of: what machine a robot is, ``None`` if it has not told.
    """

    def __init__(
        self, urns: Urns, clock: Clock, put: Callable[[Piece], None], family_of: Callable[[str], Family | None]
    ) -> None:
        self._urns, self._clock, self._put, self._family_of = urns, clock, put, family_of
        self._missions: dict[str, tuple[MissionStatus, str, str, str | None]] = {}
        self._began: dict[str, datetime] = {}  # of missions that were seen to begin

    def see_event(self, event: RobotEvent) -> None:
        """Take an event of a registered robot."""
        if event.kind in KEPT_EVENTS:
            entity = event_entity(self._urns, event, self._model(event.robot_id))
            self._piece(event.robot_id, Rank.EVENT, event.at_utc, entity)

    def see_mission(self, mission: Mission) -> None:
        """Take a mission that changed; only what the cloud is told of it counts, not each row done."""
        key = (mission.status, mission.sha256, mission.name, mission.robot_id)
        before = self._missions.get(mission.id)
        if before == key:
            return
        self._missions[mission.id] = key
        if mission.status is MissionStatus.RUNNING and before is not None and before[0] not in UNDER_WAY:
            self._began[mission.id] = mission.updated_at
        elif mission.status not in UNDER_WAY | ENDED:
            self._began.pop(mission.id, None)
        self._piece(mission.robot_id or "farm", Rank.MISSION, mission.updated_at, self.operation(mission))

    def see_deleted(self, mission: Mission) -> None:
        """Take a mission that was deleted."""
        self._missions.pop(mission.id, None)
        entity = operation_deleted(self.operation(mission))
        self._piece(mission.robot_id or "farm", Rank.MISSION, self._clock.utc(), entity)

    def see_alarm(self, step: Step) -> None:
        """Take a step in the life of an alarm; what people answered stays here."""
        live = step.live
        raised_at = live.alarm.raised_at
        if step.what not in _ALARM_STEPS or raised_at is None:
            return
        entity = alert_entity(
            self._urns,
            live.id,
            live.alarm.key.source,
            live.alarm.text or live.type.title,
            priority=live.priority,
            raised_at=raised_at,
            state=live.alarm.phase.value,
            ended_at=(live.alarm.returned_at or step.at) if step.what in _NOT_STANDING else None,
        )
        self._piece(live.alarm.key.source, Rank.ALARM, step.at, entity)

    def operation(self, mission: Mission) -> KeyValues:
        """Return a mission as the cloud is told of it."""
        time_s = mission.statistics.get("time_s")
        robot_id = mission.robot_id or ""
        is_over = mission.status in ENDED
        return operation_entity(
            self._urns,
            Operation(
                mission_id=mission.id,
                name=mission.name,
                status=mission.status,
                revision=mission.revision,
                sha256=mission.sha256,
                planned_at=mission.created_at,
                changed_at=mission.updated_at,
                duration_s=float(time_s) if isinstance(time_s, int | float) else 0.0,
                field_id=mission.field_id or "",
                robot_id=robot_id,
                robot_model=self._model(robot_id),
                operation="inspection" if self._family_of(robot_id) is Family.UAV else "other",
                started_at=self._began.get(mission.id),
                ended_at=mission.updated_at if is_over else None,
            ),
        )

    def _model(self, robot_id: str) -> str:
        return "UnmannedAerialVehicle" if self._family_of(robot_id) is Family.UAV else "StateMessage"

    def _piece(self, stream: str, rank: Rank, at: datetime, entity: KeyValues) -> None:
        self._put(Piece(stream, rank, at.timestamp(), json.dumps(entity, ensure_ascii=False)))
