"""Where a robot is and how it stands: by what it said, or what the console heard before anybody looked, if newer.

It is newer where the robot fell silent while nobody looked: a message may be left here from the last time somebody did.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from backend_clients.edge import machine
from backend_clients.edge import messages_up as up
from backend_clients.edge.topics import Up
from hmi.domain.machine import height_m
from hmi.twin.kinematics import Place
from hmi.twin.posture import Posture
from hmi.twin.rotation import yaw

if TYPE_CHECKING:
    from hmi.media.studio import Studio


@dataclass(frozen=True, slots=True)
class Limbs:
    """Joints as measured and as planned, and the height above the ground; ``at_s`` on this process's clock."""

    joints: Mapping[str, float]
    height_m: float
    at_s: float
    planned: Mapping[str, float] = field(default_factory=dict)


def posture_of(studio: Studio, robot_id: str) -> Posture | None:
    """Return where a robot is in the site's plane, ``None`` before it said so.

    It is as old as the older of what it is drawn from: an arm that stands still on the screen only is not live, and
    one of which a declared joint was not heard has no age at all, for it is drawn at rest.
    """
    factsheet = studio.intake.newest(robot_id, Up.FACTSHEET, up.Factsheet)
    stand = _stand(studio, robot_id)
    if factsheet is None or stand is None:
        return None
    sheet, (x_m, y_m, theta_rad, at_s) = factsheet[0], stand
    east, north = studio.frame.shift(sheet.datum.lat_deg, sheet.datum.lon_deg)
    limbs = limbs_of(studio, robot_id)
    unheard = _unheard(studio, sheet, limbs)
    if limbs is None:
        place = Place((x_m + east, y_m + north, 0.0), yaw(theta_rad))
        return Posture(place, at_s=None if unheard else at_s, unheard=unheard)
    place = Place((x_m + east, y_m + north, limbs.height_m), yaw(theta_rad))
    seen_s = min(at_s, limbs.at_s) if sheet.joints else at_s
    return Posture(place, limbs.joints, limbs.planned, None if unheard else seen_s, unheard)


def limbs_of(studio: Studio, robot_id: str) -> Limbs | None:
    """Return how a robot's joints stand, ``None`` where nobody heard."""
    heard, last = studio.intake.newest(robot_id, Up.BODY, machine.Body), studio.last(robot_id)
    if last is not None and last.joints_at_s is not None and (heard is None or heard[1] < last.joints_at_s):
        return Limbs(last.joints, last.height_m, last.joints_at_s)
    if heard is None:
        return None
    body, at_s = heard
    return Limbs(body.joints, height_m(body.gauges) or 0.0, at_s, body.planned)


def _stand(studio: Studio, robot_id: str) -> tuple[float, float, float, float] | None:
    """Metres east and north of its datum, ENU yaw, and when."""
    heard, last = studio.intake.newest(robot_id, Up.TELEMETRY, up.Telemetry), studio.last(robot_id)
    if last is not None and (heard is None or heard[1] < last.at_s):
        return last.x_m, last.y_m, last.theta_rad, last.at_s
    if heard is None:
        return None
    said, at_s = heard
    return said.x_m, said.y_m, said.theta_rad, at_s


def _unheard(studio: Studio, sheet: up.Factsheet, limbs: Limbs | None) -> tuple[str, ...]:
    """The declared joints that were not heard; one that the model does not move makes no picture wrong."""
    declared = [joint.name for joint in sheet.joints]
    if limbs is None:
        return tuple(declared)
    missing = [name for name in declared if name not in limbs.joints]
    moved = {one.name for one in studio.library.form(sheet).model.joints if one.moves} if missing else set()
    return tuple(name for name in missing if name in moved)
