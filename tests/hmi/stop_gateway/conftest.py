"""Broker, gateway and robots for one test."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.hmi.stop_gateway.broker import MOSQUITTO, Broker
from tests.hmi.stop_gateway.fake_robot import FakeRobot
from tests.hmi.stop_gateway.running import RunningGateway, Tablet

MakeRobot = Callable[..., Awaitable[FakeRobot]]


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Broker]:
    """A broker of this test's own."""
    if MOSQUITTO is None:
        pytest.skip("mosquitto is not installed")
    broker = Broker(tmp_path)
    broker.start()
    yield broker
    broker.kill()


@pytest.fixture
async def make_robot(broker: Broker) -> AsyncIterator[MakeRobot]:
    """Make robots that are switched off at the end."""
    robots: list[FakeRobot] = []

    async def make(robot_id: str = "weeder-01", **fields: Any) -> FakeRobot:
        robots.append(await FakeRobot(robot_id, broker.url, **fields).start())
        return robots[-1]

    yield make
    for robot in robots:
        await robot.close()


@pytest.fixture
def gateway(tmp_path: Path, broker: Broker) -> Iterator[RunningGateway]:
    """A gateway that is not started yet: register robots first."""
    gateway = RunningGateway(tmp_path / "data", broker.url)
    yield gateway
    gateway.close()


@pytest.fixture
async def open_tablet(gateway: RunningGateway) -> AsyncIterator[Callable[[], Awaitable[Tablet]]]:
    """Open tablets that are closed at the end."""
    tablets: list[Tablet] = []

    async def open_one() -> Tablet:
        tablets.append(await Tablet.open(gateway))
        return tablets[-1]

    yield open_one
    for tablet in tablets:
        await tablet.close()
