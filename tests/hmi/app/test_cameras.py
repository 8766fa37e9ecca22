"""Cameras behind the console: from a real camera process to a page, with session, Origin, rights and secret."""

from __future__ import annotations

import asyncio
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import httpx
import psutil
import pytest
from aiortc import RTCConfiguration, RTCPeerConnection, RTCSessionDescription

from hmi.app.camera_socket import AWAY, REFUSED, SIGNED_OUT
from hmi.cameras.door import read_note
from hmi.domain.role import Role
from tests.hmi.app.camera_console import CameraConsole, camera_console, camera_process, live_page
from tests.hmi.cameras.fake_camera import FakeCamera, fake_camera, jpeg
from tests.hmi.cameras.waiting import until

SDP = {"content-type": "application/sdp"}
FRONT = "/cameras/weeder-01/front"


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A data folder with a camera process."""
    folder = tmp_path_factory.mktemp("cameras")
    with camera_process(folder):
        yield folder


@pytest.fixture
def robot() -> Iterator[FakeCamera]:
    """A robot with a camera."""
    with fake_camera(FakeCamera()) as served:
        yield served


async def offer() -> tuple[RTCPeerConnection, str]:
    """Return a viewer and what it offers."""
    peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
    peer.addTransceiver("video", direction="recvonly")
    await peer.setLocalDescription(await peer.createOffer())
    return peer, peer.localDescription.sdp


async def settled(console: CameraConsole, key: str, wanted: object) -> None:
    """Wait until the camera process says so."""
    async with asyncio.timeout(15):
        while (await console.status())[key] != wanted:  # noqa: ASYNC110 - another process
            await asyncio.sleep(0.05)


@pytest.mark.slow
async def test_pictures_reach_a_page_by_jpeg_and_by_webrtc_and_nothing_runs_before_or_after(
    data: Path, robot: FakeCamera
) -> None:
    async with camera_console(data, robot) as console:
        listed = (await console.client.get("/cameras?robot=weeder-01")).json()["cameras"]
        assert [(one["camera"], one["state"], one["source"]) for one in listed] == [("front", "idle", "robot")]
        assert robot.asked == []
        async with live_page(console) as page:
            page.say(k="watch", n=1, robot="weeder-01", camera="front", way="jpeg")
            await page.until_pictures(2)
            peer, sdp = await offer()
            headers = SDP | {"x-headland-watcher": page.watcher}
            answer = await console.client.post(f"{FRONT}/whep", content=sdp, headers=headers)
            assert answer.status_code == 201
            assert answer.headers["location"].startswith("/api/v1/cameras/sessions/")
            await peer.setRemoteDescription(RTCSessionDescription(answer.text, "answer"))
            reading = asyncio.create_task(page.until("never"))
            assert (await peer.getReceivers()[0].track.recv()).width == 640
            reading.cancel()
            place = answer.headers["location"].removeprefix("/api/v1")
            assert (await console.client.delete(place)).status_code == 404, "only with the page's own token"
            for _ in range(2):  # the second finds nothing left, which is what it asks for
                assert (await console.client.delete(place, headers=headers)).status_code == 204
            await peer.close()
        await settled(console, "watchers", 0)
        await settled(console, "workers", {})
        await until(lambda: robot.open == 0)


@pytest.mark.slow
async def test_a_page_that_falls_silent_is_let_go_with_everything_it_watched(data: Path, robot: FakeCamera) -> None:
    async with camera_console(data, robot) as console:
        async with console.socket() as socket:
            await socket.next()
            socket.say('{"k":"watch","n":1,"robot":"weeder-01","camera":"front","way":"jpeg"}')
            await settled(console, "watchers", 1)
            began_s = asyncio.get_running_loop().time()
            while socket.code is None:
                await socket.next()
            assert socket.code == 4408
            assert asyncio.get_running_loop().time() - began_s < 2.5
        assert (await console.status())["watchers"] == 0
        (camera, *_) = (await console.client.get("/cameras?robot=weeder-01")).json()["cameras"]
        assert camera["viewers"] == 0


async def test_without_a_session_or_from_another_page_nothing_opens(data: Path, robot: FakeCamera) -> None:
    async with camera_console(data, robot, None) as console, console.socket() as socket:
        assert (await socket.next())["text"].startswith('{"k":"bye","code":"signed_out"')
        await socket.next()
        assert socket.code == SIGNED_OUT
    async with camera_console(data, robot) as console:
        for headers in ({}, {"origin": "http://evil.example"}):
            async with console.socket(headers) as socket:
                assert socket.code == REFUSED
        assert (await console.status())["watchers"] == 0


async def test_a_robot_of_another_farm_is_neither_listed_nor_shown(data: Path, robot: FakeCamera) -> None:
    async with camera_console(data, robot) as console:
        listed = (await console.client.get("/cameras")).json()["cameras"]
        assert {one["robot"] for one in listed} == {"weeder-01", "field"}
        for path in ("whep", "still"):
            request = console.client.post if path == "whep" else console.client.get
            assert (await request(f"/cameras/weeder-99/front/{path}")).status_code == 403
        async with live_page(console) as page:
            page.say(k="watch", n=7, robot="weeder-99", camera="front", way="jpeg")
            refused = await page.until("refused")
            assert (refused["n"], refused["code"]) == (7, "not_allowed")
        assert robot.asked == []


@pytest.mark.slow
async def test_a_session_that_ends_ends_its_pictures(data: Path, robot: FakeCamera) -> None:
    async with camera_console(data, robot) as console, live_page(console) as page:
        page.say(k="watch", n=1, robot="weeder-01", camera="front", way="jpeg")
        await page.until_pictures(1)
        console.gate.session = None
        assert (await page.until("bye"))["code"] == "signed_out"


async def test_rest_says_who_may_what(data: Path, robot: FakeCamera) -> None:
    async with camera_console(data, robot, None) as console:
        for method, path in (("GET", "/cameras"), ("POST", f"{FRONT}/whep"), ("POST", f"{FRONT}/restart")):
            assert (await console.client.request(method, path)).status_code == 401
    async with camera_console(data, robot, Role.VIEWER) as console:
        assert (await console.client.post(f"{FRONT}/restart")).status_code == 403
        assert (await console.client.post(f"{FRONT}/control", json={"lamp": True})).status_code == 403
        assert (await console.client.post(f"{FRONT}/whep", content="v=0", headers=SDP)).json()["code"] == "not_allowed"
    async with camera_console(data, robot, Role.OPERATOR) as console:
        begun = await console.client.post(f"{FRONT}/restart")
        assert (begun.status_code, begun.json()) == (202, {}), "a screen takes an empty answer for a cut line"
        assert [line.kind for line in console.lines] == ["camera"]
        assert (await console.client.post("/cameras/weeder-01/none/restart")).json()["code"] == "unknown_camera"
        assert (await console.client.post("/cameras/field/pole/restart")).status_code == 202
        assert console.lines[-1].robot_id is None, "the field is no robot"


async def test_lamp_and_zoom_need_control_of_the_robot_and_one_order_at_a_time(data: Path, robot: FakeCamera) -> None:
    async with camera_console(data, robot, Role.OPERATOR) as console:
        answer = await console.client.post(f"{FRONT}/control", json={"lamp": True})
        assert (answer.status_code, answer.json()["code"]) == (409, "no_lease")
        console.holds = True
        for body in ({}, {"lamp": True, "zoom": 2.0}, {"zoom": 0.1}, {"trigger": False}, {"move": 1}):
            assert (await console.client.post(f"{FRONT}/control", json=body)).status_code == 422
        assert (await console.client.post(f"{FRONT}/control", json={"zoom": 2.0})).status_code == 204
        assert robot.orders == [{"zoom": 2.0}]
        console.off = "Take pictures is off: its node Camera is stopped."
        answer = await console.client.post(f"{FRONT}/control", json={"trigger": True})
        assert (answer.status_code, answer.json()["code"], answer.json()["text"]) == (409, "function_off", console.off)
        assert robot.orders == [{"zoom": 2.0}]


async def test_how_a_camera_is_set_is_what_its_robot_says_and_nothing_is_made_up(data: Path, robot: FakeCamera) -> None:
    async with camera_console(data, robot) as console:
        assert (await console.client.get(f"{FRONT}/control")).json() == {"lamp": True, "zoom": 3.0}
        robot.setting = {"lamp": None}
        assert (await console.client.get(f"{FRONT}/control")).json() == {"lamp": None, "zoom": None}
        for said, status in ((None, 409), ({"zoom": "near"}, 504), ({"zoom": -1}, 504)):
            robot.setting = said
            assert (await console.client.get(f"{FRONT}/control")).status_code == status
        assert (await console.client.get("/cameras/weeder-99/front/control")).status_code == 403


async def test_a_still_is_fetched_for_who_asks_and_carries_when_it_was_taken(data: Path, robot: FakeCamera) -> None:
    async with camera_console(data, robot) as console:
        answer = await console.client.get(f"{FRONT}/still?fresh_s=1")
        assert (answer.status_code, answer.headers["content-type"]) == (200, "image/jpeg")
        assert answer.content in robot.pictures
        assert float(answer.headers["x-headland-captured"]) > 0


async def test_a_camera_that_gives_no_picture_says_at_once_what_is_in_the_way(data: Path, robot: FakeCamera) -> None:
    robot.refusal = (401, b"")
    async with camera_console(data, robot) as console:
        answer = await console.client.get(f"{FRONT}/still?fresh_s=1")
        assert (answer.status_code, answer.json()["code"]) == (404, "no_picture")
        words = "No picture came: the camera does not accept the password or token it was given."
        assert answer.json()["text"] == words


async def test_what_a_field_camera_sent_is_judged_and_shown(data: Path, robot: FakeCamera) -> None:
    async with camera_console(data, robot) as console:
        path = "/cameras/field/pole/frame"
        assert (await console.desk.call("POST", path, b"junk", 3.0)).json()["code"] == "bad_picture"
        assert (await console.desk.call("POST", path, jpeg(), 3.0)).status_code == 204
        assert (await console.client.get("/cameras/field/pole/still")).content == jpeg()


async def test_other_programs_of_the_machine_read_nothing(data: Path) -> None:
    note = read_note(data)
    assert note is not None
    async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{note.control_port}", trust_env=False) as client:
        for headers in ({}, {"x-headland-cameras": "guess"}):
            for method, path in (("GET", "/cameras"), ("GET", "/status"), ("PUT", "/sources"), ("POST", "/clips")):
                assert (await client.request(method, path, headers=headers)).status_code == 403


@pytest.mark.long
async def test_a_camera_process_that_dies_is_said_so_and_a_new_one_knows_everything(
    tmp_path: Path, robot: FakeCamera
) -> None:
    async with camera_console(tmp_path, robot) as console:
        answer = await console.client.get("/cameras")
        assert (answer.status_code, answer.json()["code"]) == (503, "cameras_down")
        with camera_process(tmp_path) as process:
            async with live_page(console) as page:
                page.say(k="watch", n=1, robot="weeder-01", camera="front", way="jpeg")
                await page.until_pictures(1)
                children = psutil.Process(process.pid).children(recursive=True)
                os.kill(process.pid, signal.SIGKILL)
                assert (await page.until("bye"))["code"] == "cameras_down"
                while page.socket.code is None:
                    await page.read()
                assert page.socket.code == AWAY
            await until(lambda: not any(child.is_running() for child in children))
        with camera_process(tmp_path):
            assert (await console.client.get(f"{FRONT}/still?fresh_s=1")).status_code == 200
