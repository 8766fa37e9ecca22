"""A robot that is not ours, as docs/describe_your_robot.md describes it: its zip is read, its arm moves."""

from __future__ import annotations

import asyncio
import importlib.util
import json
from collections.abc import AsyncIterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import decode_body
from backend_clients.edge.topics import Up, parse, topic
from hmi.clock import SystemClock
from hmi.media.intake import Intake
from hmi.media.studio import Studio
from hmi.twin.farm import Farm, FarmRobot
from hmi.twin.kinematics import Place
from hmi.twin.upload import read_upload

ROOT = Path(__file__).parents[3]


def example(name: str = "berry_picker") -> ModuleType:
    """Return a script of the documentation."""
    spec = importlib.util.spec_from_file_location(name, ROOT / f"docs/plans/{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


async def own_model_is_ready(studio: Studio, robot_id: str) -> None:
    """Wait for the thread that reads uploads."""
    found = studio.intake.newest(robot_id, Up.FACTSHEET, up.Factsheet)
    assert found is not None
    async with asyncio.timeout(20):
        while studio.library.kind_of(found[0]) == "loading":  # noqa: ASYNC110 - a thread reads
            await asyncio.sleep(0.01)


@pytest.fixture
async def studio(tmp_path: Path) -> AsyncIterator[Studio]:
    """A studio that draws for somebody."""
    made = Studio(Intake(SystemClock()), tmp_path / "models", "secret", SystemClock())
    made.start()
    yield made
    await made.stop()


async def test_a_robot_nobody_knows_is_a_plain_shape_and_then_its_own_model_with_a_moving_arm(
    studio: Studio, tmp_path: Path
) -> None:
    berry = example()
    picker = berry.BerryPicker()
    studio.set_farm(Farm([FarmRobot(berry.ROBOT, "Berry picker 1")]))
    studio.intake.take(topic(berry.ROBOT, Up.FACTSHEET), picker.factsheet(), True)

    def live(t_s: float) -> None:
        for kind, payload in picker.now(t_s):
            studio.intake.take(topic(berry.ROBOT, kind), payload, False)
        studio.tick()

    live(1.0)
    plain = studio.world.form_of(berry.ROBOT)
    assert plain is not None
    assert plain.model.name == "plain"
    berry.write_model(tmp_path / "own.zip")
    told = read_upload(tmp_path / "own.zip", tmp_path / "models" / berry.ROBOT)
    assert told["joints"] == ["turn", "lift", "reach"]
    assert told["notices"] == []
    live(2.0)
    await own_model_is_ready(studio, berry.ROBOT)
    live(2.2)
    own = studio.world.form_of(berry.ROBOT)
    assert own is not None
    assert own.model.name == "berry_picker"
    seen: set[Place] = set()
    for moment_s in (2.4, 2.8, 3.4, 4.0):
        live(moment_s)
        seen.add(studio.world.mover.place(f"/machine/{berry.ROBOT}/post/arm/tool"))
    assert len(seen) == 4


async def test_any_model_is_shown_swinging_its_joints_before_its_robot_can_speak(
    studio: Studio, tmp_path: Path
) -> None:
    any_urdf, archive = example("any_urdf"), tmp_path / "own.zip"
    example().write_model(archive)
    name, joints, notices = any_urdf.joints_of(archive)
    assert (name, notices) == ("berry_picker", [])
    robot = any_urdf.AnyRobot("any-1", name, joints)
    read_upload(archive, tmp_path / "models" / robot.id)
    studio.set_farm(Farm([FarmRobot(robot.id, name)]))
    studio.intake.take(topic(robot.id, Up.FACTSHEET), robot.factsheet(), True)
    studio.tick()
    await own_model_is_ready(studio, robot.id)
    seen: list[set[Place]] = [set(), set(), set()]
    for tenth in range(1, 60, 4):
        for kind, payload in robot.now(tenth / 10):
            studio.intake.take(topic(robot.id, kind), payload, False)
        studio.tick()
        for places, frame in zip(seen, ("post", "post/arm", "post/arm/tool"), strict=True):
            places.add(studio.world.mover.place(f"/machine/{robot.id}/{frame}"))
    assert all(len(places) > 3 for places in seen), "each of the three joints moved"


async def test_a_robot_that_says_plain_json_keeps_its_chart_moves_its_mast_and_tells_how_long_each_state_took(
    studio: Studio, tmp_path: Path
) -> None:
    script = example("mower")
    mower, robot_id = script.Mower(), script.ROBOT
    studio.set_farm(Farm([FarmRobot(robot_id, "Mower 7")]))

    def take(said: tuple[str, dict[str, Any]], is_kept: bool = False) -> Any:
        address, payload = topic(robot_id, Up(said[0])), json.dumps(said[1]).encode()
        studio.intake.take(address, payload, is_kept)
        return decode_body(parse(address), payload)

    sheet = take(mower.factsheet(), is_kept=True)
    assert [take(said, is_kept=True).name for said in mower.nodes(0.0)] == ["deck", "diary"]
    script.write_model(tmp_path / "own.zip")
    told = read_upload(tmp_path / "own.zip", tmp_path / "models" / robot_id)
    assert (told["joints"], told["notices"]) == (["mast_lift", "head_pan"], [])
    studio.tick()
    await own_model_is_ready(studio, robot_id)
    declared = {one.id: one for one in sheet.chart.states}
    stood, left, path = set(), [], set()
    for tenth in range(1, 300):
        for said in mower.now(tenth / 10):
            message = take(said)
            if isinstance(message, up.State):
                active = {one.id for one in message.active}
                assert {"mow", "drive", "mast"} < active
                assert all(declared[one].parent in (None, *active) for one in active)
                assert len(active) == 5, "one leaf in each region"
                path.add(tuple(message.path))
            if isinstance(message, up.Event) and message.kind == "state_left":
                left.append((message.data["state"], round(message.data["duration_ms"] / 1000)))
        if tenth % 10 == 0:
            studio.tick()
            stood.add(studio.world.mover.place(f"/machine/{robot_id}/mast"))
    assert {("row", 10), ("turn", 3), ("look", 4), ("low", 6)} <= set(left)
    assert path == {("Mow", "Row"), ("Mow", "Turn")}
    assert len(stood) > 10
    posture = studio.posture(robot_id)
    assert posture is not None
    assert posture.unheard == ()
