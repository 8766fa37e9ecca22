"""Device (dataModel.Device): a robot's cloud agent is there, and what an order has to echo."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from backend_clients.cloud_robot.names import PRESENCE, presence_ref
from backend_clients.ngsi import entity as make
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.errors import Unreadable

EVERY_S = 5.0
CHALLENGE_LIFE_S = 30.0  # the way through a cloud takes seconds; a mission document alone never moves anything


@dataclass(frozen=True, slots=True)
class Presence:
    """What an agent says of itself; ``at`` is by the robot's clock and only for people."""

    robot: str
    challenge: str
    at: datetime

    def to_entity(self, farm: str) -> Entity:
        """Return the entity."""
        return Entity(
            ref=presence_ref(farm, self.robot),
            attributes={
                "category": make.structured(["actuator"]),
                "controlledProperty": make.structured(["movementActivity"]),
                "value": make.text(self.challenge),
                "deviceState": make.text("ok"),
                "dateLastValueReported": make.date_time(self.at),
            },
        )


def read_presence(entity: Entity, robot: str) -> Presence:
    """Return the presence of an entity; raises ``Unreadable``."""
    challenge, at = entity.value("value"), entity.attributes.get("dateLastValueReported")
    if entity.ref.type != PRESENCE or not isinstance(challenge, str) or at is None:
        raise Unreadable(f"{entity.ref.id[:80]} is no agent")
    if not 8 <= len(challenge) <= 64:
        raise Unreadable(f"{entity.ref.id[:80]} has no usable challenge")
    return Presence(robot, challenge, at.moment())
