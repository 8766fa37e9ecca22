"""A replay: what a viewer's picture holds of then, and that nothing of now passes for it."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest

from backend_clients.edge.machine import Target, Worksite
from backend_clients.edge.topics import Up
from hmi.clock import FakeClock
from hmi.media import orders
from hmi.media.intake import Intake
from hmi.media.status import status_of
from hmi.media.studio import Studio
from hmi.media.tap import tapped
from hmi.twin.farm import Farm, FarmRobot, Plan, Treated
from hmi.twin.viewer import View
from tests.hmi.media.studio_stage import OTHER, ROBOT, SECRET, Picture, Planter, connect


async def test_in_a_replay_camera_and_rings_go_with_the_robot_of_then(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(10.0)
    studio.enter("k", ROBOT, may_replay=True)
    async with await connect(studio, "k") as socket:
        picture = Picture(socket)
        await picture.look()
        await picture.until(f"/keepout/{ROBOT}/ring")
        viewer = studio.viewers["k"]
        assert viewer.client is not None
        studio.obey("k", orders.SetView(View.SIDE))
        studio.obey("k", orders.Replay(52.0, 5.001, 0.0, {"slew": 2.0}, height_m=7.0))
        owner = str(viewer.client.client_id)
        for frame in (f"/machine/{ROBOT}", f"/keepout/{ROBOT}", f"/reach/{ROBOT}"):
            shown = await picture.until(f"{owner}:{frame}", lambda node: "position" in node)
            assert shown["position"] == pytest.approx((68.6, 0.0, 7.0), abs=0.5)
        studio.obey("k", orders.SetView(View.TOP))
        assert viewer.client.camera.look_at[0] == pytest.approx(68.6, abs=0.5)
        studio.tick()
        stood = viewer.client.camera.position[0]
        studio.obey("k", orders.Replay(52.0, 5.0011, 0.0, {}))
        studio.tick()
        assert viewer.client.camera.position[0] - stood == pytest.approx(6.86, abs=0.1), "it follows what is replayed"
        studio.obey("k", orders.Live())
        studio.tick()
        assert viewer.client.camera.position[0] == pytest.approx(10.0, abs=2.0)


async def test_a_replay_hides_what_is_known_of_now_only_also_after_a_reconnect(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(0.0)
    ended = [Target(id=f"t{i}", x_m=i, y_m=1.0, status="done") for i in range(3)]
    planter.say(Up.WORKSITE, Worksite, stop=1, targets=ended, obstacles=[])
    studio.enter("k", ROBOT, may_replay=True)
    past = orders.Replay(52.0, 5.001, 0.5, {}, undone=["t2", "strange"])
    for round_ in range(2):
        async with await connect(studio, "k") as socket:
            picture = Picture(socket)
            await picture.look()
            async with asyncio.timeout(5):
                while (client := studio.viewers["k"].client) is None:  # noqa: ASYNC110 - viser's thread hands over
                    await asyncio.sleep(0.01)
            await picture.until(f"/trees/{ROBOT}/done")
            if round_ == 0:
                studio.obey("k", past)
            for frame in ("/scan", "/labels", "/planned", f"/trees/{ROBOT}/now"):
                node = await picture.until(f"{client.client_id}:{frame}")
                assert node["visible"] is False
            await picture.until(f"{client.client_id}:/trees/{ROBOT}/done", lambda node: "props" in node)
            own = client.scene.get_handle_by_name(f"/trees/{ROBOT}/done")
            assert len(own.batched_positions) == 2, "t2 came later"  # type: ignore[union-attr]
            await picture.until(f"{client.client_id}:/machine/{ROBOT}", lambda node: "position" in node)
        async with asyncio.timeout(5):
            while studio.viewers["k"].client is not None:  # noqa: ASYNC110 - viser's thread hands over
                await asyncio.sleep(0.01)


def past_of(studio: Studio, key: str = "k") -> tuple[bool, int | None]:
    """Return whether a page is told that its picture shows the record, and which moment of it."""
    said = status_of(studio, studio.viewers[key], 0.0)
    return said["is_past"], said["past_ms"]


async def test_a_replay_waits_for_its_robot_to_be_drawn_and_is_called_one_only_then(studio: Studio) -> None:
    planter = Planter(studio.intake)
    box = studio.enter("k", ROBOT, may_replay=True)
    studio.obey("k", orders.Replay(52.0, 5.001, 0.0, {"slew": 2.0}, at_ms=1000))
    studio.tick()
    assert past_of(studio) == (False, None)
    planter.introduce()
    planter.stand(1.0)
    studio.tick()
    assert past_of(studio) == (True, 1000)
    studio.world.remove(ROBOT)  # as when nobody looked for long
    studio.tick()
    past = studio.viewers["k"].past
    assert past is not None
    assert past.basis.drawn is studio.world.solid(ROBOT), "it is that of the robot drawn anew"
    while not box.empty():
        box.get_nowait()
    studio.obey("k", orders.Live())
    assert past_of(studio) == (False, None)
    assert box.get_nowait()["is_past"] is False, "a page need not wait for the next status"
    studio.tick()
    assert past_of(studio) == (False, None)


async def test_a_replay_shows_nothing_of_the_other_robots_and_no_trail_to_its_viewer_alone(studio: Studio) -> None:
    planter, away = Planter(studio.intake), Planter(studio.intake, OTHER)
    for one, x_m in ((planter, 0.0), (away, 9.0)):
        one.introduce()
        one.stand(x_m)
    studio.set_farm(Farm([FarmRobot(ROBOT, "Planter 02", 6.2), FarmRobot(OTHER, "Planter 03", 6.2)]))
    studio.enter("mine", ROBOT, may_replay=True)
    studio.enter("other", OTHER, may_replay=False)
    async with await connect(studio, "mine") as one, await connect(studio, "other") as two:
        mine, other = Picture(one), Picture(two)
        await mine.look()
        await other.look()
        await mine.until(f"/keepout/{OTHER}/ring")
        await other.until(f"/keepout/{OTHER}/ring")
        studio.obey("mine", orders.Replay(52.0, 5.001, 0.0, {}, at_ms=1000))
        owner = str(studio.viewers["mine"].client.client_id)  # type: ignore[union-attr]
        for frame in (f"/machine/{OTHER}", f"/keepout/{OTHER}", f"/trees/{OTHER}", f"/reach/{OTHER}", "/trail"):
            node = await mine.until(f"{owner}:{frame}", lambda said: "visible" in said)
            assert node["visible"] is False
        tapped_at = (9.0, 0.0, 20.0), (0.0, 0.0, -1.0)
        assert said_of(studio, "mine", *tapped_at)["what"] == "ground", "what is not seen is not there"
        assert said_of(studio, "other", *tapped_at)["name"] == "Planter 03"
        studio.obey("mine", orders.Live())
        assert said_of(studio, "mine", *tapped_at)["lines"] == ["Planter", "0.00 m/s"]
        async with asyncio.timeout(10):
            while f"{owner}:/machine/{OTHER}" in mine.nodes:
                mine._take(bytes(await one.recv()))  # type: ignore[arg-type]
        assert not [name for name in other.nodes if ":" in name and not name.endswith("/ground")]


def said_of(
    studio: Studio, key: str, origin: tuple[float, float, float], direction: tuple[float, float, float]
) -> dict[str, Any]:
    """Return what a page is told of a tap."""
    return tapped(studio, studio.viewers[key], origin, direction)[1]


async def test_a_tap_in_a_replay_tells_nothing_of_now(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(0.0)
    studio.enter("k", ROBOT, may_replay=True)
    states = {"t1": "done", "t2": "done", "t3": "current"}
    targets = [Target(id=id_, x_m=20.0 + i, y_m=0.0, status=state) for i, (id_, state) in enumerate(states.items())]  # type: ignore[arg-type]
    planter.say(Up.WORKSITE, Worksite, stop=1, targets=targets, obstacles=[])
    studio.tick()
    studio.tick()
    studio.obey("k", orders.Replay(52.0, 5.0, 0.0, {}, undone=["t2"], at_ms=1000))
    down = (0.0, 0.0, -1.0)
    assert said_of(studio, "k", (0.0, 0.0, 20.0), down)["lines"] == ["Planter"], "no speed of now"
    names = [said_of(studio, "k", (20.0 + i, 0.0, 20.0), down)["name"] for i in range(3)]
    assert names == ["Place t1", "Ground", "Ground"]
    studio.obey("k", orders.Live())
    names = [said_of(studio, "k", (20.0 + i, 0.0, 20.0), down)["name"] for i in range(3)]
    assert names == ["Place t1", "Place t2", "Place t3"]


async def test_what_is_planted_while_somebody_replays_is_not_there_yet(tmp_path: Path) -> None:
    clock = FakeClock()
    studio = Studio(Intake(clock), tmp_path, SECRET, clock)
    try:
        studio.set_farm(Farm([FarmRobot(ROBOT, "Planter 02", 6.2)]))
        then_ms = round(clock.utc().timestamp() * 1000)
        studio.set_plan(
            ROBOT, Plan("m", treated=[Treated("t0", 0, 1, "done", then_ms + 1), Treated("t1", 1, 1, "done")])
        )
        planter = Planter(studio.intake)
        planter.introduce()
        planter.stand(0.0)
        planter.say(Up.WORKSITE, Worksite, stop=1, targets=[Target(id="t2", x_m=2, y_m=1, status="done")], obstacles=[])
        studio.enter("k", ROBOT, may_replay=True)
        for _ in range(2):
            studio.tick()
        studio.obey("k", orders.Replay(52.0, 5.0, 0.0, {}, at_ms=then_ms))
        assert undone(studio) == {"t0"}
        clock.advance(5.0)
        both = [Target(id="t2", x_m=2, y_m=1, status="done"), Target(id="t3", x_m=3, y_m=1, status="done")]
        planter.say(Up.WORKSITE, Worksite, stop=1, targets=both, obstacles=[])
        for _ in range(2):
            studio.tick()
        assert undone(studio) == {"t0", "t3"}, "the order did not know of it"
        studio.obey("k", orders.Replay(52.0, 5.0, 0.0, {}, at_ms=then_ms + 6000))
        assert undone(studio) == set()
    finally:
        await studio.stop()


def undone(studio: Studio) -> frozenset[str]:
    """Return the places that the replay of a page does not show."""
    past = studio.viewers["k"].past
    assert past is not None
    return past.undone
