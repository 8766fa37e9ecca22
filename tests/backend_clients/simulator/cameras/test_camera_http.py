"""Cameras over the robot's HTTP: stream, still, control, and what faults do to them."""

from __future__ import annotations

import io
import json

import pytest
from PIL import Image, UnidentifiedImageError

from backend_clients.simulator import faults
from backend_clients.simulator.cameras import time_code, web
from backend_clients.simulator.cameras.map_feature import MapFeature
from tests.backend_clients.simulator.cameras.field import Pull, Site, opened


async def test_a_stream_is_jpeg_parts_with_the_time_they_were_taken() -> None:
    site = Site()
    first, second = await site.pull("cameras/front/stream?fps=30&width=320", 2)
    for part in (first, second):
        assert part.head["Content-Type"] == "image/jpeg"
        assert int(part.head["X-Age-Ms"]) >= 0
        pixels = opened(part.jpeg)
        assert pixels.shape == (240, 320, 3)
        captured_ms = int(part.head["X-Captured-Ms"])
        assert captured_ms == int(site.rig.clock.utc().timestamp() * 1000)
        assert time_code.read(pixels) == captured_ms & 0xFFFFFF


async def test_width_is_an_upper_limit_and_the_camera_gives_no_more_than_it_has() -> None:
    site = Site()
    still = await site.ask("cameras/tof/still?width=4000")
    assert still.status == 200
    assert opened(still.body).shape == (264, 352, 3)
    assert {"x-captured-ms", "x-age-ms"} <= set(still.headers)


async def test_nothing_is_drawn_that_nobody_pulls() -> None:
    site = Site()
    site.rig.run(5.0)
    await site.ask("cameras")
    await site.ask("cameras/front/detections")
    assert site.desk.many == 0
    await site.pull("cameras/front/stream?width=160", 1)
    drawn = site.desk.many
    site.rig.run(5.0)
    assert site.desk.many == drawn
    assert site.web.pulled == 0


async def test_an_unknown_camera_and_a_wrong_token_are_refused() -> None:
    site = Site()
    for path in ("cameras/roof/stream", "cameras/roof/still", "cameras/roof/detections"):
        answer = await site.ask(path)
        assert (answer.status, json.loads(answer.body)["code"]) == (404, "unknown_camera")
    assert (await site.ask("cameras/front/still", token="guess")).status == 401
    assert site.desk.many == 0


async def test_a_failed_node_takes_its_cameras_down_with_a_reason_and_a_restart_brings_them_back() -> None:
    site = Site()
    pull = Pull(site, "cameras/front/stream?width=160")
    await pull.next()
    site.rig.robot.set_fault(faults.NodeFailure(node="perception"))
    site.rig.run(0.2)
    for path in ("cameras/front/stream", "cameras/tof/still"):
        answer = await site.ask(path)
        assert (answer.status, json.loads(answer.body)["code"]) == (503, "camera_down")
        assert json.loads(answer.body)["text"] == "Cameras and crop is in error."
    with pytest.raises(TimeoutError):
        await pull.next(patience=40)
    assert pull.is_over
    site.rig.robot.clear_fault("node-failure")
    site.rig.run(4.0)
    assert (await site.ask("cameras/front/still?width=160")).status == 200


@pytest.mark.slow
@pytest.mark.parametrize("fault", [faults.CameraFreeze(), faults.NodeSilent(node="perception")])
async def test_a_frozen_camera_keeps_the_connection_and_sends_nothing(fault: faults.Fault) -> None:
    site = Site()
    pull = Pull(site, "cameras/front/stream?fps=30&width=160")
    await pull.next()
    site.rig.robot.set_fault(fault)
    await pull.is_silent()
    assert await pull.is_silent()
    assert (await site.ask("cameras/front/still")).status == 503
    site.rig.robot.clear_fault()
    assert opened((await pull.next()).jpeg).any()
    await pull.hang_up()


async def test_a_freeze_may_hit_one_camera_only() -> None:
    site = Site()
    site.rig.robot.set_fault(faults.CameraFreeze(camera="front"))
    assert (await site.ask("cameras/front/still")).status == 503
    assert (await site.ask("cameras/rear/still?width=160")).status == 200


async def test_the_drawing_can_be_made_ready_before_anybody_looks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(web, "READY_AFTER_S", 0.0)
    site = Site()
    await site.web.prepare([site.rig.robot])
    (drawn,) = site.desk.looks
    assert (drawn.width_px, drawn.is_hasty) == (64, True)


async def test_a_scene_that_cannot_be_made_is_no_picture_and_is_in_the_log(caplog: pytest.LogCaptureFixture) -> None:
    site = Site()
    nowhere = MapFeature("parcel", "Nowhere", {}, {"type": "Polygon", "coordinates": [[["a", "b"]]]})
    site.web._observer.scenery.features = [nowhere]
    answer = await site.ask("cameras/front/still?width=160")
    assert answer.status == 503
    assert b"its log says why" in answer.body
    assert "the scene cannot be made" in caplog.text


async def test_garbage_is_not_a_picture() -> None:
    site = Site()
    site.rig.robot.set_fault(faults.CameraGarbage())
    for _ in range(3):
        site.rig.clock.advance(0.001)
        [part] = await site.pull("cameras/front/stream?width=160", 1)
        if int(part.head["X-Captured-Ms"]) % 3 == 2:
            continue  # its bytes differ in the middle; a decoder may show something
        with pytest.raises((OSError, UnidentifiedImageError, SyntaxError)):
            Image.open(io.BytesIO(part.jpeg)).load()


async def test_lamp_zoom_and_trigger_are_set_and_what_a_camera_has_not_is_refused() -> None:
    site = Site()
    for body in (b'{"lamp":true}', b'{"zoom":2.0}', b'{"trigger":true}'):
        assert (await site.ask("cameras/front/control", method="POST", body=body)).status == 204
    await site.ask("cameras/front/still?width=160")
    taken = site.desk.looks[-1]
    assert (taken.lamp, taken.zoom) == (True, 2.0)
    assert taken.age_of_shot_s == 0.0
    assert json.loads((await site.ask("cameras/front/control")).body) == {"lamp": True, "zoom": 2.0}
    assert json.loads((await site.ask("cameras/rear/control")).body) == {"lamp": None, "zoom": 1.0}
    assert (await site.ask("cameras/none/control")).status == 404
    for camera, body, text in (
        ("tof", b'{"lamp":true}', "This camera has no lamp."),
        ("rear", b'{"zoom":2.0}', "This camera cannot zoom."),
        ("front", b'{"zoom":9.0}', "It zooms from 1 to 4."),
        ("side", b'{"trigger":true}', "This camera takes no single pictures."),
    ):
        answer = await site.ask(f"cameras/{camera}/control", method="POST", body=body)
        assert (answer.status, json.loads(answer.body)["text"]) == (409, text)
    assert (await site.ask("cameras/front/control", method="POST", body=b'{"laser":true}')).status == 400


async def test_a_camera_takes_one_picture_in_five_seconds_however_often_it_is_triggered() -> None:
    site, asked = Site(), b'{"trigger":true}'
    answers = []
    for after_s in (0.0, 1.0, 3.9, 0.2):
        site.rig.clock.advance(after_s)
        answers.append(await site.ask("cameras/rear/control", method="POST", body=asked))
    assert [one.status for one in answers] == [204, 409, 409, 204]
    assert json.loads(answers[2].body)["text"] == "It takes a picture each 5 s. The last one is 4.9 s old."
    other = await site.ask("cameras/front/control", method="POST", body=asked)
    assert other.status == 204, "each camera for itself"


async def test_what_was_found_is_told_while_somebody_pulls() -> None:
    site = Site()
    site.rig.robot.set_fault(faults.PersonAhead(distance_m=3.0))
    site.rig.clock.advance(10.0)
    before = json.loads((await site.ask("cameras/front/detections")).body)
    assert before == {"camera": "front", "captured_ms": None, "boxes": []}
    [part] = await site.pull("cameras/front/stream?width=320", 1)
    found = json.loads((await site.ask("cameras/front/detections")).body)
    assert found["captured_ms"] == int(part.head["X-Captured-Ms"])
    [person] = [box for box in found["boxes"] if box["kind"] == "person"]
    assert person["x"] + person["w"] / 2 == pytest.approx(0.5, abs=0.05)
    site.rig.clock.advance(2.0)
    assert json.loads((await site.ask("cameras/front/detections")).body)["boxes"] == []


@pytest.mark.slow
async def test_a_dead_computer_sends_nothing_and_does_not_hang_up() -> None:
    site = Site()
    pull = Pull(site, "cameras/front/stream?fps=30&width=160")
    await pull.next()
    site.rig.robot.set_fault(faults.Crash())
    await pull.is_silent()
    assert await pull.is_silent()
    await pull.hang_up()
