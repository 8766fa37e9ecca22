"""What the camera process may open follows what an admin said."""

from __future__ import annotations

import pytest

from hmi.app.camera_rule import CameraRule
from hmi.cameras.addresses import is_allowed
from hmi.domain.camera import CameraInfo, Source, SourceKind
from hmi.domain.role import Role
from tests.hmi.pictures.conftest import MakeRig
from tests.hmi.pictures.rig import WEEDER, PictureRig

FRONT = CameraInfo("front", "Front", 640, 480)
OWN = Source(WEEDER, FRONT, SourceKind.ROBOT, "http://10.0.0.5:9000", "token of the robot", is_on=False)


async def opened(rig: PictureRig) -> list[Source]:
    """Return what is opened of one camera of the weeder, and of the field's."""
    return CameraRule(rig.desk.sources)([OWN])


async def test_without_a_word_of_an_admin_a_robots_camera_is_its_own(rig: PictureRig) -> None:
    assert await opened(rig) == [OWN]


async def test_a_source_that_is_set_takes_the_place_of_the_robots_and_never_its_token(make_rig: MakeRig) -> None:
    rig = await make_rig(camera_networks=["192.168.7.0/24"])
    wish = {"kind": "rtsp", "url": "rtsp://192.168.7.20/x", "user": "viewer", "password": "hunter2"}
    await rig.browser(Role.ADMIN).put(f"/cameras/{WEEDER}/front/source", json=wish)
    (source,) = await opened(rig)
    assert (source.kind, source.url, source.token, source.camera) == (SourceKind.RTSP, wish["url"], "", FRONT)
    assert (source.user, source.password, source.nets, source.is_on) == ("viewer", "hunter2", ("192.168.7.0/24",), True)


async def test_field_cameras_are_opened_too(make_rig: MakeRig) -> None:
    rig = await make_rig(camera_networks=["192.168.7.0/24"])
    admin = rig.browser(Role.ADMIN)
    await admin.put("/cameras/field/barn/source", json={"kind": "upload", "label": "Barn", "period_s": 5.0})
    await admin.put("/cameras/field/gate/source", json={"kind": "mjpeg", "url": "http://gate.lan/x"})
    _, barn, gate = await opened(rig)
    assert (barn.name, barn.camera.label, barn.kind, barn.period_s) == ("field/barn", "Barn", SourceKind.UPLOAD, 5.0)
    assert (gate.name, gate.kind, gate.nets) == ("field/gate", SourceKind.MJPEG, ("192.168.7.0/24",))


async def test_a_camera_that_its_robot_does_not_tell_of_is_one_too_while_the_robot_is_registered(
    make_rig: MakeRig,
) -> None:
    rig = await make_rig(camera_networks=["192.168.7.0/24"])
    wish = {"kind": "rtsp", "url": "rtsp://192.168.7.20/x", "user": "viewer", "password": "hunter2"}
    await rig.browser(Role.ADMIN).put(f"/cameras/{WEEDER}/tank/source", json=wish)
    own, tank = await opened(rig)
    assert (own, tank.name, tank.kind, tank.password) == (OWN, f"{WEEDER}/tank", SourceKind.RTSP, "hunter2")
    assert (tank.nets, tank.is_on) == (("192.168.7.0/24",), True)
    assert rig.desk.cameras_of(WEEDER) == ["front", "rear", "tank"], "recorded as its others are"
    await rig.records.database.run(rig.records.robots.remove, WEEDER)
    assert await opened(rig) == [OWN]


async def test_a_snapshot_is_asked_for_as_often_as_an_admin_said_and_else_twice_a_second(make_rig: MakeRig) -> None:
    rig = await make_rig(camera_networks=["192.168.7.0/24"])
    admin = rig.browser(Role.ADMIN)
    wish = {"kind": "snapshot", "url": "http://192.168.7.20/still.jpg"}
    await admin.put(f"/cameras/{WEEDER}/front/source", json=wish)
    await admin.put("/cameras/field/gate/source", json=wish | {"period_s": 2.0})
    front, gate = await opened(rig)
    assert (front.period_s, gate.period_s) == (0.5, 2.0)
    await admin.put("/cameras/field/gate/source", json=wish)
    assert (await opened(rig))[1].period_s == 2.0, "what was said stays"


async def test_a_name_without_any_network_of_cameras_leads_nowhere(rig: PictureRig) -> None:
    wish = {"kind": "mjpeg", "url": "http://gate.lan/x"}
    await rig.browser(Role.ADMIN).put("/cameras/field/gate/source", json=wish)
    source = (await opened(rig))[-1]
    assert not any(is_allowed(one, source.nets) for one in ("127.0.0.1", "10.0.0.5", "8.8.8.8", "::1", "192.168.7.20"))


@pytest.mark.parametrize(
    ("address", "nets", "is_good"),
    [
        ("10.0.0.5", (), True),
        ("127.0.0.1", (), True),
        ("169.254.169.254", (), False),
        ("fe80::1%eth0", (), False),
        ("fd00:ec2::254", (), False),
        ("192.168.7.20", ("192.168.7.0/24",), True),
        ("::ffff:192.168.7.20", ("192.168.7.0/24",), True),
        ("192.168.8.20", ("192.168.7.0/24",), False),
        ("127.0.0.1", ("0.0.0.0/0",), False),
        ("127.0.0.1", ("127.0.0.0/8",), True),
        ("64:ff9b::7f00:1", ("::/0",), False),
        ("no address", ("0.0.0.0/0",), False),
    ],
)
def test_a_worker_judges_addresses_as_the_console_does(address: str, nets: tuple[str, ...], *, is_good: bool) -> None:
    assert is_allowed(address, nets) is is_good
