"""Cameras in the cloud: each once, valid against its model, off when its robot is gone, and never a picture."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from hmi.cloud.cameras import LOOK_EVERY_S, CameraStates, FieldCamera
from hmi.domain.camera import CameraInfo, CameraPtz
from hmi.store.fleet import Changes
from hmi.store.robot_record import Part
from tests.hmi.cloud.rig import Fleet, Rig
from tests.hmi.fiware.models import check
from tests.hmi.fiware.robots import a_robot

FRONT = CameraInfo("front", "Front", 2048, 1536, fps=4.0, ptz=CameraPtz("pan", "tilt"))
REAR = CameraInfo("rear", "Rear", 640, 480)
MAST = CameraInfo("multispec-01", "Multispectral 1", 640, 480)


class Watched(Fleet):
    """What ``CameraStates`` reads of the live store."""

    def __init__(self) -> None:
        super().__init__()
        self.online: set[str] = set()
        self.removed: frozenset[str] = frozenset()

    def is_online(self, robot_id: str) -> bool:
        """See ``FleetStore``."""
        return robot_id in self.online

    def since(self, revision: int) -> Changes:
        """See ``FleetStore``; everything here comes with a factsheet."""
        found = super().since(revision)
        return Changes(found.revision, dict.fromkeys(found.robots, frozenset({Part.FACTSHEET})), self.removed)

    def has(self, robot_id: str, *cameras: CameraInfo) -> None:
        """Let a robot tell its cameras."""
        sheet = SimpleNamespace(cameras=cameras)
        self.put(replace(a_robot(robot_id), factsheet=sheet))  # type: ignore[arg-type]
        self.online.add(robot_id)


class Farm(Rig):
    """A mirror with cameras."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.watched, self.field = Watched(), [FieldCamera(MAST, (52.0, 5.0))]
        self.cameras = CameraStates(self.watched, lambda: self.field, self.urns, self.clock)  # type: ignore[arg-type]
        self.mirror._others = lambda: [self.cameras]


@pytest.fixture
async def farm(tmp_path: Path) -> Farm:
    """Return a farm with a robot, a mast, and a cloud that is there."""
    made = Farm(tmp_path)
    made.watched.has("weeder-01", FRONT, REAR)
    for entity in made.cameras.reports(100):
        check(entity)
    await made.run(2)
    return made


async def test_cameras_of_robots_and_of_the_field_are_in_the_cloud_once(farm: Farm) -> None:
    found = await farm.in_cloud("Camera")
    assert set(found) == {farm.urns.of("Camera", name) for name in
                          ("weeder-01:front", "weeder-01:rear", "field:multispec-01")}  # fmt: skip
    front = found[farm.urns.of("Camera", "weeder-01:front")]
    assert (front["on"], front["cameraType"], front["headland"]["widthPx"]) == (True, "PTZ", 2048)
    assert found[farm.urns.of("Camera", "field:multispec-01")]["location"]["coordinates"] == [5.0, 52.0]
    assert not {"streamURL", "imageSnapshot"} & set(front)
    await farm.run(2 * LOOK_EVERY_S, step_s=5)
    assert farm.mirror.counts.others == 3
    await farm.close()


async def test_a_camera_whose_robot_is_not_heard_or_that_was_taken_away_is_told_off(farm: Farm) -> None:
    farm.watched.online.clear()
    farm.watched.has("weeder-02", FRONT)
    farm.field.clear()
    await farm.run(LOOK_EVERY_S + 5, step_s=5)
    on = {key.partition("hof:")[2]: one.get("on") for key, one in (await farm.in_cloud("Camera")).items()}
    assert on == {"weeder-01:front": False, "weeder-01:rear": False, "weeder-02:front": True,
                  "field:multispec-01": False}  # fmt: skip
    told = farm.mirror.counts.others
    await farm.run(LOOK_EVERY_S + 5, step_s=5)
    assert farm.mirror.counts.others == told
    await farm.close()


async def test_a_broker_that_forgot_is_told_of_every_camera_again(farm: Farm) -> None:
    farm.cameras.forget()
    await farm.run(2)
    assert farm.mirror.counts.others == 6
    await farm.close()


async def test_robots_of_others_have_no_cameras_here(farm: Farm) -> None:
    farm.watched.put(replace(farm.watched.known["weeder-01"], id="stranger", is_registered=False))
    await farm.run(LOOK_EVERY_S + 5, step_s=5)
    assert len(await farm.in_cloud("Camera")) == 3
    await farm.close()
