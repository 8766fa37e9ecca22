"""Cameras as the cloud shall see them: which there are, whose, and whether they can be asked. Never a picture."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import islice
from typing import NamedTuple

from hmi.clock import Clock
from hmi.domain.camera import FIELD_ROBOT, CameraInfo
from hmi.fiware.camera import camera_entity, camera_off
from hmi.fiware.urn import KeyValues, Urns
from hmi.store.fleet import FleetStore
from hmi.store.robot_record import Part

LOOK_EVERY_S = 30.0  # robots come and go, their cameras hardly ever change
_TOLD_BY = frozenset({Part.FACTSHEET, Part.REGISTRY})


class FieldCamera(NamedTuple):
    """A camera that belongs to no robot; ``place`` is latitude and longitude in degrees, if it is known."""

    camera: CameraInfo
    place: tuple[float, float] | None = None


class CameraStates:
    """Watches the cameras of registered robots and of the field.

    Args:
        fleet: the live store.
        field: returns the cameras of the field.
        urns: names of the farm's entities.
    """

    what = "Cameras"

    def __init__(self, fleet: FleetStore, field: Callable[[], Iterable[FieldCamera]], urns: Urns, clock: Clock) -> None:
        self._fleet, self._field, self._urns, self._clock = fleet, field, urns, clock
        self._revision, self._look_s = 0, float("-inf")
        self._of_robots: dict[str, tuple[CameraInfo, ...]] = {}
        self._waiting: dict[str, KeyValues] = {}
        self._told: dict[str, KeyValues] = {}

    def reports(self, limit: int) -> list[KeyValues]:
        """Return what to tell now, at most so many entities; until told, they come again."""
        now_s = self._clock.mono_s()
        if now_s >= self._look_s:
            self._look_s = now_s + LOOK_EVERY_S
            self._look()
        return list(islice(self._waiting.values(), limit))

    def told(self, entities: Iterable[KeyValues]) -> None:
        """Note that these arrived."""
        for one in entities:
            if self._waiting.get(one["id"]) == one:
                del self._waiting[one["id"]]
            self._told[one["id"]] = one

    def forget(self) -> None:
        """Tell everything again: the broker may have lost it, or be another one."""
        self._told.clear()
        self._look_s = float("-inf")

    def _look(self) -> None:
        changes = self._fleet.since(self._revision)
        self._revision = changes.revision
        for robot_id in changes.removed:
            self._of_robots.pop(robot_id, None)
        for robot_id, parts in changes.robots.items():
            if parts & _TOLD_BY:
                self._of_robots[robot_id] = self._cameras_of(robot_id)
        now = {one["id"]: one for one in self._entities()}
        gone = [one for key, one in self._told.items() if key not in now and one.get("on") is not False]
        now |= {one["id"]: camera_off(one) for one in gone}
        self._waiting = {key: one for key, one in now.items() if self._told.get(key) != one}

    def _cameras_of(self, robot_id: str) -> tuple[CameraInfo, ...]:
        robot = self._fleet.robot(robot_id)
        is_ours = robot is not None and robot.is_registered
        return tuple(robot.factsheet.cameras) if robot is not None and is_ours and robot.factsheet is not None else ()

    def _entities(self) -> Iterable[KeyValues]:
        for robot_id, cameras in self._of_robots.items():
            is_on = self._fleet.is_online(robot_id)
            for camera in cameras:
                yield camera_entity(self._urns, robot_id, camera, f"{robot_id} {camera.label}", is_on=is_on)
        for one in self._field():
            yield camera_entity(self._urns, FIELD_ROBOT, one.camera, one.camera.label, place=one.place)
