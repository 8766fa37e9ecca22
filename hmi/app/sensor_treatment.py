"""Which robots treat which parcel now, and when it was treated before."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from datetime import datetime

from hmi.commands.treatment_notice import Treatment
from hmi.domain.family import Family
from hmi.domain.mission import UNDER_WAY as NOT_OVER
from hmi.domain.mission import MissionStatus
from hmi.domain.planned_machine import MACHINE
from hmi.domain.robot import Order, OrderStatus, Robot
from hmi.domain.sensors.place import Parcel
from hmi.ingest.supervision.stations import AtWork
from hmi.store.database import Database
from hmi.store.features import Features
from hmi.store.fleet import FleetStore
from hmi.store.missions import Mission, Missions

UNDER_WAY = (OrderStatus.RUNNING, OrderStatus.PAUSED)
MOST_RUNS = 50  # of one chart
Treated = tuple[datetime, datetime | None, str]


class TreatmentWatch:
    """Follows robots from when they reach the parcel of their mission until that ends."""

    def __init__(
        self, fleet: FleetStore, missions: Missions, features: Features, database: Database, farm_id: str
    ) -> None:
        self._fleet, self._missions, self._features = fleet, missions, features
        self._database, self._farm_id = database, farm_id
        self._reached: set[tuple[str, str]] = set()
        self.parcels: dict[str, Parcel] = {}

    async def load(self) -> None:
        """Read the parcels of the published map."""
        found = await self._database.run(self._features.all, self._farm_id, ("parcel",))
        self.parcels = {one.id: Parcel.of(one.id, one.title, one.geometry) for one in found}

    def name_of(self, parcel_id: str) -> str:
        """Return what people call a parcel, empty if it is not on the map."""
        found = self.parcels.get(parcel_id)
        return "" if found is None else found.name

    def parcel_of(self, text: str) -> str | None:
        """Return the id of the parcel that an id or a name means."""
        if text in self.parcels:
            return text
        return next((one.id for one in self.parcels.values() if one.name.casefold() == text.casefold()), None)

    def look(self) -> list[AtWork]:
        """Return who works on which parcel now; call it every few seconds."""
        found, reached = [], set()
        for robot in self._fleet.robots():
            order = robot.state.order if robot.state is not None else None
            if order is None or not robot.is_registered or order.status not in UNDER_WAY or _only_looks(robot):
                continue
            parcel = self._parcel(order)
            key = robot.id, order.mission_id
            if parcel is not None and (key in self._reached or _is_on(robot, parcel)):
                reached.add(key)
                found.append(AtWork(robot.id, parcel.id, robot.name))
        self._reached = reached
        return found

    def treatments(self, at_work: Sequence[AtWork]) -> Mapping[str, Treatment]:
        """Return the treatments by parcel."""
        robots: dict[str, dict[str, str]] = {}
        for one in at_work:
            robots.setdefault(one.parcel, {})[one.robot_id] = one.name or one.robot_id
        return {
            key: Treatment(key, self.name_of(key), tuple(sorted(here)), tuple(here[one] for one in sorted(here)))
            for key, here in robots.items()
        }

    async def treated(self, parcel: str, since: datetime) -> list[Treated]:
        """Return when a parcel was treated since then, oldest first; ``None`` as the end: it still is."""
        names = {robot.id: robot.name for robot in self._fleet.robots()}
        uavs = {robot.id for robot in self._fleet.robots() if _only_looks(robot)}
        runs = [
            one for one in self._missions.all_known(self._farm_id)
            if one.field_id == parcel and one.updated_at >= since and not _is_flight(one, uavs)
        ]  # fmt: skip
        newest = sorted(runs, key=lambda one: one.updated_at, reverse=True)[:MOST_RUNS]
        return sorted(await self._database.run(self._spans, newest, since, names), key=lambda one: one[0])

    def _spans(self, missions: Sequence[Mission], since: datetime, names: Mapping[str, str]) -> list[Treated]:
        found: list[Treated] = []
        for mission in missions:
            begin: datetime | None = None
            robot = names.get(mission.robot_id or "", mission.robot_id or "")
            is_named = not robot or robot in mission.name  # as people call missions
            text = mission.name if is_named else f"{mission.name}, {robot}"
            for line in self._missions.log(self._farm_id, mission.id):
                if line.status is MissionStatus.RUNNING:
                    begin = begin or line.at
                elif line.status not in NOT_OVER and begin is not None:  # ended, or sent anew
                    found.append((begin, line.at, text))
                    begin = None
            if begin is not None:
                found.append((begin, None, text))
        return [one for one in found if one[1] is None or one[1] >= since]

    def _parcel(self, order: Order) -> Parcel | None:
        mission = self._missions.known(order.mission_id)
        return None if mission is None or mission.field_id is None else self.parcels.get(mission.field_id)


def _only_looks(robot: Robot) -> bool:
    return robot.factsheet is not None and robot.factsheet.family is Family.UAV


def _is_flight(mission: Mission, uavs: Set[str]) -> bool:
    """Say whether a UAV has it; one that was not heard since the start is known by what was planned for it."""
    machine = mission.statistics.get(MACHINE) or {}
    return mission.robot_id in uavs or machine.get("family") == Family.UAV.value


def _is_on(robot: Robot, parcel: Parcel) -> bool:
    pose = robot.telemetry.pose if robot.telemetry is not None else None
    return pose is not None and parcel.holds(pose.lat_deg, pose.lon_deg)
