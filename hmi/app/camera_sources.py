"""From the registry and what robots say of themselves to the sources the camera process may open."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol

from hmi.domain.camera import Source, SourceKind
from hmi.domain.robot import Robot
from hmi.store.robots import RegisteredRobot


class FleetView(Protocol):
    """What is needed of the live store."""

    def robot(self, robot_id: str) -> Robot | None:
        """Return all that is known of one robot."""
        ...

    def is_online(self, robot_id: str) -> bool:
        """Say whether a robot is heard."""
        ...


SourceRule = Callable[[list[Source]], list[Source]]
"""Takes the robots' own cameras; returns what is really opened: others instead of some, and more."""


def robot_sources(registered: Iterable[RegisteredRobot], fleet: FleetView) -> list[Source]:
    """Return the cameras of robots' factsheets, at the address and with the token of the registry."""
    found: list[Source] = []
    for entry in registered:
        robot = fleet.robot(entry.id)
        sheet = None if robot is None else robot.factsheet
        if sheet is None:
            continue
        is_on = fleet.is_online(entry.id)
        found += [
            Source(
                robot=entry.id,
                camera=camera,
                kind=SourceKind.ROBOT,
                url=entry.http_url or "",
                token=entry.http_token or "",
                is_on=is_on,
            )
            for camera in sheet.cameras
        ]
    return found
