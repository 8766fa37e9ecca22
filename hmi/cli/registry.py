"""The robot registry, as the command line opens it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from hmi.cli.storage import opened
from hmi.clock import SystemClock
from hmi.store.robots import Robots
from hmi.store.stop_list import StopList


@dataclass(frozen=True, slots=True)
class OpenRegistry:
    """The registry, the farm whose robots it holds, and where the STOP gateway keeps what is not reset."""

    registry: Robots
    farm_id: str
    outbox: Path


@contextmanager
def opened_registry() -> Iterator[OpenRegistry]:
    """Open the registry; each change is written to the STOP gateway's list too."""
    with opened() as (settings, database):
        stop_list = StopList(database, settings.farm_id, settings.data / "stop")
        robots = Robots(database, settings.farm_id, SystemClock(), stop_list)
        robots.load()
        yield OpenRegistry(robots, settings.farm_id, settings.data / "stop" / "outbox.json")
