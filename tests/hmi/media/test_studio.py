"""The media process at work with a real viser server: what a viewer's picture holds, and whom it answers."""

from __future__ import annotations

import asyncio
import urllib.error
import urllib.request
from collections.abc import AsyncIterator, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from websockets.exceptions import InvalidStatus

from backend_clients.edge.machine import Body, Joint, Target, Worksite
from backend_clients.edge.topics import Up, topic
from hmi.clock import FakeClock
from hmi.media import orders
from hmi.media.control import control_app
from hmi.media.door import RIGHTS_HEADER, SECRET_HEADER, VIEWER_HEADER
from hmi.media.intake import Intake
from hmi.media.models import ModelShelf
from hmi.media.status import status_of
from hmi.media.studio import Studio
from hmi.twin.camera import Camera
from hmi.twin.farm import Farm, FarmRobot, Last
from hmi.twin.ground import DARK
from hmi.twin.groups import Group
from tests.hmi.app.asgi_socket import AsgiSocket
from tests.hmi.media.studio_stage import JOINTS, OTHER, ROBOT, SECRET, Picture, Planter, connect


async def test_without_the_secret_neither_picture_nor_page_is_given(studio: Studio) -> None:
    with pytest.raises(InvalidStatus) as refused:
        await connect(studio, "k", "guess")
    assert refused.value.response.status_code == 403
    with pytest.raises(urllib.error.HTTPError) as page:
        await asyncio.to_thread(urllib.request.urlopen, f"http://127.0.0.1:{studio.viser_port}/")
    assert page.value.code == 403
    page.value.close()


async def test_a_robot_moves_in_the_picture_with_its_joints_its_ghost_and_its_warnings(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(10.0)
    studio.enter("k", ROBOT, may_replay=False)
    async with await connect(studio, "k") as socket:
        picture = Picture(socket)
        await picture.look()
        await picture.until(f"/machine/{ROBOT}", lambda node: node.get("position", [0])[0] == pytest.approx(10.0))
        await picture.until(f"/planned/{ROBOT}/column", lambda node: "wxyz" in node)
        await picture.until(f"/keepout/{ROBOT}/ring")
        await picture.until(f"/labels/{ROBOT}/p1/text", lambda node: "inside keep-out" in str(node))
        planter.stand(11.5, slew=1.0, stick=-2.65)
        await picture.until(f"/machine/{ROBOT}", lambda node: node.get("position", [0])[0] == pytest.approx(11.5))
        await picture.until(f"/machine/{ROBOT}/column", lambda node: node.get("type") == "SetOrientationMessage")
        marked = await picture.until(f"/limits/{ROBOT}/stick/text")
        assert "beyond soft limit" in str(marked)


async def test_the_camera_stands_at_a_robot_that_was_not_heard_before_somebody_looked(studio: Studio) -> None:
    studio.enter("k", ROBOT, may_replay=False)
    async with await connect(studio, "k") as socket:
        picture = Picture(socket)
        await picture.look()
        async with asyncio.timeout(5):
            while (client := studio.viewers["k"].client) is None:  # noqa: ASYNC110 - viser's thread hands over
                await asyncio.sleep(0.01)
        planter = Planter(studio.intake)
        planter.introduce()
        planter.stand(160.0)
        await picture.until(f"/machine/{ROBOT}", lambda node: node.get("position", [0])[0] == pytest.approx(160.0))
        async with asyncio.timeout(5):
            while abs(client.camera.position[0] - 160.0) > 15.0:  # noqa: ASYNC110 - set between two ticks
                await asyncio.sleep(0.01)
        assert client.camera.look_at[0] == pytest.approx(160.0, abs=1.0)


async def test_a_camera_that_a_loading_page_put_elsewhere_is_put_back_until_the_person_takes_it(studio: Studio) -> None:
    async with await connect(studio, "nobody's: the studio leaves it alone") as socket:
        picture = Picture(socket)
        await picture.look()
        async with asyncio.timeout(5):
            while not (clients := studio.server.get_clients()):  # noqa: ASYNC110 - viser's thread makes it
                await asyncio.sleep(0.01)
        client = next(iter(clients.values()))
        camera, held = Camera(client), client.camera
        camera.stand((160.0, 5.0, 8.0), (160.0, 0.0, 1.0), 10.0)
        await reported(picture, held)  # it stands where every page begins: what was ordered got lost
        camera.check(10.1)
        assert held.position[0] == 3.0, "a report may be older than the order"
        camera.check(10.6)
        assert list(held.position) == [160.0, 5.0, 8.0]
        assert list(held.look_at) == [160.0, 0.0, 1.0]
        await reported(picture, held)
        camera.carry(np.array([1.0, 0.0, 0.0]))
        assert list(held.position) == [161.0, 5.0, 8.0], "it is carried from where it was ordered"
        assert list(held.look_at) == [161.0, 0.0, 1.0]
        camera.let_go()
        await reported(picture, held)
        camera.check(20.0)
        camera.carry(np.array([1.0, 0.0, 0.0]))
        assert list(held.position) == [4.0, 3.0, 3.0], "from where the person left it"


async def reported(picture: Picture, camera: Any) -> None:
    """Let the browser say that its camera stands where every page begins."""
    await picture.look()
    async with asyncio.timeout(5):
        while camera.position[0] != 3.0:  # noqa: ASYNC110 - viser's thread takes it
            await asyncio.sleep(0.005)


async def test_a_place_is_shown_with_the_height_of_the_tool_and_says_how_far_the_arm_reaches(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(0.0)
    box = studio.enter("k", ROBOT, may_replay=False)
    current = [Target(id="tree-147", x_m=-5.0, y_m=0.0, status="current")]
    planter.say(Up.WORKSITE, Worksite, stop=1, targets=current, obstacles=[])
    async with await connect(studio, "k") as socket:
        picture = Picture(socket)
        await picture.look()
        assert "Reach" in str(await picture.until(f"/reach/{ROBOT}/line/text"))
        assert "Tree 147" in str(await picture.until(f"/trees/{ROBOT}/now/named/text"))
        studio.touch("k", (-5.0, 0.4, 9.0), (0.0, 0.0, -1.0))
        studio.obey("k", orders.Lift(1.6))
        owner = str(studio.viewers["k"].client.client_id)  # type: ignore[union-attr]
        assert "1.6 m" in str(await picture.until(f"{owner}:/touched/text"))
        async with asyncio.timeout(5):
            while (said := await box.get())["k"] != "tap":
                assert said["k"] == "status"
        assert said["what"] == "place"
        assert said["arm_m"] == pytest.approx(3.22, abs=0.02)
        assert said["reach_m"] > said["arm_m"]


async def test_what_was_planted_stays_when_the_surface_is_reset_at_the_next_stop(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(0.0)
    box = studio.enter("k", ROBOT, may_replay=False)
    first = [Target(id=f"t{i}", x_m=i, y_m=1.0, status="done") for i in range(3)]
    planter.say(Up.WORKSITE, Worksite, stop=1, targets=first, obstacles=[])
    async with await connect(studio, "k") as socket:
        picture = Picture(socket)
        await picture.look()
        await picture.until(f"/trees/{ROBOT}/done", lambda node: "props" in node)
        planned = [
            Target(id="t9", x_m=9.0, y_m=1.0, status="planned"),
            Target(id="t8", x_m=8, y_m=1, status="failed_ground"),
        ]
        planter.say(Up.WORKSITE, Worksite, stop=2, targets=planned, obstacles=[])
        await picture.until(f"/trees/{ROBOT}/failed_ground")
        await picture.until(f"/trees/{ROBOT}/now/planned")
        async with asyncio.timeout(5):
            while (said := await box.get()).get("trees") != {"done": 3, "failed": 1, "here": 1}:
                assert said["k"] == "status"


async def test_hiding_a_layer_and_replaying_reach_one_viewer_only(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(10.0)
    studio.enter("mine", ROBOT, may_replay=True)
    studio.enter("other", ROBOT, may_replay=False)
    async with await connect(studio, "mine") as one, await connect(studio, "other") as two:
        mine, other = Picture(one), Picture(two)
        await mine.look()
        await other.look()
        await mine.until(f"/machine/{ROBOT}")
        await other.until(f"/machine/{ROBOT}")
        past = orders.Replay(52.0, 5.001, 0.5, {"slew": 2.0})
        studio.obey("other", past)  # has no right to
        studio.obey("mine", orders.SetLayer(Group.TREES, False))
        studio.obey("mine", past)
        owner = str(studio.viewers["mine"].client.client_id)  # type: ignore[union-attr]
        shown = await mine.until(f"{owner}:/machine/{ROBOT}", lambda node: "position" in node)
        assert shown["position"][0] == pytest.approx(68.6, abs=0.5)
        await mine.until(f"{owner}:/trees")
        studio.obey("mine", orders.Live())
        planter.stand(12.0)
        await other.until(f"/machine/{ROBOT}", lambda node: node.get("position", [0])[0] == pytest.approx(12.0))
        assert not [name for name in other.nodes if ":" in name and not name.endswith("/ground")]


async def test_a_reconnected_picture_gets_its_layers_back(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(1.0)
    studio.enter("k", ROBOT, may_replay=False)
    studio.obey("k", orders.SetLayer(Group.TREES, False))
    for _ in range(2):
        async with await connect(studio, "k") as socket:
            picture = Picture(socket)
            await picture.look()
            async with asyncio.timeout(5):
                while (client := studio.viewers["k"].client) is None:  # noqa: ASYNC110 - viser's thread hands over
                    await asyncio.sleep(0.01)
            await picture.until(f"{client.client_id}:/trees")
        async with asyncio.timeout(5):
            while studio.viewers["k"].client is not None:  # noqa: ASYNC110 - viser's thread hands over
                await asyncio.sleep(0.01)


async def test_an_order_that_cannot_be_read_is_ignored_and_the_socket_stays(studio: Studio, tmp_path: Path) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(0.0)
    studio.tick()
    app = control_app(studio, ModelShelf(tmp_path), SECRET)
    headers = {SECRET_HEADER: SECRET, VIEWER_HEADER: "k", RIGHTS_HEADER: "replay"}
    async with AsgiSocket(app, f"/viewer?robot={ROBOT}", headers) as socket:
        socket.say('{"k":"replay","lat_deg":95,"lon_deg":5,"theta_rad":1}')
        socket.say('{"k":"replay","lat_deg":52,"lon_deg":5,"theta_rad":1,"at_ms":1000}')
        said = await socket.next()
        assert (socket.code, msgspec.json.decode(said.get("text", "null"))["past_ms"]) == (None, 1000)


async def test_how_far_a_touched_place_is_is_told_again_as_the_robot_moves(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(0.0)
    studio.enter("k", ROBOT, may_replay=True)
    studio.tick()
    studio.tick()
    studio.touch("k", (20.0, 0.0, 9.0), (0.0, 0.0, -1.0))
    viewer = studio.viewers["k"]
    near = status_of(studio, viewer, 0.0)["touched"]
    assert (near["x_m"], near["distance_m"]) == (20.0, 20.0)
    planter.stand(-20.0)
    studio.tick()
    far = status_of(studio, viewer, 0.0)["touched"]
    assert (far["x_m"], far["distance_m"]) == (20.0, 40.0)
    assert far["arm_m"] == pytest.approx(near["arm_m"] + 20.0, abs=0.01)
    studio.obey("k", orders.Replay(52.0, 5.0, 0.0, {}, at_ms=1000))
    assert status_of(studio, viewer, 0.0)["touched"]["distance_m"] == 20.0, "from where it was then"
    studio.obey("k", orders.Unmark())
    assert status_of(studio, viewer, 0.0)["touched"] is None


async def test_the_age_of_the_pose_is_that_of_the_drawn_one_while_newer_ones_cannot_be_read(tmp_path: Path) -> None:
    clock = FakeClock()
    studio = Studio(Intake(clock), tmp_path, SECRET, clock)
    try:
        studio.set_farm(Farm([FarmRobot(ROBOT, "Planter 02", 6.2)]))
        planter = Planter(studio.intake)
        planter.introduce()
        planter.stand(3.0)
        studio.enter("k", ROBOT, may_replay=False)
        studio.tick()
        for kind in (Up.TELEMETRY, Up.FACTSHEET):
            clock.advance(5.0)
            studio.intake.take(topic(ROBOT, kind), b'{"lat_deg": null}', False)
            studio.tick()
        said = status_of(studio, studio.viewers["k"], clock.mono_s())
        assert (said["is_drawn"], said["pose_age_s"]) == (True, 10.0)
        planter.rest(10.0)
        planter.stand(4.0)
        studio.tick()
        said = status_of(studio, studio.viewers["k"], clock.mono_s())
        assert (said["is_drawn"], said["pose_age_s"]) == (True, 0.0), "it is drawn by what its factsheet said before"
        assert studio.world.mover.place(f"/machine/{ROBOT}").xyz[0] == 4.0
    finally:
        await studio.stop()


async def test_an_arm_that_is_not_heard_any_more_is_not_live_because_the_machine_still_says_where_it_is(
    tmp_path: Path,
) -> None:
    clock = FakeClock()
    studio = Studio(Intake(clock), tmp_path, SECRET, clock)

    def told(kinds: Sequence[Up]) -> tuple[float | None, float | None]:
        clock.advance(3.0)
        planter.rest(3.0)
        planter.stand(3.0)
        for kind in {Up.TELEMETRY, Up.BODY} - set(kinds):
            studio.intake.take(topic(ROBOT, kind), b"{", False)
        studio.tick()
        said = status_of(studio, studio.viewers["k"], clock.mono_s())
        return said["pose_age_s"], said["ages_s"]["machine"]

    try:
        studio.set_farm(Farm([FarmRobot(ROBOT, "Planter 02", 6.2)]))
        planter = Planter(studio.intake)
        planter.introduce()
        studio.enter("k", ROBOT, may_replay=False)
        assert told([Up.TELEMETRY, Up.BODY]) == (0.0, 0.0)
        studio.intake.forget([])
        planter.introduce()
        assert told([Up.TELEMETRY]) == (None, None), "its joints were never heard: it is drawn at rest"
        said = status_of(studio, studio.viewers["k"], clock.mono_s())
        assert (said["is_drawn"], said["unheard"]) == (True, ["slew", "stick"])
        assert told([Up.TELEMETRY, Up.BODY]) == (0.0, 0.0)
        assert told([Up.TELEMETRY]) == (3.0, 3.0)
        assert told([Up.TELEMETRY]) == (6.0, 6.0)
    finally:
        await studio.stop()


async def test_robots_that_are_not_registered_are_not_drawn(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(1.0)
    studio.set_farm(Farm([]))
    studio.tick()
    assert studio.world.robots() == []


@pytest.fixture
async def still(tmp_path: Path) -> AsyncIterator[Studio]:
    """A studio that draws when told, with two robots."""
    clock = FakeClock()
    made = Studio(Intake(clock), tmp_path, SECRET, clock)
    made.set_farm(Farm([FarmRobot(ROBOT, "Planter 02", 6.2), FarmRobot(OTHER, "Planter 03", 6.2)]))
    yield made
    await made.stop()


def now(studio: Studio) -> float:
    """Return the time of a studio's clock."""
    return studio._clock.mono_s()


def told(studio: Studio, key: str = "k") -> dict[str, Any]:
    """Draw, and return what the page is told."""
    studio.tick()
    return status_of(studio, studio.viewers[key], now(studio))


async def test_a_declared_joint_that_the_robot_leaves_out_takes_the_age_from_its_pose(still: Studio) -> None:
    planter = Planter(still.intake)
    planter.introduce()
    planter.stand(3.0)
    still.enter("k", ROBOT, may_replay=False)
    assert told(still)["unheard"] == []
    planter.say(Up.BODY, Body, joints={"slew": 0.5})
    said = told(still)
    assert (said["is_drawn"], said["pose_age_s"], said["unheard"]) == (True, None, ["stick"])
    planter.stand(3.0)
    assert told(still)["pose_age_s"] is not None


async def test_a_joint_that_the_model_does_not_move_makes_no_picture_wrong(still: Studio) -> None:
    planter = Planter(still.intake)
    planter.introduce(joints=[*JOINTS, Joint(name="left wheel", lower=-9.0, upper=9.0, max_rate=1.0)])
    planter.stand(3.0)
    still.enter("k", ROBOT, may_replay=False)
    said = told(still)
    assert (said["unheard"], said["pose_age_s"] is None) == ([], False)


async def test_a_robot_that_is_silent_stands_where_the_console_heard_it_last(still: Studio) -> None:
    Planter(still.intake).introduce()
    now_s = now(still)
    still.set_last({ROBOT: Last(7.0, 2.0, 0.0, now_s - 300, {"slew": 1.0, "stick": -1.0}, now_s - 301, 0.5)})
    still.tick()
    assert still.world.robots() == [], "nobody looks at it"
    box = still.enter("k", ROBOT, may_replay=True)
    said = told(still)
    assert (said["is_drawn"], said["pose_age_s"], said["unheard"]) == (True, 301.0, [])
    assert said["ages_s"]["machine"] == 301.0
    assert still.world.mover.place(f"/machine/{ROBOT}").xyz == (7.0, 2.0, 0.5)
    still.obey("k", orders.Replay(52.0, 5.001, 0.0, {"slew": 2.0, "stick": -1.0}, at_ms=1000))
    assert told(still)["past_ms"] == 1000
    still.obey("k", orders.Live())
    planter = Planter(still.intake)
    planter.stand(8.0)
    assert told(still)["pose_age_s"] == 0.0, "what it says itself comes first"
    still.intake.forget(())
    still.leave("k", box)
    assert still.world.robots() == []


async def test_what_was_left_from_an_earlier_look_does_not_hide_what_the_console_heard_since(still: Studio) -> None:
    planter = Planter(still.intake)
    planter.introduce()
    planter.stand(3.0)
    still.enter("k", ROBOT, may_replay=False)
    assert told(still)["pose_age_s"] == 0.0
    still._clock.advance(60.0)  # type: ignore[attr-defined]
    at_s = now(still) - 20
    still.set_last({ROBOT: Last(9.0, 0.0, 0.0, at_s, {"slew": 1.0, "stick": -1.0}, at_s)})
    said = told(still)
    assert (said["pose_age_s"], said["ages_s"]["machine"]) == (20.0, 20.0)
    assert still.world.mover.place(f"/machine/{ROBOT}").xyz[0] == 9.0


async def test_a_robot_that_is_touched_is_told_where_it_stands_and_not_what_is_seen_behind_it(still: Studio) -> None:
    for robot, x_m in ((ROBOT, 0.0), (OTHER, 20.0)):
        planter = Planter(still.intake, robot)
        planter.introduce()
        planter.stand(x_m)
    box = still.enter("k", ROBOT, may_replay=False)
    still.tick()
    taps = []
    for x_m in (0.0, 20.0):
        still.touch("k", (x_m - 5.0, 0.0, 6.0), (1.0, 0.0, -1.0))
        while (said := box.get_nowait())["k"] != "tap":
            pass
        taps.append((said["id"], said["x_m"], said["y_m"], said["distance_m"]))
        assert still.viewers["k"].touched == (x_m, 0.0)
    assert taps == [(ROBOT, 0.0, 0.0, 0.0), (OTHER, 20.0, 0.0, 20.0)]
    planter.stand(23.0)
    for _ in range(5):
        said = told(still)
    assert (said["touched"]["x_m"], said["touched"]["distance_m"]) == (23.0, 23.0), "the mark goes with it"


async def test_a_change_of_theme_tints_the_ground_in_place_for_one_viewer(studio: Studio) -> None:
    studio.enter("k", ROBOT, may_replay=False)
    async with await connect(studio, "k") as socket:
        picture = Picture(socket)
        await picture.look()
        async with asyncio.timeout(5):
            while (client := studio.viewers["k"].client) is None:  # noqa: ASYNC110 - viser's thread hands over
                await asyncio.sleep(0.01)
        studio.obey("k", orders.Theme(dark=False))
        own = f"{client.client_id}:/ground"
        await picture.until(own, lambda said: "props" in said)
        picture.nodes[own] = {}
        studio.obey("k", orders.Theme(dark=True))
        tinted = await picture.until(own, lambda said: "props" in said or "updates" in said)
        assert tinted.get("updates") == {"color": list(DARK)}, "a plane made anew costs its shader once more"
