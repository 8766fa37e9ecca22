"""What the media process cannot know by itself: the farm's robots, their missions and parcels. Told when it changed."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime
from typing import Any

import msgspec

from hmi.app.media_link import MediaLink
from hmi.clock import Clock
from hmi.commands.ports import FleetReader
from hmi.domain.event import RobotEvent
from hmi.domain.freshness import STALE_S
from hmi.domain.machine import height_m
from hmi.domain.robot import Robot
from hmi.store.database import Database
from hmi.store.errors import NotFound, StoreError
from hmi.store.features import Features
from hmi.store.history import History, PosturePoint
from hmi.store.missions import Missions
from hmi.store.robots import Robots
from hmi.twin.farm import Farm, FarmRobot, Last, Plan, Swath, Treated

log = logging.getLogger(__name__)
MOST_TREATED = 5000
OUTCOMES = frozenset({"done", "failed_tool", "failed_ground", "failed_machine"})


class TwinNews:
    """Reads what stands in the database once for each mission and map, and passes it on."""

    def __init__(
        self,
        link: MediaLink,
        fleet: FleetReader,
        robots: Robots,
        missions: Missions,
        features: Features,
        history: History,
        database: Database,
        farm_id: str,
        clock: Clock,
    ) -> None:
        self._link, self._fleet, self._robots = link, fleet, robots
        self._missions, self._features, self._history = missions, features, history
        self._database, self._farm_id, self._clock = database, farm_id, clock
        self._born_s = clock.mono_s()
        self._points: dict[str, PosturePoint | None] = {}  # a robot that was not heard since is where it was recorded
        self._told_farm: tuple[Farm, int] | None = None
        self._told: dict[str, tuple[Any, ...]] = {}

    def forget(self, robot_id: str) -> None:
        """Tell everything of a robot again the next time."""
        self._told.pop(robot_id, None)
        self._told_farm = None

    async def tell(self, watched: Iterable[str]) -> Mapping[str, Sequence[str]]:
        """Bring the media process up to date; return the cameras it wants pictures of. Raises ``MediaDown``."""
        status = (await self._link.ask("GET", "/status")).json()
        run = status["pid"]  # one that restarted knows nothing
        farm = Farm([FarmRobot(one.id, one.name, one.keep_out_m) for one in self._robots.all()])
        if self._told_farm != (farm, run):
            await self._link.ask("PUT", "/farm", farm)
            lasts = await self._lasts([one.id for one in farm.robots])
            await self._link.ask("PUT", "/last", lasts)  # one that is silent now says nothing to the media process
            self._told_farm = (farm, run)
        for robot_id in watched:
            robot = self._fleet.robot(robot_id)
            key = (run, *self._key(robot))
            if robot is not None and self._told.get(robot_id) != key:
                await self._link.ask("PUT", f"/plans/{robot_id}", await self._plan(robot))
                self._told[robot_id] = key
        wanted: Mapping[str, Sequence[str]] = status.get("wanted", {})
        return wanted

    def _key(self, robot: Robot | None) -> tuple[Any, ...]:
        order = None if robot is None or robot.state is None else robot.state.order
        return (None, 0) if order is None else (order.mission_id, order.revision)

    async def _lasts(self, robot_ids: Sequence[str]) -> dict[str, Last]:
        """Return where robots were: as heard since the console runs, else as recorded before."""
        known = {robot_id: self._fleet.robot(robot_id) for robot_id in robot_ids}
        lasts = {robot_id: last for robot_id, robot in known.items() if robot and (last := last_of(robot)) is not None}
        missing = [robot_id for robot_id in robot_ids if robot_id not in lasts]
        if unread := [robot_id for robot_id in missing if robot_id not in self._points]:
            try:
                self._points |= await self._database.run(self._recorded, unread)
            except StoreError as error:
                log.info("no pose can be read from the record: %s", error)
        for robot_id in missing:
            if (point := self._points.get(robot_id)) is not None:
                lasts[robot_id] = recorded_last(point, known[robot_id], self._seen_s(point.at))
        return lasts

    def _recorded(self, robot_ids: Sequence[str]) -> dict[str, PosturePoint | None]:
        return {robot_id: self._history.last_posture(robot_id) for robot_id in robot_ids}

    def _seen_s(self, at: datetime) -> float:
        """Return a recorded time on the monotonic clock; never fresh, whatever was done to the wall clock since."""
        age_s = (self._clock.utc() - at).total_seconds()
        return min(self._clock.mono_s() - age_s, self._born_s - STALE_S)

    async def _plan(self, robot: Robot) -> Plan:
        order = None if robot.state is None else robot.state.order
        rings: list[list[tuple[float, float]]] = []
        try:
            parcels = await self._database.run(self._features.all, self._farm_id, ("parcel",))
            rings = [ring for one in parcels if (ring := _ring(one.geometry))]
            if order is None:
                return Plan(parcels=rings)
            treated = await self._database.run(self._treated, robot.id, order.mission_id)
            document = await self._database.run(self._missions.document, self._farm_id, order.mission_id)
            return Plan(order.mission_id, await asyncio.to_thread(_path, document), rings, treated)
        except (NotFound, StoreError) as error:
            log.info("nothing is known of the work of %s: %s", robot.id, error)
            return Plan(parcels=rings)

    def _treated(self, robot_id: str, mission_id: str) -> list[Treated]:
        events = self._history.events(robot_id, kinds=["treatment"], limit=MOST_TREATED)
        return [one for event in events if event.mission_id == mission_id and (one := _one(event)) is not None]


def last_of(robot: Robot) -> Last | None:
    """Return where a robot was and how its joints stood when they were heard last; ``None`` before it said so."""
    if robot.telemetry is None:
        return None
    pose, body = robot.telemetry.pose, robot.body
    last = Last(pose.x_m, pose.y_m, pose.theta_rad, pose.stamp.source_s)
    if body is None:
        return last
    return msgspec.structs.replace(
        last, joints=body.joints, joints_at_s=body.stamp.source_s, height_m=height_m(body.gauges) or 0.0
    )


def recorded_last(point: PosturePoint, robot: Robot | None, at_s: float) -> Last:
    """Return a recorded pose; joints that were heard since, without a pose, are newer than the record's."""
    last = Last(0.0, 0.0, point.theta_rad or 0.0, at_s, lat_lon_deg=(point.lat_deg, point.lon_deg))
    body = None if robot is None else robot.body
    if body is not None:
        return msgspec.structs.replace(
            last, joints=body.joints, joints_at_s=body.stamp.source_s, height_m=height_m(body.gauges) or 0.0
        )
    if point.joints is None and point.height_m is None:
        return last
    return msgspec.structs.replace(last, joints=point.joints or {}, joints_at_s=at_s, height_m=point.height_m or 0.0)


def _one(event: RobotEvent) -> Treated | None:
    said = event.data
    name, outcome, x, y = (said.get(key) for key in ("target", "outcome", "x_m", "y_m"))
    is_place = isinstance(name, str) and isinstance(x, int | float) and isinstance(y, int | float)
    if not is_place or outcome not in OUTCOMES:
        return None
    at_ms = round(event.at_utc.timestamp() * 1000)
    return Treated(str(name), float(x), float(y), str(outcome), at_ms)  # type: ignore[arg-type]  # looked at above


def _path(document: dict[str, Any]) -> list[Swath]:
    from hmi.planning.projection import LocalFrame  # numpy and pyproj: not for a console's start

    frame = LocalFrame(document["datum"]["lat_deg"], document["datum"]["lon_deg"])
    swaths = []
    for segment in document["segments"]:
        places = frame.to_lon_lat([point[:2] for point in segment["points"]])
        swaths.append(Swath([(float(lon), float(lat)) for lon, lat in places], int(segment.get("row") or 0)))
    return swaths


def _ring(geometry: dict[str, Any]) -> list[tuple[float, float]]:
    rings = geometry["coordinates"] if geometry["type"] == "Polygon" else geometry["coordinates"][0]
    return [(float(point[0]), float(point[1])) for point in rings[0]]
