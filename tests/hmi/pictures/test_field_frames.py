"""Frames that field cameras send: only theirs, only whole ones, no more than agreed."""

from __future__ import annotations

import io
from dataclasses import dataclass

import httpx
import pytest
from PIL import Image

from hmi.domain.role import Role
from tests.hmi.pictures.conftest import MakeRig
from tests.hmi.pictures.jpeg import bomb, picture
from tests.hmi.pictures.rig import PictureRig

BARN = "/cameras/field/barn"


@dataclass
class Sender:
    """A field camera."""

    rig: PictureRig
    client: httpx.AsyncClient
    token: str

    async def send(self, data: bytes, token: str | None = None, path: str = BARN, **headers: str) -> httpx.Response:
        """Send a frame."""
        token = self.token if token is None else token
        return await self.client.post(
            path + "/frame", content=data, headers={"Authorization": f"Bearer {token}", **headers}
        )


async def sender(rig: PictureRig, **wish: object) -> Sender:
    """Return the camera of the barn."""
    wanted = {"kind": "upload", "label": "Barn", "period_s": 5.0, **wish}
    made = await rig.browser(Role.ADMIN).put(BARN + "/source", json=wanted)
    return Sender(rig, rig.browser(None), made.json()["token"])


async def test_a_frame_is_shown_and_the_first_one_kept(rig: PictureRig) -> None:
    barn, data = await sender(rig), picture(640, 480)
    answer = await barn.send(data, **{"X-Age-Ms": "1500"})
    assert answer.status_code == 204
    assert (rig.cameras.frames, rig.cameras.ages_s) == ([("barn", data)], [1.5])
    (kept,) = (await rig.browser(Role.VIEWER).get("/pictures", params={"robot": "field"})).json()["pictures"]
    assert (kept["kind"], kept["robot_name"], kept["camera"], kept["age_s"]) == ("frame", "Field", "barn", 1.5)
    assert kept["captured_utc"] == "2026-05-04T11:59:58.500+00:00"
    (camera,) = rig.desk.sources.field_cameras()
    assert (camera.width_px, camera.height_px) == (640, 480)


async def test_an_old_frame_is_shown_as_old_as_it_is_also_to_a_new_camera_process(rig: PictureRig) -> None:
    barn = await sender(rig)
    await barn.send(picture(), **{"X-Age-Ms": "300000"})
    assert rig.cameras.ages_s == [300.0]
    rig.clock.advance(60.0)
    await rig.desk.frames.show_again()
    assert rig.cameras.frames[0] == rig.cameras.frames[1]
    assert rig.cameras.ages_s[1] == pytest.approx(360.0, abs=0.01)


async def test_a_png_is_shown_to_those_who_look(rig: PictureRig) -> None:
    made = io.BytesIO()
    Image.new("RGB", (64, 48), (10, 200, 10)).save(made, "PNG")
    barn = await sender(rig)
    assert (await barn.send(made.getvalue())).status_code == 204
    ((_, shown),) = rig.cameras.frames
    assert Image.open(io.BytesIO(shown)).format == "JPEG"
    assert (await rig.desk.frames.newest("barn")).data == made.getvalue(), "what is kept stays as it came"


async def test_a_camera_that_tells_no_age_gives_its_pictures_none(rig: PictureRig) -> None:
    barn = await sender(rig)
    await barn.send(picture(), **{"X-Age-Ms": "nan"})
    (kept,) = (await rig.browser(Role.VIEWER).get("/pictures")).json()["pictures"]
    assert kept["age_s"] is None


async def test_the_newest_is_there_after_a_restart_and_can_be_kept_by_hand(make_rig: MakeRig) -> None:
    rig = await make_rig()
    barn, newest = await sender(rig), picture(shade=10)
    await barn.send(picture())
    await barn.send(newest)
    rig = await make_rig()
    rig.cameras.is_away = True
    assert (await rig.desk.frames.newest("barn")).data == newest
    made = await rig.browser(Role.OPERATOR).post(BARN + "/snapshot", json={})
    assert (made.status_code, made.json()["kind"], made.json()["lat_deg"]) == (201, "snapshot", None)


async def test_a_frame_that_comes_after_a_newer_one_does_not_take_its_place(make_rig: MakeRig) -> None:
    rig = await make_rig()
    barn, newest = await sender(rig), picture(shade=10)
    await barn.send(newest, **{"X-Age-Ms": "1000"})
    rig.clock.advance(5.0)
    assert (await barn.send(picture(shade=90), **{"X-Age-Ms": "600000"})).status_code == 204
    assert (await rig.desk.frames.newest("barn")).data == newest
    rig = await make_rig()
    barn = Sender(rig, rig.browser(None), barn.token)
    await barn.send(picture(shade=90), **{"X-Age-Ms": "600000"})
    still = await rig.desk.frames.newest("barn")
    assert still.data == newest
    assert rig.clock.mono_s() - still.captured_s < 60.0


async def test_a_frame_of_a_clock_that_ran_ahead_gives_way(rig: PictureRig) -> None:
    barn, next_one = await sender(rig), picture(shade=10)
    rig.clock.jump_wall(86_400.0)
    await barn.send(picture())
    rig.clock.jump_wall(-86_400.0)
    await barn.send(next_one)
    assert (await rig.desk.frames.newest("barn")).data == next_one


async def test_a_snapshot_of_a_camera_that_tells_no_age_claims_none_and_asks_no_camera(rig: PictureRig) -> None:
    barn, operator = await sender(rig), rig.browser(Role.OPERATOR)
    for headers, age_s in (({}, None), ({"X-Age-Ms": "1500"}, 241.5), ({}, None)):
        await barn.send(picture(), **headers)
        rig.clock.advance(240.0)
        made = await operator.post(BARN + "/snapshot", json={})
        assert (made.status_code, made.json()["age_s"]) == (201, age_s)
    assert rig.cameras.asked == [], "what it sent is here"


async def test_one_in_a_quarter_of_an_hour_is_kept_also_over_a_restart(make_rig: MakeRig) -> None:
    rig = await make_rig()
    barn = await sender(rig)
    for _ in range(25):
        assert (await barn.send(picture())).status_code == 204
        rig.clock.advance(80)
    assert len(rig.files()) == 3
    rig = await make_rig()
    rig.clock.advance(600)
    again = Sender(rig, rig.browser(None), barn.token)
    await again.send(picture())
    assert len(rig.files()) == 3
    rig.clock.advance(400)
    await again.send(picture())
    assert len(rig.files()) == 4


async def test_a_camera_may_keep_nothing(rig: PictureRig) -> None:
    barn = await sender(rig, keep_every_s=0.0)
    await barn.send(picture())
    assert rig.files() == []


async def test_frames_that_come_too_often_are_refused_with_when_to_try_again(rig: PictureRig) -> None:
    barn = await sender(rig)
    answers = [await barn.send(picture()) for _ in range(5)]
    assert [one.status_code for one in answers] == [204, 204, 204, 429, 429]
    assert int(answers[-1].headers["retry-after"]) == 4
    rig.clock.advance(4.1)
    assert (await barn.send(picture())).status_code == 204


async def test_a_camera_at_its_own_pace_is_never_refused(rig: PictureRig) -> None:
    barn = await sender(rig)
    for _ in range(30):
        assert (await barn.send(picture())).status_code == 204
        rig.clock.advance(4.9)


async def test_another_token_is_refused_before_the_frame_is_read(rig: PictureRig) -> None:
    barn = await sender(rig)
    for token in ("", "x", "0" * 43):
        answer = await barn.send(picture(), token)
        assert (answer.status_code, answer.json()["code"]) == (401, "bad_token")
    assert rig.cameras.frames == []


async def test_a_token_is_good_for_its_own_camera_only_and_ends_with_it(rig: PictureRig) -> None:
    barn = await sender(rig)
    admin = rig.browser(Role.ADMIN)
    await admin.put("/cameras/field/gate/source", json={"kind": "upload"})
    assert (await barn.send(picture(), path="/cameras/field/gate")).status_code == 401
    assert (await barn.send(picture(), path="/cameras/field/nowhere")).status_code == 401
    assert (await barn.send(picture())).status_code == 204
    assert (await admin.delete(BARN + "/source")).status_code == 204
    assert (await barn.send(picture())).status_code == 401
    assert not list((rig.folder / "pictures/newest").rglob("*.picture"))


async def test_an_admins_session_is_no_token(rig: PictureRig) -> None:
    await sender(rig)
    assert (await rig.browser(Role.ADMIN).post(BARN + "/frame", content=picture())).status_code == 401


async def test_what_is_no_picture_is_refused_and_harms_nothing(rig: PictureRig) -> None:
    barn = await sender(rig)
    for data, code in (
        (bomb(16_384, 16_384), "too_large"),
        (picture()[:-40], "truncated"),
        (b"GIF89a", "not_a_picture"),
        (b"", "not_a_picture"),
    ):
        answer = await barn.send(data)
        assert (answer.status_code, answer.json()["code"]) == (422, code)
        rig.clock.advance(5)
    assert (rig.cameras.frames, rig.files()) == ([], [])
    assert (await barn.send(picture())).status_code == 204


@pytest.mark.parametrize("is_told", [True, False])
async def test_more_than_8_mb_is_refused_told_or_counted(rig: PictureRig, *, is_told: bool) -> None:
    barn = await sender(rig)
    large = picture() + b"\x00" * (8 * 1024 * 1024)

    async def pieces() -> object:
        for start in range(0, len(large), 1 << 20):
            yield large[start : start + (1 << 20)]

    headers = {"Authorization": f"Bearer {barn.token}"}
    content = large if is_told else pieces()
    answer = await barn.client.post(BARN + "/frame", content=content, headers=headers)  # type: ignore[arg-type]
    assert (answer.status_code, answer.json()["code"]) == (413, "too_large")


async def test_a_frame_is_kept_while_the_camera_process_is_away(rig: PictureRig) -> None:
    barn = await sender(rig)
    rig.cameras.is_away = True
    assert (await barn.send(picture())).status_code == 204
    assert len(rig.files()) == 1


async def test_a_full_disk_is_said_to_the_camera_and_the_next_frame_is_kept_when_there_is_room(rig: PictureRig) -> None:
    barn = await sender(rig)
    rig.free_bytes = 0
    answer = await barn.send(picture())
    assert (answer.status_code, answer.json()["code"]) == (507, "disk_full")
    assert len(rig.cameras.frames) == 1
    rig.free_bytes = 10_000_000_000
    rig.clock.advance(5)
    assert (await barn.send(picture())).status_code == 204
    assert len(rig.files()) == 1
