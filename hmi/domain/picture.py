"""Pictures that are kept as evidence: what was seen, when, where, during what work, and who kept it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from datetime import datetime
from enum import StrEnum

from hmi.domain.robot import OrderStatus, Robot

UNDER_WAY = (OrderStatus.RUNNING, OrderStatus.PAUSED)
_EAST_DEG = 90.0  # compass heading of ENU yaw 0


class PictureKind(StrEnum):
    """Why a picture is kept."""

    SNAPSHOT = "snapshot"
    """A person pressed the button."""
    CLIP = "clip"
    """Around an alarm or a STOP."""
    MISSION = "mission"
    """At the end of a row or every few minutes of a mission."""
    FRAME = "frame"
    """Sent by a field camera."""


ROUTINE = frozenset({PictureKind.MISSION, PictureKind.FRAME})
"""What comes by itself all day: it must not push evidence out."""


@dataclass(frozen=True, slots=True)
class Moment:
    """Where a robot was and what it did. ``theta_rad`` is ENU yaw; rows count from 1.

    Args:
        position_age_s: how old the position was when the picture was taken; negative if it was newer.
    """

    lat_deg: float | None = None
    lon_deg: float | None = None
    theta_rad: float | None = None
    position_age_s: float | None = None
    mission_id: str = ""
    mission_name: str = ""
    row: int | None = None

    @property
    def heading_deg(self) -> float | None:
        """Compass heading in degrees, 0 to 360, 90 is east."""
        return None if self.theta_rad is None else (_EAST_DEG - math.degrees(self.theta_rad)) % 360.0


@dataclass(frozen=True, slots=True)
class Picture:
    """One picture or clip in the evidence store; times aware UTC.

    Args:
        captured_at: when it was taken, or a clip's first picture.
        age_s: how old it was when it was asked for; ``None`` where the camera tells no age or nobody asked.
        duration_s: of a clip.
        cause: ``stop.<id>`` or ``alarm.<id>`` of what a clip is kept for; more than one are separated by spaces.
        text: what happened, in words.
        by: who kept it, empty for the console itself.
        is_kept: a person marked it: neither age nor size removes it.
    """

    id: str
    farm_id: str
    kind: PictureKind
    robot_id: str
    camera: str
    captured_at: datetime
    added_at: datetime
    media_type: str
    width_px: int
    height_px: int
    size_bytes: int
    sha256: str
    moment: Moment = Moment()
    age_s: float | None = None
    duration_s: float | None = None
    cause: str = ""
    text: str = ""
    note: str = ""
    by: str = ""
    device: str = ""
    is_kept: bool = False


def moment_of(robot: Robot | None, at_s: float, mission_name: str = "") -> Moment:
    """Return where a robot is and what it does, for a picture taken at ``at_s`` on the console's monotonic clock."""
    if robot is None:
        return Moment()
    found = Moment()
    if robot.telemetry is not None:
        pose = robot.telemetry.pose
        age_s = at_s - pose.stamp.source_s
        found = Moment(pose.lat_deg, pose.lon_deg, pose.theta_rad, age_s)
    order = None if robot.state is None else robot.state.order
    if order is None or order.status not in UNDER_WAY:
        return found
    return replace(found, mission_id=order.mission_id, mission_name=mission_name, row=order.row or None)
