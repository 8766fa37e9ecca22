"""Pictures over REST: who may, what is told, and nothing that leads elsewhere."""

from __future__ import annotations

import io
from typing import Any

import pytest
from PIL import Image

from hmi.domain.role import Role
from tests.hmi.pictures.conftest import MakeRig
from tests.hmi.pictures.jpeg import picture
from tests.hmi.pictures.rig import WEEDER, PictureRig

SNAPSHOT = f"/cameras/{WEEDER}/front/snapshot"
OPERATORS = (Role.OPERATOR, Role.SUPERVISOR, Role.DISPATCHER, Role.ADMIN)


async def test_a_snapshot_holds_where_and_when_during_what_and_by_whom(rig: PictureRig) -> None:
    data = rig.show()
    rig.stand(row=4)
    answer = await rig.browser(Role.OPERATOR).post(SNAPSHOT, json={"note": "  a stone   in row 4 "})
    told = answer.json()
    assert answer.status_code == 201
    assert (told["kind"], told["robot"], told["robot_name"], told["camera"]) == (
        "snapshot",
        WEEDER,
        "Weeder 01",
        "front",
    )
    assert (told["note"], told["by"], told["device"]) == ("a stone in row 4", "Operator Person", "Tablet 3")
    assert told["width_px"] == 64
    assert told["captured_utc"] == "2026-05-04T11:59:59.800+00:00"
    assert told["age_s"] == pytest.approx(0.2)
    assert (told["lat_deg"], told["lon_deg"], told["heading_deg"]) == (51.5, 4.25, 90.0)
    assert told["position_age_s"] == pytest.approx(0.3)
    assert told["mission"] == {"id": "m-1", "name": "Home field, all rows", "row": 4}
    assert told["size_bytes"] == len(data)
    assert (rig.cameras.asked, rig.cameras.full) == ([(WEEDER, "front", 1.0)], 1)
    (line,) = await rig.audited("picture")
    assert (line.outcome, line.actor, line.robot_id, line.ref) == ("kept", "Operator Person", WEEDER, told["id"])
    assert rig.events == [{"kind": "picture", "what": "kept", "id": told["id"], "robot": WEEDER}]


async def test_a_camera_that_tells_no_time_gives_no_age(rig: PictureRig) -> None:
    rig.show()
    rig.cameras.is_dated = False
    told = (await rig.browser(Role.OPERATOR).post(SNAPSHOT, json={})).json()
    assert told["age_s"] is None


async def test_operators_keep_pictures_everybody_sees_them_admins_delete_them(rig: PictureRig) -> None:
    rig.show()
    for role in Role:
        kept = (await rig.browser(Role.OPERATOR).post(SNAPSHOT, json={})).json()["id"]
        browser = rig.browser(role)
        answers = [
            await browser.get("/pictures"),
            await browser.get(f"/pictures/{kept}/file"),
            await browser.post(SNAPSHOT, json={}),
            await browser.patch(f"/pictures/{kept}", json={"is_kept": True}),
            await browser.delete(f"/pictures/{kept}"),
            await browser.get(f"/pictures/{kept}"),
        ]
        keeps, deletes = role in OPERATORS, role is Role.ADMIN
        assert [one.status_code for one in answers] == [
            200, 200, 201 if keeps else 403, 200 if keeps else 403, 204 if deletes else 403, 404 if deletes else 200
        ], role  # fmt: skip


async def test_who_is_not_signed_in_sees_nothing(rig: PictureRig) -> None:
    rig.show()
    kept = (await rig.browser(Role.OPERATOR).post(SNAPSHOT, json={})).json()["id"]
    nobody = rig.browser(None)
    for method, path in (
        ("GET", "/pictures"), ("GET", f"/pictures/{kept}"), ("GET", f"/pictures/{kept}/file"), ("POST", SNAPSHOT),
        ("PATCH", f"/pictures/{kept}"), ("DELETE", f"/pictures/{kept}"), ("GET", "/cameras/sources"),
        ("GET", f"/cameras/{WEEDER}/front/source"), ("POST", f"/cameras/{WEEDER}/front/source/test"),
    ):  # fmt: skip
        json = {} if method in ("POST", "PATCH") and not path.endswith("test") else None
        answer = await nobody.request(method, path, json=json)
        assert (answer.status_code, answer.json()["code"]) == (401, "not_signed_in"), path


async def test_another_farm_sees_nothing_and_takes_nothing(rig: PictureRig) -> None:
    rig.show()
    kept = (await rig.browser(Role.OPERATOR).post(SNAPSHOT, json={})).json()["id"]
    stranger = rig.browser(Role.ADMIN, "other-farm")
    assert (await stranger.get("/pictures")).json()["pictures"] == []
    assert (await stranger.get(f"/pictures/{kept}/file")).status_code == 404
    assert (await stranger.delete(f"/pictures/{kept}")).status_code == 404
    assert (await stranger.post(SNAPSHOT, json={})).status_code == 403


async def test_a_camera_that_shows_nothing_and_a_process_that_is_away_are_told_apart(rig: PictureRig) -> None:
    browser = rig.browser(Role.OPERATOR)
    dark = await browser.post(SNAPSHOT, json={})
    assert (dark.status_code, dark.json()["code"]) == (409, "no_picture")
    rig.cameras.is_away = True
    away = await browser.post(SNAPSHOT, json={})
    assert (away.status_code, away.json()["code"]) == (503, "cameras_down")
    rig.cameras.is_away = False
    rig.show(data=b"\xff\xd8 garbage")
    assert (await browser.post(SNAPSHOT, json={})).status_code == 409
    assert rig.files() == []


async def test_a_full_disk_is_said_in_a_sentence(rig: PictureRig) -> None:
    rig.show()
    rig.free_bytes = 1
    answer = await rig.browser(Role.OPERATOR).post(SNAPSHOT, json={})
    assert (answer.status_code, answer.json()["code"]) == (507, "disk_full")
    room = (await rig.browser(Role.VIEWER).get("/pictures")).json()["room"]
    assert (room["is_ok"], room["free_bytes"], room["floor_bytes"]) == (False, 1, 2_000_000_000)


async def test_the_list_comes_in_pages_newest_first_and_skips_nothing(rig: PictureRig) -> None:
    rig.show()
    browser = rig.browser(Role.OPERATOR)
    kept = []
    for number in range(7):
        kept.append((await browser.post(SNAPSHOT, json={})).json()["id"])
        rig.clock.advance(0 if number % 2 else 3600)  # two at the same moment
    seen: list[str] = []
    page = (await browser.get("/pictures", params={"limit": 3})).json()
    while True:
        seen += [one["id"] for one in page["pictures"]]
        if page["next"] is None:
            break
        page = (await browser.get("/pictures", params={"limit": 3, "before": page["next"]})).json()
    assert sorted(seen) == sorted(kept)
    assert len(seen) == 7
    assert seen[-1] == kept[0]


async def test_the_list_is_filtered(rig: PictureRig) -> None:
    rig.show()
    rig.show("rear")
    browser = rig.browser(Role.OPERATOR)
    first = (await browser.post(SNAPSHOT, json={})).json()["id"]
    await browser.patch(f"/pictures/{first}", json={"is_kept": True})
    await browser.post(f"/cameras/{WEEDER}/rear/snapshot", json={})
    rig.clock.advance(3601)
    rig.stand(row=2)
    await browser.post(SNAPSHOT, json={})
    wishes: list[tuple[dict[str, Any], int]] = [
        ({}, 3),
        ({"robot": WEEDER}, 3),
        ({"robot": "weeder-02"}, 0),
        ({"camera": "rear"}, 1),
        ({"kind": "snapshot"}, 3),
        ({"kind": ["clip", "mission"]}, 0),
        ({"mission": "m-1"}, 1),
        ({"from": "2026-05-04T13:00:00Z"}, 1),
        ({"to": "2026-05-04T15:00:00+02:00"}, 2),
        ({"kept": "true"}, 1),
        ({"cause": "stop.%"}, 0),
    ]
    for wanted, count in wishes:
        answer = await browser.get("/pictures", params=wanted)
        assert len(answer.json()["pictures"]) == count, wanted


async def test_a_list_that_cannot_be_meant_is_refused(rig: PictureRig) -> None:
    browser = rig.browser(Role.VIEWER)
    wishes: list[dict[str, Any]] = [
        {"from": "2026-05-04T13:00:00"}, {"before": "x"}, {"before": "~"}, {"limit": 0}, {"kind": "film"}
    ]  # fmt: skip
    for wanted in wishes:
        answer = await browser.get("/pictures", params=wanted)
        assert (answer.status_code, answer.json()["code"]) == (422, "invalid"), wanted


async def test_the_file_is_the_picture_byte_for_byte_and_ranges_work(rig: PictureRig) -> None:
    data = rig.show()
    browser = rig.browser(Role.OPERATOR)
    kept = (await browser.post(SNAPSHOT, json={})).json()
    whole = await browser.get(f"/pictures/{kept['id']}/file")
    assert (whole.content, whole.headers["content-type"]) == (data, "image/jpeg")
    assert whole.headers["content-disposition"].startswith("inline")
    part = await browser.get(f"/pictures/{kept['id']}/file", headers={"range": "bytes=10-19"})
    assert (part.status_code, part.content) == (206, data[10:20])
    saved = await browser.get(f"/pictures/{kept['id']}/file", params={"download": "true"})
    assert saved.headers["content-disposition"] == 'attachment; filename="weeder-01_front_2026-05-04_11-59-59.jpg"'


async def test_a_file_that_is_gone_is_said_to_be_gone(rig: PictureRig) -> None:
    rig.show()
    browser = rig.browser(Role.ADMIN)
    kept = (await browser.post(SNAPSHOT, json={})).json()["id"]
    rig.files()[0].unlink()
    gone = await browser.get(f"/pictures/{kept}/file")
    assert (gone.status_code, gone.json()["code"]) == (410, "file_gone")
    assert (await browser.delete(f"/pictures/{kept}")).status_code == 204


async def test_no_path_leads_elsewhere(rig: PictureRig) -> None:
    for path in (
        "/pictures/..%2f..%2fheadland.db/file",
        "/pictures/%2e%2e/file",
        f"/pictures/{'A' * 32}/file",
        "/pictures/1/file",
        f"/pictures/{'0' * 32}%0a/file",
        "/cameras/weeder-01/..%2f..%2fx/source",
        "/cameras/field/%2e%2e%2fx/source",
    ):
        answer = await rig.browser(Role.ADMIN).get(path)
        assert answer.status_code in (404, 422), path


async def test_a_snapshot_takes_nothing_but_a_short_note(rig: PictureRig) -> None:
    rig.show()
    bodies: list[Any] = [{"note": "x" * 201}, {"note": 5}, {"extra": 1}, []]
    for body in bodies:
        assert (await rig.browser(Role.OPERATOR).post(SNAPSHOT, json=body)).status_code == 422, body


async def test_deleting_is_written_down_with_the_hash_of_what_is_gone(rig: PictureRig) -> None:
    rig.show()
    browser = rig.browser(Role.ADMIN)
    kept = (await browser.post(SNAPSHOT, json={})).json()
    await browser.delete(f"/pictures/{kept['id']}")
    line = (await rig.audited("picture"))[-1]
    assert (line.outcome, line.ref, line.data["sha256"]) == ("deleted", kept["id"], kept["sha256"])
    assert rig.files() == []


async def test_a_changed_note_and_a_mark_are_written_down(rig: PictureRig) -> None:
    rig.show()
    browser = rig.browser(Role.OPERATOR)
    kept = (await browser.post(SNAPSHOT, json={"note": "stone"})).json()["id"]
    told = (await browser.patch(f"/pictures/{kept}", json={"note": "a fawn", "is_kept": True})).json()
    assert (told["note"], told["is_kept"]) == ("a fawn", True)
    lines = await rig.audited("picture")
    assert [line.outcome for line in lines] == ["kept", "marked", "noted"]
    assert lines[-1].text.endswith(": a fawn.")


async def test_a_watermark_is_on_what_is_sent_out_and_not_on_what_is_kept(make_rig: MakeRig) -> None:
    rig = await make_rig(picture_watermark=True)
    data = rig.show(data=picture(640, 480))
    browser = rig.browser(Role.OPERATOR)
    kept = (await browser.post(SNAPSHOT, json={})).json()
    sent = await browser.get(f"/pictures/{kept['id']}/file")
    assert rig.files()[0].read_bytes() == data
    assert sent.headers["cache-control"] == "no-store"
    before, after = Image.open(io.BytesIO(data)).convert("L"), Image.open(io.BytesIO(sent.content)).convert("L")
    assert after.size == (640, 480)
    changed = sum(abs(after.getpixel((x, 472)) - before.getpixel((x, 472))) > 60 for x in range(320))
    assert changed > 100
    assert abs(after.getpixel((320, 200)) - before.getpixel((320, 200))) < 6
