"""Where a robot is and how it stands: by what it said, or what the console heard before anybody looked, if newer.

It is newer where the robot fell silent while nobody looked: a message may be left here from the last time somebody did.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from backend_clients.edge import machine
from backend_clients.edge import messages_up as up
from backend_clients.edge.topics import Up
from hmi.domain.machine import HEIGHT_GAUGES, height_m
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
    stand = None if factsheet is None else _stand(studio, robot_id, factsheet[0].datum)
    if factsheet is None or stand is None:
        return None
    sheet, (east, north, theta_rad, at_s) = factsheet[0], stand
    limbs = limbs_of(studio, robot_id)
    unheard = unheard_of(studio, sheet, None if limbs is None else limbs.joints)
    declared = tuple(joint.name for joint in sheet.joints)
    if limbs is None:
        place = Place((east, north, 0.0), yaw(theta_rad))
        is_known = not unheard and not tells_height(sheet)
        body_at_s = -math.inf if tells_height(sheet) else at_s
        return Posture(place, {}, {}, at_s if is_known else None, unheard, body_at_s, None, declared)
    place = Place((east, north, limbs.height_m), yaw(theta_rad))
    body_at_s = min(at_s, limbs.at_s) if tells_height(sheet) else at_s
    seen_s = min(body_at_s, limbs.at_s) if sheet.joints else body_at_s
    return Posture(
        place, limbs.joints, limbs.planned, None if unheard else seen_s, unheard, body_at_s, limbs.at_s, declared
    )


def tells_height(sheet: up.Factsheet) -> bool:
    """Say whether how high it is above the ground comes with its joints."""
    return any(gauge.key in HEIGHT_GAUGES for gauge in sheet.gauges)


def limbs_of(studio: Studio, robot_id: str) -> Limbs | None:
    """Return how a robot's joints stand, ``None`` where nobody heard."""
    heard, last = studio.intake.newest(robot_id, Up.BODY, machine.Body), studio.last(robot_id)
    if last is not None and last.joints_at_s is not None and (heard is None or heard[1] < last.joints_at_s):
        return Limbs(last.joints, last.height_m, last.joints_at_s)
    if heard is None:
        return None
    body, at_s = heard
    return Limbs(body.joints, height_m(body.gauges) or 0.0, at_s, body.planned)


def _stand(studio: Studio, robot_id: str, datum: up.Datum) -> tuple[float, float, float, float] | None:
    """Metres east and north in the site's plane, ENU yaw, and when."""
    heard, last = studio.intake.newest(robot_id, Up.TELEMETRY, up.Telemetry), studio.last(robot_id)
    east, north = studio.frame.shift(datum.lat_deg, datum.lon_deg)
    if last is not None and (heard is None or heard[1] < last.at_s):
        if last.lat_lon_deg is not None:
            return *studio.frame.local(*last.lat_lon_deg), last.theta_rad, last.at_s
        return last.x_m + east, last.y_m + north, last.theta_rad, last.at_s
    if heard is None:
        return None
    said, at_s = heard
    return said.x_m + east, said.y_m + north, said.theta_rad, at_s


def unheard_of(studio: Studio, sheet: up.Factsheet, joints: Mapping[str, float] | None) -> tuple[str, ...]:
    """Return the declared joints that ``joints`` do not tell; one that the model does not move makes no picture wrong.

    All of them where nothing was heard (``None``).
    """
    declared = [joint.name for joint in sheet.joints]
    if joints is None:
        return tuple(declared)
    missing = [name for name in declared if name not in joints]
    moved = {one.name for one in studio.library.form(sheet).model.joints if one.moves} if missing else set()
    return tuple(name for name in missing if name in moved)
