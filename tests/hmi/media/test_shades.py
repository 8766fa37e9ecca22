"""What is old or was never told is drawn as a grey shade, now and in a replay, of every robot."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest

from backend_clients.edge.machine import GaugeInfo
from backend_clients.edge.messages_up import Telemetry
from backend_clients.edge.topics import Up
from hmi.clock import FakeClock
from hmi.media import orders
from hmi.media.intake import Intake
from hmi.media.status import status_of
from hmi.media.studio import Studio
from hmi.twin.doubt import EVERYTHING
from hmi.twin.farm import Farm, FarmRobot, Last
from hmi.twin.machine import Form, MachineView
from hmi.twin.mesh_files import MeshFolder
from hmi.twin.skin import skin_of
from hmi.twin.urdf import parse_urdf
from tests.hmi.media.studio_stage import OTHER, ROBOT, SECRET, Picture, Planter, connect

JOINTS = {"slew": 1.0, "stick": -1.0}
PLACE: dict[str, Any] = {
    "lat_deg": 52.0, "lon_deg": 5.0, "x_m": 1.0, "y_m": 0.0, "theta_rad": 0.0, "speed_mps": 0.0,
}  # fmt: skip
SOLID, SHADE = {"body": "solid", "arm": "solid"}, {"body": "shade", "arm": "shade"}
ARM_UNKNOWN = {"body": "solid", "arm": "shade"}


@pytest.fixture
async def still(tmp_path: Path) -> AsyncIterator[Studio]:
    """A studio that draws when told, with two robots; somebody looks at the first."""
    clock = FakeClock()
    made = Studio(Intake(clock), tmp_path, SECRET, clock)
    made.set_farm(Farm([FarmRobot(ROBOT, "Planter 02", 6.2), FarmRobot(OTHER, "Planter 03", 6.2)]))
    made.enter("k", ROBOT, may_replay=True)
    yield made
    await made.stop()


def pass_time(studio: Studio, seconds: float, *planters: Planter) -> None:
    """Let time pass, for robots as well."""
    studio._clock.advance(seconds)  # type: ignore[attr-defined]
    for one in planters:
        one.rest(seconds)


def drawn(studio: Studio, robot: str) -> MachineView:
    """Return the drawing of a robot."""
    solid = studio.world.solid(robot)
    assert solid is not None
    return solid


def arm_of(view: MachineView) -> str:
    """Return a link that the first joint moves."""
    return min(view.form.kinematics.moved_by({"slew"}) & set(view.form.solid))


def looks(studio: Studio, robot: str) -> dict[str, str]:
    """Draw, and return how body and arm of a robot are seen."""
    studio.tick()
    view, scene, found = drawn(studio, robot), studio.server.scene, {}
    for part, link in (("body", view.form.model.root), ("arm", arm_of(view))):
        skin, shade = scene.get_handle_by_name(view.skin(link)), scene.get_handle_by_name(view.shade(link))
        is_shade = shade is not None and shade.visible
        assert skin is not None
        assert skin.visible is not is_shade
        found[part] = "shade" if is_shade else "solid"
    return found


def told(studio: Studio) -> dict[str, Any]:
    """Return what the page is told."""
    return status_of(studio, studio.viewers["k"], studio._clock.mono_s())


async def test_another_robot_that_fell_silent_is_a_shade_until_it_speaks_again(still: Studio) -> None:
    planter, away = Planter(still.intake), Planter(still.intake, OTHER)
    for one, x_m in ((planter, 0.0), (away, 9.0)):
        one.introduce()
        one.stand(x_m)
    assert looks(still, OTHER) == SOLID
    pass_time(still, 2.5, planter, away)
    planter.stand(0.0)
    assert (looks(still, OTHER), looks(still, ROBOT)) == (SHADE, SOLID)
    away.stand(9.0)
    assert looks(still, OTHER) == SOLID


async def test_joints_that_are_old_or_were_not_told_make_a_shade_of_the_arm_alone(still: Studio) -> None:
    away = Planter(still.intake, OTHER)
    away.introduce()
    away.say(Up.TELEMETRY, Telemetry, **PLACE)
    assert looks(still, OTHER) == ARM_UNKNOWN, "never told"
    away.stand(1.0)
    assert looks(still, OTHER) == SOLID
    pass_time(still, 2.5, away)
    away.say(Up.TELEMETRY, Telemetry, **PLACE)
    assert looks(still, OTHER) == ARM_UNKNOWN, "old"


async def test_a_robot_that_was_silent_before_anybody_looked_stands_beside_as_a_shade(still: Studio) -> None:
    for robot in (ROBOT, OTHER):
        Planter(still.intake, robot).introduce()
    at_s = still._clock.mono_s() - 900
    still.set_last({OTHER: Last(0.0, 0.0, 0.5, at_s, JOINTS, at_s, lat_lon_deg=(52.0, 5.0001))})
    assert looks(still, OTHER) == SHADE
    assert still.world.mover.place(f"/machine/{OTHER}").xyz[0] == pytest.approx(6.86, abs=0.05), "as recorded"


async def test_a_pose_recorded_without_joints_has_no_age_and_one_with_them_its_own(still: Studio) -> None:
    Planter(still.intake).introduce()
    at_s = still._clock.mono_s() - 900
    last = Last(0.0, 0.0, 0.5, at_s, lat_lon_deg=(52.0, 5.0001))
    still.set_last({ROBOT: last})
    assert looks(still, ROBOT) == SHADE
    assert (told(still)["pose_age_s"], told(still)["unheard"]) == (None, ["slew", "stick"])
    still.set_last({ROBOT: Last(0.0, 0.0, 0.5, at_s, JOINTS, at_s, lat_lon_deg=(52.0, 5.0001))})
    assert looks(still, ROBOT) == SHADE
    assert (told(still)["pose_age_s"], told(still)["unheard"]) == (900.0, [])


async def test_a_machine_whose_height_was_not_told_or_is_old_is_not_known_to_be_there(still: Studio) -> None:
    height = GaugeInfo(key="height", label="Height", unit="m", lower=0.0, upper=50.0)
    drone = Planter(still.intake)
    drone.introduce(joints=[], gauges=[height])
    drone.say(Up.TELEMETRY, Telemetry, **PLACE)
    assert looks(still, ROBOT) == SHADE
    assert told(still)["pose_age_s"] is None
    drone.stand(1.0)
    assert (looks(still, ROBOT), told(still)["pose_age_s"]) == (SOLID, 0.0)
    pass_time(still, 5.0, drone)
    drone.say(Up.TELEMETRY, Telemetry, **PLACE)
    assert (looks(still, ROBOT), told(still)["pose_age_s"]) == (SHADE, pytest.approx(5.1, abs=0.2))


async def test_a_moment_recorded_without_joints_has_a_shade_for_an_arm_and_one_with_them_is_solid(
    studio: Studio,
) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(0.0)
    studio.enter("k", ROBOT, may_replay=True)
    async with await connect(studio, "k") as socket:
        picture = Picture(socket)
        await picture.look()
        await picture.until(f"/machine/{ROBOT}")
        async with asyncio.timeout(5):
            while (client := studio.viewers["k"].client) is None:  # noqa: ASYNC110 - viser's thread hands over
                await asyncio.sleep(0.01)
        planter.stand(0.0)
        studio.tick()
        view, own = drawn(studio, ROBOT), f"{client.client_id}:"
        skin, shade = own + view.skin(arm_of(view)), own + view.shade(arm_of(view))
        studio.obey("k", orders.Replay(52.0, 5.001, 0.0, {}, at_ms=1000))
        assert told(studio)["past_unheard"] == ["slew", "stick"]
        assert (await picture.until(skin, lambda said: "visible" in said))["visible"] is False
        await picture.until(shade, lambda said: "props" in said)
        assert own + view.skin(view.form.model.root) not in picture.nodes, "where it stood is recorded"
        planter.stand(0.0)
        studio.obey("k", orders.Replay(52.0, 5.001, 0.0, JOINTS, at_ms=2000))
        assert told(studio)["past_unheard"] == []
        async with asyncio.timeout(10):
            while skin in picture.nodes or shade in picture.nodes:
                picture._take(bytes(await socket.recv()))  # type: ignore[arg-type]


async def test_the_record_is_solid_though_the_robot_is_silent_now(still: Studio) -> None:
    planter = Planter(still.intake)
    planter.introduce()
    planter.stand(0.0)
    pass_time(still, 60.0)
    assert looks(still, ROBOT) == SHADE
    still.obey("k", orders.Replay(52.0, 5.001, 0.0, JOINTS, at_ms=1000))
    past, view = still.viewers["k"].past, drawn(still, ROBOT)
    assert past is not None
    root = view.form.model.root
    assert past.skins[view.skin(root)] == view.form.solid[root]
    assert past.skins[view.shade(root)] is None


async def test_a_link_may_be_called_as_what_is_drawn_is(still: Studio) -> None:
    links = "".join(
        f'<link name="{name}"><visual><geometry><box size="1 1 1"/></geometry></visual></link>'
        for name in ("base", "skin", "shade")
    )
    joints = "".join(
        f'<joint name="{name}" type="fixed"><parent link="base"/><child link="{name}"/></joint>'
        for name in ("skin", "shade")
    )
    model = parse_urdf(f'<robot name="r">{links}{joints}</robot>'.encode())
    form = Form.of(model, skin_of(model, MeshFolder(Path()).read))
    view = MachineView(still.server.scene, still.world.mover, "/machine/r", form)
    view.doubt(EVERYTHING)
    drawn_as = [still.server.scene.get_handle_by_name(name) for name in ("/machine/r/skin", "/machine/r/shade")]
    assert [type(node).__name__ for node in drawn_as] == ["FrameHandle", "FrameHandle"]
