"""The farm around the robots, from map features, as the scene one robot drives through."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from backend_clients.simulator.cameras.bent_rows import is_bent, leading_row
from backend_clients.simulator.cameras.map_feature import MapFeature
from backend_clients.simulator.cameras.scene import Ground, Point, Rows, Scene, Solid
from backend_clients.simulator.cameras.shapes import disc
from backend_clients.simulator.config import RobotConfig
from backend_clients.simulator.enu import EnuFrame
from backend_clients.simulator.mission_run import MissionRun

SPACING_M = 0.5
USUAL_CROP = "Sugar beet"
NEAR_DEG = 0.03
HIGH_M = {"building": 4.5, "hedge": 3.2, "pylon": 16.0, "stone": 1.2, "weather": 2.5, "gate": 1.3}
SHAPES = frozenset({"Point", "LineString", "Polygon"})
GROUND_OF = {"road": "road", "water": "water", "no-go": "grass"}


@dataclass(slots=True)
class Scenery:
    """The farm's map."""

    features: Sequence[MapFeature] = ()

    def key(self, config: RobotConfig, run: MissionRun | None) -> str:
        """Return what names the scene of a robot; it changes with the robot's mission."""
        return f"{config.id}/{run.sha256 if run is not None else ''}"

    def crop_of(self, field_name: str) -> tuple[str, float]:
        """Return crop and row spacing of a field by its name."""
        for one in self.features:
            if one.kind == "parcel" and one.name == field_name:
                return str(one.properties.get("crop", USUAL_CROP)), float(
                    one.properties.get("row_spacing_m", SPACING_M)
                )
        return USUAL_CROP, SPACING_M


def scene_of(scenery: Scenery, config: RobotConfig, run: MissionRun | None) -> Scene:
    """Return the ground and solids around a robot; rows of its own field lie as its mission drives them."""
    frame = EnuFrame(config.datum_lat_deg, config.datum_lon_deg)
    grounds: list[Ground] = []
    solids: list[Solid] = []
    for one in scenery.features:
        if run is not None and one.kind == "parcel" and one.name == run.mission.field_name:
            continue
        _place(one, frame, grounds, solids)
    # fields first: roads lie over their edges
    grounds.sort(key=lambda ground: {"field": 0, "forest": 0, "grass": 1, "water": 2}.get(ground.kind, 3))
    if run is not None:
        own = _own_field(scenery, config, run, frame)
        grounds.insert(0, own)
    return Scene(scenery.key(config, run), config.datum_lat_deg, config.datum_lon_deg, grounds, solids)


def _own_field(scenery: Scenery, config: RobotConfig, run: MissionRun, frame: EnuFrame) -> Ground:
    ring = _ring(run.mission.parcel[0], frame)
    crop, spacing_m = scenery.crop_of(run.mission.field_name)
    if config.family == "planter":  # what it plants is not there yet
        return Ground("forest", ring)
    leg = leading_row(run.route)
    if leg is None:
        return Ground("field", ring, Rows(crop, spacing_m, 0.0, ring[0]))
    a, b = run.route.point_at(leg.own_start_m), run.route.point_at(leg.end_m)
    rows = Rows(crop, spacing_m, math.atan2(b[1] - a[1], b[0] - a[0]), a)
    return Ground("field", ring, rows, is_bent=is_bent(run.route, leg))


def _place(one: MapFeature, frame: EnuFrame, grounds: list[Ground], solids: list[Solid]) -> None:
    shape, at = one.geometry["type"], one.geometry["coordinates"]
    if shape not in SHAPES or one.kind == "rows":  # lines to drive by are nothing to see
        return
    first = at if shape == "Point" else at[0] if shape == "LineString" else at[0][0]
    if abs(first[1] - frame.lat_deg) > NEAR_DEG or abs(first[0] - frame.lon_deg) > NEAR_DEG:
        return
    if shape == "Polygon":
        ring = _ring(at[0], frame)
    elif shape == "LineString":
        ring = widened(_ring(at, frame), float(one.properties.get("width_m", 4.0)))
    else:
        ring = disc(*_ring([at], frame)[0], float(one.properties.get("radius_m", 0.25)), 8)
    if one.kind == "parcel":
        grounds.append(_field(one, ring))
    elif one.kind in GROUND_OF:
        is_yard = one.kind == "road" and shape == "Polygon"
        grounds.append(Ground("yard" if is_yard else GROUND_OF[one.kind], ring))
    elif one.kind in {"hedge", "building"}:
        solids.append(Solid(one.kind, ring, HIGH_M[one.kind]))
    elif one.kind == "obstacle":
        _obstacle(one, ring, grounds, solids)


def _obstacle(one: MapFeature, ring: list[Point], grounds: list[Ground], solids: list[Solid]) -> None:
    word = one.name.lower()
    if "pond" in word:
        grounds.append(Ground("water", ring))
    elif "pylon" in word:
        solids.append(Solid("pylon", ring, HIGH_M["pylon"]))
    else:
        solids.append(Solid("stone", ring, HIGH_M["weather" if "weather" in word else "stone"]))


def _field(one: MapFeature, ring: list[Point]) -> Ground:
    spacing_m = float(one.properties.get("row_spacing_m", SPACING_M))
    bearing = math.pi / 2 - math.radians(float(one.properties.get("row_bearing_deg", 0.0)))
    return Ground("field", ring, Rows(str(one.properties.get("crop", USUAL_CROP)), spacing_m, bearing, ring[0]))


def _ring(points: Sequence[Sequence[float]], frame: EnuFrame) -> list[Point]:
    found = [frame.to_enu(point[1], point[0]) for point in points]
    return found[:-1] if len(found) > 2 and math.dist(found[0], found[-1]) < 1e-6 else found


def widened(line: Sequence[Point], wide_m: float) -> list[Point]:
    """Return a line as a strip; corners are mitred, sharp ones not further than twice its width."""
    left, right = [], []
    for n, (x, y) in enumerate(line):
        before, after = line[max(n - 1, 0)], line[min(n + 1, len(line) - 1)]
        ways = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in ((before, (x, y)), ((x, y), after)) if a != b]
        turn = math.remainder(ways[-1] - ways[0], 2 * math.pi) / 2
        way, half = ways[0] + turn, wide_m / 2 / max(math.cos(turn), 0.5)
        left.append((x - half * math.sin(way), y + half * math.cos(way)))
        right.append((x + half * math.sin(way), y - half * math.cos(way)))
    return left + right[::-1]
