"""What a camera of a robot would see now: the look and the scene, taken from the simulated world."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from backend_clients.edge import messages_up as up
from backend_clients.simulator.cameras.bent_rows import BentRows, is_bent, leading_row
from backend_clients.simulator.cameras.mounts import MOUNTS
from backend_clients.simulator.cameras.scene import Crane, Line, Look, Scene, Thing
from backend_clients.simulator.cameras.scenery import Scenery, scene_of
from backend_clients.simulator.crane import BOOM_M, HEAD_M, PILLAR_X_M, PILLAR_Z_M
from backend_clients.simulator.machine import Machine
from backend_clients.simulator.mission_run import MissionRun
from backend_clients.simulator.planting_site import to_enu
from backend_clients.simulator.terrain import height_m
from backend_clients.simulator.world import SimRobot
from hmi.clock import Clock

NEAR_M = 90.0
TRAIL_M, TRAIL_STEP_M = 26.0, 0.5
TREATED_M = 16.0
LEAN_SPAN_M = 2.0
MORNING_UTC_MS = 1_782_036_000_000  # 21 June 2026, 10:00: the sun is half-way up
CURVE_M = 0.12  # a machine's springs smooth the ground


def morning_ms(lon_deg: float) -> int:
    """Return the moment of that morning at a place, by the sun."""
    return MORNING_UTC_MS - round(lon_deg / 15 * 3_600_000)


@dataclass(slots=True)
class Setting:
    """What was set on one camera."""

    lamp: bool | None = None
    zoom: float = 1.0
    shot_s: float = -math.inf
    shots: int = 0


@dataclass(slots=True)
class Observer:
    """Takes looks.

    Args:
        scenery: the farm's map, empty in the open.
        is_always_day: the light of a summer morning at any hour.
    """

    robots: Mapping[str, SimRobot]
    clock: Clock
    scenery: Scenery
    is_always_day: bool = False
    settings: dict[tuple[str, str], Setting] = field(default_factory=dict)
    _bent: dict[str, tuple[str, BentRows | None]] = field(default_factory=dict)

    def setting(self, robot_id: str, camera: str) -> Setting:
        """Return what is set on a camera."""
        return self.settings.setdefault((robot_id, camera), Setting())

    def take(
        self, robot: SimRobot, camera: up.Camera, width_px: int, *, is_hasty: bool = False
    ) -> tuple[Look, Callable[[], Scene]]:
        """Return how a camera looks now, and what makes the scene it looks at; see ``Look`` for ``is_hasty``."""
        machine, boot = robot.machine, robot.boot
        run = boot.brain.run if boot is not None else None
        setting = self.setting(robot.config.id, camera.id)
        now_s = self.clock.mono_s()
        x, y, theta = _pose(robot, now_s)
        width = max(min(width_px, camera.width_px), 64) // 2 * 2
        pose = machine.limbs.pose if machine.limbs is not None else {}
        bent = self._bent_rows(robot, run)
        look = Look(
            scene=self.scenery.key(robot.config, run),
            robot=robot.config.id,
            camera=camera.id,
            family=robot.config.family,
            width_px=width,
            height_px=round(width * camera.height_px / camera.width_px / 2) * 2,
            wall_ms=self.wall_ms(robot),
            x_m=x,
            y_m=y,
            theta_rad=theta,
            z_m=machine.height_m,
            lean_rad=0.0 if robot.config.family == "uav" else lean_rad(x, y, theta),
            pan_rad=pose.get("pan", 0.0),
            tilt_rad=pose.get("tilt", -0.2),
            zoom=setting.zoom,
            lamp=setting.lamp,
            age_of_shot_s=min(now_s - setting.shot_s, 1e9),
            is_tool_on=machine.tool_on,
            is_unsure=machine.is_unsure,
            treated=_treated(run, (x, y), bent) if robot.config.family == "weeder" else [],
            trail=_trail(run, (x, y)),
            things=self._things(robot, (x, y)),
            crane=_crane(machine),
            sun_ms=morning_ms(robot.config.datum_lon_deg) if self.is_always_day else None,
            is_hasty=is_hasty,
            rows=bent.near((x, y)) if bent is not None else None,
        )
        return look, lambda: scene_of(self.scenery, robot.config, run)

    def wall_ms(self, robot: SimRobot) -> int:
        """Return the robot's wall clock."""
        return int((self.clock.utc().timestamp() + robot.faults.wall_offset_s) * 1000)

    def _bent_rows(self, robot: SimRobot, run: MissionRun | None) -> BentRows | None:
        """Return the rows of its mission if they lie along a curve."""
        if run is None or robot.config.family == "planter":
            return None
        key, found = self._bent.get(robot.config.id, ("", None))
        if key != run.sha256:
            leg = leading_row(run.route)
            found = None
            if leg is not None and is_bent(run.route, leg):
                found = BentRows(run.route, leg, *self.scenery.crop_of(run.mission.field_name))
            self._bent[robot.config.id] = (run.sha256, found)
        return found

    def _things(self, robot: SimRobot, here: tuple[float, float]) -> list[Thing]:
        found = []
        for other in self.robots.values():
            if other.config.datum_lat_deg != robot.config.datum_lat_deg:
                continue
            base, machine = other.machine.base, other.machine
            if machine.person is not None and math.dist(machine.person, here) < NEAR_M:
                found.append(Thing("person", *machine.person))
            if other is not robot and math.dist((base.x_m, base.y_m), here) < NEAR_M:
                found.append(Thing(other.config.family, base.x_m, base.y_m, base.theta_rad, machine.height_m))
            if (
                machine.rig is not None
                and machine.rig.site is not None
                and math.dist((base.x_m, base.y_m), here) < NEAR_M
            ):
                site = machine.rig.site
                found += [
                    Thing(one.kind, one.x_m, one.y_m, height_m=one.height_m, radius_m=one.radius_m)
                    for one in site.obstacles
                ]
                found += [Thing("tree", one.x_m, one.y_m, state=one.status) for one in site.targets]
        return found


def camera_of(cameras: Sequence[up.Camera], camera_id: str) -> up.Camera | None:
    """Return a camera of a robot by its id."""
    return next((one for one in cameras if one.id == camera_id), None)


def node_of(family: str, camera_id: str) -> str:
    """Return the software node a camera needs."""
    return MOUNTS[(family, camera_id)].node


def lean_rad(x_m: float, y_m: float, theta_rad: float) -> float:
    """Return how much a machine's nose is up on the ground it stands on."""
    dx, dy = math.cos(theta_rad) * LEAN_SPAN_M / 2, math.sin(theta_rad) * LEAN_SPAN_M / 2
    return math.atan((height_m(x_m + dx, y_m + dy) - height_m(x_m - dx, y_m - dy)) / LEAN_SPAN_M) * CURVE_M * 2


def _pose(robot: SimRobot, now_s: float) -> tuple[float, float, float]:
    """Return where it is now: the world moves in steps, a picture falls between two of them."""
    base = robot.machine.base
    since_s = min(max(now_s - robot.stepped_s, 0.0), 0.2) * robot.pace
    far = base.speed_mps * since_s
    theta = base.theta_rad + base.yaw_rate_radps * since_s
    return base.x_m + far * math.cos(theta), base.y_m + far * math.sin(theta), theta


def _treated(run: MissionRun | None, here: tuple[float, float], bent: BentRows | None) -> list[Line]:
    """Return the stretches near a place on which the tool was on."""
    if run is None or run.status == "loaded":
        return []
    s_m, found = run.tracker.s_m, []
    for leg in run.route.legs:
        if leg.own_start_m >= s_m:
            break
        if not leg.is_tool_on:
            continue
        if bent is not None:
            found += bent.worked(leg, s_m, here, TREATED_M)
            continue
        a, b = run.route.point_at(leg.own_start_m), run.route.point_at(min(leg.end_m, s_m))
        if _away(here, a, b) < TREATED_M:
            found.append((*a, *b))
    return found


def _trail(run: MissionRun | None, here: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the way it came, as far as a camera sees it."""
    if run is None or run.status in ("loaded",) or run.tracker.s_m < 1.0:
        return []
    s_m = run.tracker.s_m
    if math.dist(run.route.point_at(s_m), here) > 1.0:
        return []
    many = int(min(TRAIL_M, s_m) / TRAIL_STEP_M)
    return [here] + [run.route.point_at(s_m - k * TRAIL_STEP_M) for k in range(1, many + 1)]


def _crane(machine: Machine) -> Crane | None:
    rig = machine.rig
    if rig is None:
        return None
    pose, base = rig.crane.pose, machine.base
    cos, sin = math.cos(pose["slew"]), math.sin(pose["slew"])

    def place(reach_m: float, z_m: float) -> tuple[float, float, float]:
        return (*to_enu(base, (PILLAR_X_M - reach_m * cos, -reach_m * sin)), z_m)

    boom_m, boom_z = BOOM_M * math.cos(pose["boom"]), PILLAR_Z_M + BOOM_M * math.sin(pose["boom"])
    tip = rig.crane.tip
    east, north = to_enu(base, tip[:2])
    current = rig.site.current if rig.site is not None else None
    return Crane(
        joints=[place(0.0, PILLAR_Z_M), place(boom_m, boom_z), (east, north, tip[2] + HEAD_M), (east, north, tip[2])],
        heading_rad=base.theta_rad + pose["slew"] + pose["rotator"],
        is_loaded=rig.in_head > 0,
        state=current.status if current is not None else "",
    )


def _away(point: tuple[float, float], a: tuple[float, float], b: tuple[float, float]) -> float:
    dx, dy = b[0] - a[0], b[1] - a[1]
    t = min(max(((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / max(dx * dx + dy * dy, 1e-9), 0.0), 1.0)
    return math.dist(point, (a[0] + t * dx, a[1] + t * dy))
