"""CommandMessage (dataModel.AutonomousMobileRobot): here is a mission for you. It starts nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from backend_clients.cloud_robot.names import COMMAND, ORDER, OWN, order_ref
from backend_clients.cloud_robot.packing import packed, unpacked
from backend_clients.ngsi import entity as make
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.errors import Unreadable

MOST_WAYPOINTS = 500
Waypoints = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class MissionOrder:
    """One mission on its way to one robot.

    Args:
        order_id: the same order is carried out once.
        sha256: of the document; the robot answers with that of what it stored.
        challenge: the newest of the robot's agent, as its presence says: proves when this was decided.
        ttl_s: how old that challenge may be when the robot looks at it, on the robot's clock.
        document: the mission as on the direct way, JSON.
        waypoints: x and y in metres, for whoever looks into the broker; the robot drives by the document.
    """

    robot: str
    order_id: str
    mission_id: str
    revision: int
    sha256: str
    challenge: str
    ttl_s: float
    at: datetime
    document: bytes
    waypoints: Waypoints = ()

    def to_entity(self, farm: str) -> Entity:
        """Return the entity; raises ``BadInput`` if the mission is too large."""
        own: dict[str, Any] = {
            "robot": self.robot, "order": self.order_id, "mission": self.mission_id, "revision": self.revision,
            "sha256": self.sha256, "challenge": self.challenge, "ttl": self.ttl_s, "document": packed(self.document),
        }  # fmt: skip
        return Entity(
            ref=order_ref(farm, self.robot, self.order_id),
            attributes={
                "commandTime": make.date_time(self.at),
                "command": make.text(COMMAND),
                "waypoints": make.structured(waypoint_list(self.waypoints)),
                OWN: make.structured(own),
            },
        )


def waypoint_list(points: Sequence[tuple[float, float]]) -> list[Any]:
    """Return points as the models write them, thinned to what a person can look at."""
    step = max(1, -(-len(points) // MOST_WAYPOINTS))
    return [{"point2D": {"x": round(x, 3), "y": round(y, 3)}} for x, y in points[::step]]


def read_order(entity: Entity) -> MissionOrder:
    """Return the order of an entity; raises ``Unreadable``."""
    own = entity.value(OWN)
    if entity.ref.type != ORDER or entity.value("command") != COMMAND or not isinstance(own, dict):
        raise Unreadable(f"{entity.ref.id[:80]} carries no mission")
    at = entity.attributes.get("commandTime")
    try:
        return MissionOrder(
            robot=_text(own, "robot"),
            order_id=_text(own, "order"),
            mission_id=_text(own, "mission"),
            revision=int(own["revision"]),  # type: ignore[arg-type]  # anything else is refused below
            sha256=_text(own, "sha256"),
            challenge=_text(own, "challenge"),
            ttl_s=float(own["ttl"]),  # type: ignore[arg-type]
            at=make.Attribute.moment(at) if at is not None else _never(),
            document=unpacked(_text(own, "document", 10**6)),
            waypoints=_waypoints(entity.value("waypoints")),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise Unreadable(f"{entity.ref.id[:80]}: {type(error).__name__} {error}"[:200]) from error


def _never() -> datetime:
    raise Unreadable("an order without a time")


def _text(own: dict[str, Any], name: str, most: int = 128) -> str:
    value = own[name]
    if not isinstance(value, str) or not 0 < len(value) <= most:
        raise ValueError(f"{name} is not a text of 1 to {most} characters")
    return value


def _waypoints(value: object) -> Waypoints:
    if not isinstance(value, list) or len(value) > MOST_WAYPOINTS:
        return ()
    return tuple((float(one["point2D"]["x"]), float(one["point2D"]["y"])) for one in value)
