"""What the console tells the media process of a robot that is silent when somebody looks."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta
from types import SimpleNamespace
from typing import Any

import pytest

from hmi.app.twin_news import TwinNews, last_of
from hmi.clock import FakeClock
from hmi.domain.machine import Body
from hmi.domain.robot import Robot
from hmi.domain.stamp import Stamp
from hmi.store.history import PosturePoint
from hmi.twin.farm import Last
from tests.hmi.presenters import robots as r

BODY = Body({"slew": 0.4}, {}, {"height": 3.5}, None, None, None, (), Stamp(990.0, 990.1))


def test_the_last_pose_goes_with_its_joints_and_the_time_of_each() -> None:
    assert last_of(replace(r.RUNNING, telemetry=None)) is None
    assert last_of(r.RUNNING) == Last(1.0, 2.0, 0.0, 1000.0)
    assert last_of(replace(r.RUNNING, body=BODY)) == Last(1.0, 2.0, 0.0, 1000.0, {"slew": 0.4}, 990.0, 3.5)


class Media:
    """Keeps what it is told."""

    def __init__(self) -> None:
        self.told: list[tuple[str, Any]] = []

    async def ask(self, method: str, path: str, body: Any = None) -> Any:
        """See ``MediaLink``."""
        if method == "PUT":
            self.told.append((path, body))
        return SimpleNamespace(json=lambda: {"pid": 1})


class Database:
    """Nothing is on record."""

    async def run(self, *_asked: Any) -> list[Any]:
        """See ``Database``."""
        return []


async def test_it_is_told_once_for_each_look_before_the_picture_opens() -> None:
    robot: Robot = replace(r.with_state(r.RUNNING, order=None), body=BODY)
    media: Any = Media()
    fleet: Any = SimpleNamespace(robot=lambda _robot_id: robot)
    robots: Any = SimpleNamespace(all=lambda: [SimpleNamespace(id=robot.id, name=robot.name, keep_out_m=None)])
    features: Any = SimpleNamespace(all=None)
    nothing: Any = None
    database: Any = Database()
    news = TwinNews(media, fleet, robots, nothing, features, nothing, database, "farm", FakeClock())
    news.forget(robot.id)
    await news.tell([robot.id])
    await news.tell([robot.id])
    assert [path for path, _ in media.told] == ["/farm", "/last", f"/plans/{robot.id}"]
    assert media.told[1][1] == {robot.id: last_of(robot)}


class Record:
    """One recorded pose, and a database that runs what it is asked."""

    def __init__(self, point: PosturePoint) -> None:
        self._point = point

    def last_posture(self, _robot_id: str) -> PosturePoint:
        """See ``History``."""
        return self._point

    async def run(self, work: Any, *given: Any) -> Any:
        """See ``Database``."""
        return work(*given)


@pytest.mark.parametrize(("leap_s", "age_s"), [(0.0, 90.0), (-3600.0, 32.0)], ids=["as it is", "clock set back"])
async def test_a_robot_silent_since_before_the_start_is_told_as_recorded_and_never_fresh(
    leap_s: float, age_s: float
) -> None:
    clock, media = FakeClock(), Media()
    point = PosturePoint(clock.utc() - timedelta(seconds=60), 52.0, 5.0, 0.3, {"slew": 0.4}, 2.0)
    silent = replace(r.with_state(r.RUNNING, order=None), telemetry=None)
    fleet: Any = SimpleNamespace(robot=lambda _robot_id: silent)
    robots: Any = SimpleNamespace(all=lambda: [SimpleNamespace(id=silent.id, name=silent.name, keep_out_m=None)])
    record: Any = Record(point)
    features: Any = SimpleNamespace(all=lambda *_asked: [])
    nothing: Any = None
    told: Any = media
    news = TwinNews(told, fleet, robots, nothing, features, record, record, "farm", clock)
    clock.advance(30.0)
    clock.jump_wall(leap_s)
    news.forget(silent.id)
    await news.tell([silent.id])
    at_s = clock.mono_s() - age_s
    recorded = Last(0.0, 0.0, 0.3, at_s, {"slew": 0.4}, at_s, 2.0, (52.0, 5.0))
    assert media.told[1] == ("/last", {silent.id: recorded})
