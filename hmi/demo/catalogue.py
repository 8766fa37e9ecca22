"""The missions of the demo farm, planned from its map."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from hmi.demo.farm import POLDER, SITE, feature, features
from hmi.demo.fleet import robot
from hmi.domain.mission_plan import PlannedMission, PlanWish, Surroundings
from hmi.planning.mission import plan_mission


@dataclass(frozen=True, slots=True)
class DemoMission:
    """One mission of the demo: which field, by whom, how."""

    id: str
    name: str
    field_id: str
    robot_id: str
    width_m: float
    along_rows: bool = True
    headland_passes: int | None = None
    returns_home: bool = True


CATALOGUE = (
    DemoMission("trial-strip", "Trial strip, every row", "polder-strip", "weeder-01", 1.5, headland_passes=1),
    DemoMission("trial-strip-rows", "Trial strip, rows only", "polder-strip", "weeder-02", 1.5, headland_passes=0),
    DemoMission("polder-17-3m", "Polder 17, whole field", "polder-17", "weeder-01", 3.0, along_rows=False),
    *(
        DemoMission(f"{one.id}-05", f"{one.name}, 0.5 m", one.id, "weeder-03", 0.5)
        for one in features()
        if one.kind == "parcel" and one.properties["site"] == SITE
    ),
)
"""Missions ready to send: the whole parcel, a few minutes for showing, one for each section of the site."""


def plan(mission: DemoMission) -> PlannedMission:
    """Plan one mission of the catalogue as the console would."""
    field, machine = feature(mission.field_id), robot(mission.robot_id)
    return plan_mission(
        PlanWish(
            mission_id=mission.id,
            name=mission.name,
            robot_id=mission.robot_id,
            field_name=field.name,
            parcel=field.geometry,
            width_m=mission.width_m,
            datum_lat_deg=machine.datum_lat_deg,
            datum_lon_deg=machine.datum_lon_deg,
            angle_rad=row_angle(field.properties) if mission.along_rows else None,
            headland_passes=mission.headland_passes,
            home=machine.home,
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
    solid = [(one.geometry, 0.0) for one in near if one.kind in ("obstacle", "building")]
    ways = [(one.geometry, float(one.properties.get("width_m", 0.0))) for one in near if one.kind == "road"]
    return Surroundings(tuple(solid), tuple(ways))


__all__ = ["CATALOGUE", "POLDER", "SITE", "DemoMission", "plan", "row_angle", "surroundings"]
