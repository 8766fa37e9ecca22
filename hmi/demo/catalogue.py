"""The missions of the demo farm, planned from its map."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from hmi.demo.farm import POLDER, SITE, feature, features
from hmi.demo.fleet import robot
from hmi.domain.map_ground import CLOSED_KINDS, CROSSED_KINDS
from hmi.domain.mission_plan import PlannedMission, PlanWish, Surroundings

SITE_DATUM = (40.312546, -3.48086)


@dataclass(frozen=True, slots=True)
class DemoMission:
    """One mission of the demo: which field, by whom, how. ``home_id`` is the robot's own where it is left out."""

    id: str
    name: str
    field_id: str
    robot_id: str
    width_m: float
    along_rows: bool = True
    headland_passes: int | None = None
    returns_home: bool = True
    home_id: str = ""


CATALOGUE = (
    DemoMission("trial-strip", "Trial strip, every row", "polder-strip", "weeder-01", 1.5, headland_passes=1),
    DemoMission("trial-strip-rows", "Trial strip, rows only", "polder-strip", "weeder-02", 1.5, headland_passes=0),
    DemoMission("polder-17-3m", "Polder 17, whole field", "polder-17", "weeder-01", 3.0, along_rows=False),
)
"""Missions ready to send: the whole parcel, and a few minutes for showing."""
PAST = (DemoMission("site-wheat-2-05", "Wheat 2, 0.5 m", "site-wheat-2", "weeder-03", 0.5, home_id="site-home"),)
"""Missions of which only the record is kept: no robot of the demo stands at that site any more."""


def plan(mission: DemoMission) -> PlannedMission:
    """Plan one mission of the catalogue as the console would."""
    from hmi.planning.mission import plan_mission  # a farm whose missions are stored starts without the planner

    field, machine = feature(mission.field_id), robot(mission.robot_id)
    home = feature(mission.home_id or machine.home_id).geometry["coordinates"]
    is_site = field.properties["site"] == SITE
    lat_deg, lon_deg = SITE_DATUM if is_site else (machine.datum_lat_deg, machine.datum_lon_deg)
    return plan_mission(
        PlanWish(
            mission_id=mission.id,
            name=mission.name,
            robot_id=mission.robot_id,
            field_name=field.name,
            parcel=field.geometry,
            width_m=mission.width_m,
            datum_lat_deg=lat_deg,
            datum_lon_deg=lon_deg,
            angle_rad=row_angle(field.properties) if mission.along_rows else None,
            headland_passes=mission.headland_passes,
            home=(float(home[0]), float(home[1])),
            returns_home=mission.returns_home,
            surroundings=surroundings(field.properties["site"]),
        )
    )


def row_angle(properties: dict[str, Any]) -> float | None:
    """Return the ENU direction of a field's crop rows, ``None`` if the map does not say."""
    bearing = properties.get("row_bearing_deg")
    return None if bearing is None else math.pi / 2 - math.radians(float(bearing))


def surroundings(site: str) -> Surroundings:
    """Return obstacles and ways of one site; a field may be crossed on the way to another."""
    near = [one for one in features() if one.properties["site"] == site]
    closed = [one for one in near if one.kind in CLOSED_KINDS]
    solid = [(one.geometry, _width(one.properties)) for one in closed if one.kind not in CROSSED_KINDS]
    crossed = [(one.geometry, _width(one.properties)) for one in closed if one.kind in CROSSED_KINDS]
    ways = [(one.geometry, float(one.properties.get("width_m", 0.0))) for one in near if one.kind == "road"]
    return Surroundings(tuple(solid), tuple(ways), tuple(crossed))


def _width(properties: dict[str, Any]) -> float:
    return float(properties.get("width_m", 2 * properties.get("radius_m", 0.0)))


__all__ = ["CATALOGUE", "PAST", "POLDER", "SITE", "SITE_DATUM", "DemoMission", "plan", "row_angle", "surroundings"]
