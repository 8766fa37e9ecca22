"""Where pictures come from: an admin's word, judged; passwords go in and never come out."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import httpx
import pytest

from hmi.domain.role import Role
from tests.hmi.pictures.conftest import MakeRig
from tests.hmi.pictures.rig import WEEDER, PictureRig

SOURCE = f"/cameras/{WEEDER}/front/source"
BARN = "/cameras/field/barn/source"
RTSP = {"kind": "rtsp", "url": "rtsp://192.168.7.20/stream1", "user": "viewer", "password": "hunter2-secret"}


async def put(browser: httpx.AsyncClient, path: str = SOURCE, **changes: Any) -> httpx.Response:
    """Set a source."""
    return await browser.put(path, json={**RTSP, **changes})


@pytest.fixture
async def farm(make_rig: MakeRig) -> PictureRig:
    """Return a farm with a network of cameras."""
    return await make_rig(camera_networks=["192.168.7.0/24"])


async def test_a_camera_without_a_source_of_its_own_is_its_robots(farm: PictureRig) -> None:
    told = (await farm.browser(Role.ADMIN).get(SOURCE)).json()
    assert told["kind"] == "robot"
    assert told["allowed"] == {"networks": ["192.168.7.0/24"], "hosts": ["10.0.0.5"], "this_machine": False}
    assert farm.desk.sources.source_of(WEEDER, "front") is None


async def test_a_source_is_kept_used_and_forgotten(farm: PictureRig) -> None:
    changes: list[str] = []
    farm.desk.sources.on_changed.append(lambda: changes.append("changed"))
    browser = farm.browser(Role.ADMIN)
    assert (await put(browser)).status_code == 200
    used = farm.desk.sources.source_of(WEEDER, "front")
    assert used is not None
    assert (used.kind, used.url, used.user, used.password) == (
        "rtsp", "rtsp://192.168.7.20/stream1", "viewer", "hunter2-secret"
    )  # fmt: skip
    assert (await browser.delete(SOURCE)).status_code == 204
    assert farm.desk.sources.source_of(WEEDER, "front") is None
    assert (await browser.delete(SOURCE)).status_code == 404
    assert len(changes) == 2


async def test_the_password_is_shown_nowhere_and_lies_in_no_file(farm: PictureRig) -> None:
    browser = farm.browser(Role.ADMIN)
    answers = [await put(browser), await browser.get(SOURCE), await browser.get("/cameras/sources")]
    for answer in answers:
        assert answer.status_code == 200
        assert "hunter2" not in answer.text
    assert answers[1].json()["has_password"] is True
    lines = await farm.audited("camera")
    assert [line.outcome for line in lines] == ["changed"]
    assert "hunter2" not in str(lines)
    await farm.records.database.run(farm.records.audit.flush)
    for path in farm.folder.rglob("*"):
        if path.is_file():
            assert b"hunter2" not in path.read_bytes(), path


async def test_a_source_survives_a_restart_and_another_secret_asks_for_the_password_again(make_rig: MakeRig) -> None:
    rig = await make_rig(camera_networks=["192.168.7.0/24"])
    await put(rig.browser(Role.ADMIN))
    rig = await make_rig(camera_networks=["192.168.7.0/24"])
    used = rig.desk.sources.source_of(WEEDER, "front")
    assert used is not None
    assert used.password == "hunter2-secret"
    rig = await make_rig(camera_networks=["192.168.7.0/24"], secret="another secret of 32 characters!")
    used = rig.desk.sources.source_of(WEEDER, "front")
    assert used is not None
    assert used.password == ""
    assert (await rig.browser(Role.ADMIN).get(SOURCE)).json()["is_password_lost"] is True


async def test_a_password_that_is_left_out_stays_only_where_it_goes_to_the_same_place(farm: PictureRig) -> None:
    browser = farm.browser(Role.ADMIN)
    wishes: list[tuple[dict[str, str], bool]] = [
        ({"url": "rtsp://192.168.7.20/stream2"}, True),
        ({"url": "rtsp://192.168.7.66/stream1"}, False),
        ({"url": "rtsp://192.168.7.20:5554/stream1"}, False),
        ({"url": "rtsps://192.168.7.20/stream1"}, False),
        ({"kind": "mjpeg", "url": "http://192.168.7.20:554/x"}, False),
        ({"user": "somebody"}, False),
    ]
    for changes, stays in wishes:
        await put(browser)
        answer = await browser.put(SOURCE, json={**{key: RTSP[key] for key in ("kind", "url", "user")}, **changes})
        assert answer.json()["has_password"] is stays, changes


async def test_an_empty_password_removes_it(farm: PictureRig) -> None:
    browser = farm.browser(Role.ADMIN)
    await put(browser)
    assert (await put(browser, password="")).json()["has_password"] is False


async def test_only_admins_see_or_change_sources(farm: PictureRig) -> None:
    for role in Role:
        browser = farm.browser(role)
        answers = [
            await browser.get(SOURCE),
            await put(browser),
            await browser.delete(SOURCE),
            await browser.post(SOURCE + "/test"),
            await browser.get("/cameras/sources"),
            await put(browser, BARN),
        ]
        assert {one.status_code == 403 for one in answers} == {role is not Role.ADMIN}, role


async def test_an_admin_of_another_farm_changes_nothing(farm: PictureRig) -> None:
    answer = await put(farm.browser(Role.ADMIN, "other-farm"))
    assert (answer.status_code, answer.json()["code"]) == (403, "other_farm")


async def test_what_is_not_used_is_refused_with_a_sentence_at_its_field(farm: PictureRig) -> None:
    browser = farm.browser(Role.ADMIN)
    wishes: list[tuple[dict[str, Any], str]] = [
        ({"url": "rtsp://10.9.9.9/x"}, "network"),
        ({"url": "rtsp://127.0.0.1/x"}, "loopback"),
        ({"url": "rtsp://169.254.169.254/x"}, "never"),
        ({"url": "rtsp://joe:pw@192.168.7.20/x"}, "user_info"),
        ({"url": "http://192.168.7.20/x"}, "scheme"),
        ({"url": ""}, "bad_url"),
        ({"kind": "upload", "url": ""}, "kind"),
        ({"kind": "robot"}, "invalid"),
        ({"url": "rtsp://192.168.7.20/" + "x" * 300}, "invalid"),
        ({"period_s": 0.1}, "invalid"),
        ({"token": "mine"}, "invalid"),
    ]
    for changes, code in wishes:
        answer = await put(browser, **changes)
        assert (answer.status_code, answer.json()["code"]) == (422, code), changes
        assert answer.json()["field"] in ("url", "kind", "period_s", "token")
    assert (await browser.get(SOURCE)).json()["kind"] == "robot"


async def test_a_test_says_that_a_picture_came(farm: PictureRig) -> None:
    browser = farm.browser(Role.ADMIN)
    await put(browser)
    farm.show()
    told = (await browser.post(SOURCE + "/test")).json()
    assert (told["ok"], told["text"], told["width_px"]) == (True, "A picture came, 64 x 48.", 64)


async def test_a_test_says_what_is_in_the_way(farm: PictureRig) -> None:
    browser = farm.browser(Role.ADMIN)
    answers = {"good.lan": ["192.168.7.9"], "moved.lan": ["169.254.169.254", "10.0.0.1"]}

    def resolve(host: str, _port: int) -> list[str]:
        if host not in answers:
            raise OSError("unknown")
        return answers[host]

    book = farm.desk.sources
    book._parts = replace(book._parts, resolve=resolve)
    texts = {}
    for host in ("good.lan", "moved.lan", "gone.lan"):
        await put(browser, url=f"rtsp://{host}/x")
        texts[host] = (await browser.post(SOURCE + "/test")).json()["text"]
    assert texts == {
        "good.lan": "The camera shows no picture now.",
        "moved.lan": "moved.lan leads to 169.254.169.254. No camera may be at 169.254.169.254.",
        "gone.lan": "gone.lan cannot be found.",
    }
    farm.cameras.is_away = True
    await put(browser, url="rtsp://good.lan/x")
    assert "does not answer" in (await browser.post(SOURCE + "/test")).json()["text"]


async def test_a_field_camera_gets_a_token_once(farm: PictureRig) -> None:
    browser = farm.browser(Role.ADMIN)
    made = (await browser.put(BARN, json={"kind": "upload", "label": "Barn"})).json()
    assert len(made["token"]) >= 40
    assert made["upload"] == "/api/v1/cameras/field/barn/frame"
    again = (await browser.put(BARN, json={"kind": "upload", "label": "Old barn"})).json()
    assert ("token" in again, again["has_token"], again["label"]) == (False, True, "Old barn")
    anew = (await browser.put(BARN, json={"kind": "upload", "new_token": True})).json()
    assert anew["token"] != made["token"]
    assert [one.camera for one in farm.desk.sources.field_cameras()] == ["barn"]
    for path in farm.folder.rglob("*"):
        if path.is_file():
            assert made["token"].encode() not in path.read_bytes()


async def test_a_farm_has_only_so_many_field_cameras(farm: PictureRig) -> None:
    browser = farm.browser(Role.ADMIN)
    for number in range(32):
        made = await browser.put(f"/cameras/field/station-{number}/source", json={"kind": "upload"})
        assert made.status_code == 200
    more = await browser.put("/cameras/field/station-99/source", json={"kind": "upload"})
    assert (more.status_code, more.json()["code"]) == (422, "too_many")
    assert (await browser.get("/cameras/field/unknown/source")).status_code == 404
