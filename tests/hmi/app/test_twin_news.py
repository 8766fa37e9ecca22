"""What the console tells the media process of a robot that is silent when somebody looks."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from hmi.app.twin_news import TwinNews, last_of
from hmi.domain.machine import Body
from hmi.domain.robot import Robot
from hmi.domain.stamp import Stamp
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
    news = TwinNews(media, fleet, robots, nothing, features, nothing, database, "farm")
    news.forget(robot.id)
    await news.tell([robot.id])
    await news.tell([robot.id])
    assert [path for path, _ in media.told] == ["/farm", f"/last/{robot.id}", f"/plans/{robot.id}"]
    assert media.told[1][1] == last_of(robot)
