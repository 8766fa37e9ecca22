"""CommandReturnMessage (dataModel.AutonomousMobileRobot): what the robot did with an order."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from backend_clients.cloud_robot.mission_order import MissionOrder, Waypoints, waypoint_list
from backend_clients.cloud_robot.names import ANSWER, COMMAND, OWN, answer_ref
from backend_clients.ngsi import entity as make
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.errors import Unreadable

IGNORED = frozenset({"stale_challenge", "expired", "retained"})
"""Codes of orders that came too late: the model calls that ``ignore``."""


@dataclass(frozen=True, slots=True)
class MissionAnswer:
    """The robot's answer.

    Args:
        sha256: of what it stored, empty if it stored nothing.
        command_at: when the order was made, by the console's clock.
        received_at: when the robot had it, by the robot's clock.
    """

    robot: str
    order_id: str
    is_accepted: bool
    code: str
    text: str
    sha256: str
    command_at: datetime
    received_at: datetime
    waypoints: Waypoints = ()

    @classmethod
    def to(
        cls, order: MissionOrder, *, is_accepted: bool, code: str, text: str, sha256: str, received_at: datetime
    ) -> MissionAnswer:
        """Return the answer to an order."""
        return cls(order.robot, order.order_id, is_accepted, code, text, sha256, order.at, received_at,
                   order.waypoints)  # fmt: skip

    def to_entity(self, farm: str) -> Entity:
        """Return the entity."""
        result = "ack" if self.is_accepted else "ignore" if self.code in IGNORED else "error"
        errors: list[str] = [] if self.is_accepted else [f"{self.code}: {self.text}"]
        own = {"robot": self.robot, "order": self.order_id, "code": self.code, "text": self.text, "sha256": self.sha256}
        return Entity(
            ref=answer_ref(farm, self.robot, self.order_id),
            attributes={
                "commandTime": make.date_time(self.command_at),
                "receivedTime": make.date_time(self.received_at),
                "receivedCommand": make.text(COMMAND),
                "receivedWaypoints": make.structured(waypoint_list(self.waypoints)),
                "result": make.text(result),
                "errors": make.structured(list(errors)),
                OWN: make.structured(dict(own)),
            },
        )


def read_answer(entity: Entity) -> MissionAnswer:
    """Return the answer of an entity; raises ``Unreadable``."""
    own, result = entity.value(OWN), entity.value("result")
    if entity.ref.type != ANSWER or not isinstance(own, dict) or result not in ("ack", "error", "ignore"):
        raise Unreadable(f"{entity.ref.id[:80]} is no answer")
    if not all(isinstance(own.get(key), str) for key in ("robot", "order", "code", "text", "sha256")):
        raise Unreadable(f"{entity.ref.id[:80]} does not say what became of the order")
    try:
        command_at, received_at = (entity.attributes[key].moment() for key in ("commandTime", "receivedTime"))
    except KeyError as error:
        raise Unreadable(f"{entity.ref.id[:80]} says no time") from error
    words = {key: str(own[key])[:400] for key in ("robot", "order", "code", "text", "sha256")}
    return MissionAnswer(words["robot"], words["order"], result == "ack", words["code"], words["text"],
                         words["sha256"], command_at, received_at)  # fmt: skip
