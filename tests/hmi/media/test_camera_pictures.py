"""Pictures of cameras in the scene: wanted only by who shows them, small, and gone when they are old."""

from __future__ import annotations

import io
import math
from pathlib import Path

import httpx
import numpy as np
import pytest
from PIL import Image

from backend_clients.edge import messages_up as up
from hmi.clock import SystemClock
from hmi.domain.picture_header import BadPicture
from hmi.media import orders
from hmi.media.camera_pictures import small, wanted
from hmi.media.control import control_app
from hmi.media.door import CAPTURED_HEADER, SECRET_HEADER
from hmi.media.models import ModelShelf
from hmi.media.studio import Studio
from hmi.twin.frusta import OLD_S
from hmi.twin.groups import Group
from tests.hmi.media.studio_stage import ROBOT, SECRET, Picture, Planter, connect

REAR, HEAD = f"/cameras/{ROBOT}/camera_rear", f"/cameras/{ROBOT}/camera_head"
CAMERAS = [up.Camera(id="rear", label="Behind", width_px=1280, height_px=720, fov_deg=82.0)]


def jpeg(width: int = 1280, height: int = 720, colour: tuple[int, int, int] = (200, 40, 40)) -> bytes:
    """Return a picture of one colour."""
    out = io.BytesIO()
    Image.new("RGB", (width, height), colour).save(out, "JPEG")
    return out.getvalue()


def test_a_picture_is_made_small_and_keeps_its_shape() -> None:
    pixels = small(jpeg())
    assert pixels.shape == (180, 320, 3)
    assert np.abs(pixels[90, 160].astype(int) - (200, 40, 40)).max() < 12


@pytest.mark.parametrize("data", [b"", b"GIF89a", jpeg()[:500], jpeg()[:-2] + b"xx", b"\xff\xd8" + bytes(400)])
def test_what_is_no_picture_is_refused(data: bytes) -> None:
    with pytest.raises(BadPicture):
        small(data)


async def test_pictures_are_wanted_while_the_layer_is_shown_and_leave_when_they_are_old(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce(cameras=CAMERAS)
    planter.stand(0.0)
    studio.enter("k", ROBOT, may_replay=False)
    async with await connect(studio, "k") as socket:
        picture = Picture(socket)
        await picture.look()
        drawn = await picture.until(REAR, lambda node: "props" in node)
        assert drawn["props"]["fov"] == pytest.approx(2 * math.atan(math.tan(math.radians(41)) * 9 / 16))
        assert wanted(studio) == {}
        studio.obey("k", orders.SetLayer(Group.CAMERAS, True))
        assert wanted(studio) == {ROBOT: ["rear", "head"]}
        site = studio.site(ROBOT)
        assert site is not None
        now_s = SystemClock().mono_s()
        site.frusta.picture("rear", small(jpeg()), now_s)
        await picture.until(REAR, lambda node: node.get("updates", {}).get("_image_data"))
        assert site.frusta.age_s(now_s + 1.0) == pytest.approx(1.0)
        site.frusta.picture("rear", small(jpeg(colour=(0, 0, 0))), now_s - 0.5)
        assert site.frusta.age_s(now_s) == pytest.approx(0.0), "an older picture is dropped"
        site.frusta.fade(now_s + OLD_S + 0.1)
        await picture.until(REAR, lambda node: node.get("updates", {"_image_data": 1}).get("_image_data") is None)
        assert site.frusta.age_s(now_s) is None


async def test_a_camera_turns_with_the_joint_it_hangs_on(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce(cameras=CAMERAS)
    planter.stand(0.0, slew=0.0)
    studio.enter("k", ROBOT, may_replay=False)
    async with await connect(studio, "k") as socket:
        picture = Picture(socket)
        await picture.look()
        before = (await picture.until(HEAD, lambda node: "position" in node))["position"]
        planter.stand(0.0, slew=1.0)
        await picture.until(HEAD, lambda node: math.dist(node["position"], before) > 1.0)


async def test_the_port_takes_pictures_and_says_what_is_wrong_with_others(studio: Studio, tmp_path: Path) -> None:
    door = httpx.ASGITransport(control_app(studio, ModelShelf(tmp_path), SECRET))
    path, when = f"/pictures/{ROBOT}/rear", {CAPTURED_HEADER: "12.5"}
    async with httpx.AsyncClient(transport=door, base_url="http://media", headers={SECRET_HEADER: SECRET}) as ask:
        assert (await ask.put(path, content=jpeg(), headers=when)).status_code == 204, "nobody looks: it is dropped"
        assert (await ask.put(path, content=jpeg())).status_code == 422
        refused = await ask.put(path, content=b"no picture", headers=when)
        assert (refused.status_code, refused.json()["code"]) == (422, "bad_picture")
        assert (await ask.get("/status")).json()["wanted"] == {}
