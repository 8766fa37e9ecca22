"""RTSP and WHEP sources: H.264 is handed on as the camera sent it, and decoded only for who needs JPEG."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import httpx
import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from hmi.cameras import congestion
from hmi.cameras.depacketizer import is_key_unit
from hmi.cameras.inbox import Inbox
from hmi.cameras.picture_wire import Kind, Piece
from hmi.cameras.pull_http import PullFailed
from hmi.cameras.pull_rtsp import RtspPull
from hmi.domain.camera import CameraInfo, Source, SourceKind
from hmi.side_server import loopback_server
from tests.hmi.cameras.rig import CameraRig, camera_rig
from tests.hmi.cameras.rtsp_server import PASSWORD, USER, rtsp_server
from tests.hmi.cameras.waiting import until


@asynccontextmanager
async def whep_endpoint(origin: CameraRig, asks: str = "") -> AsyncIterator[str]:
    """Serve a camera by WHEP over HTTP, as another installation would, to who shows ``asks``."""

    async def whep(request: Request) -> Response:
        if asks and request.headers.get("authorization") != asks:
            return Response(status_code=401, headers={"WWW-Authenticate": 'Basic realm="camera"'})
        session_id, answer = await origin.whep.open(origin.page, origin.camera, (await request.body()).decode())
        return Response(answer, 201, {"Location": f"/sessions/{session_id}"}, "application/sdp")

    async def end(request: Request) -> Response:
        await origin.whep.sessions[request.path_params["id"]].end()
        return Response(status_code=204)

    routes = [Route("/whep", whep, methods=["POST"]), Route("/sessions/{id}", end, methods=["DELETE"])]
    listener, server = loopback_server(Starlette(routes=routes))
    serving = asyncio.create_task(server.serve(sockets=[listener]))
    try:
        yield f"http://127.0.0.1:{listener.getsockname()[1]}/whep"
    finally:
        server.should_exit = True
        await serving


INFO = CameraInfo("front", "Front", 320, 240)


@pytest.mark.slow
async def test_h264_of_an_rtsp_camera_is_passed_on_bit_for_bit_and_a_viewer_sees_it() -> None:
    async with rtsp_server() as server, camera_rig() as rig:
        await rig.tell(kind=SourceKind.RTSP, url=server.url, camera=INFO)
        viewer = await rig.view("H264")
        frame = await viewer.frame()
        assert (frame.width, frame.height) == (320, 240)
        sent = {unit.split(b"\x00\x00\x00\x01")[-1] for unit in server.units}
        came = [piece for piece in rig.camera.group if piece.kind is Kind.H264]
        assert came[0].is_key
        assert is_key_unit(came[0].data)
        assert all(piece.data.split(b"\x00\x00\x00\x01")[-1] in sent for piece in came[1:])
        assert rig.camera.describe()["is_dated"] is False
        late = await rig.view("H264")
        async with asyncio.timeout(3):
            assert (await late.frame()).width == 320
        await viewer.close()
        await late.close()


@pytest.mark.slow
async def test_pictures_that_wait_in_an_rtsp_camera_are_as_old_as_its_reports_tell() -> None:
    async with rtsp_server() as server, camera_rig() as rig:
        server.has_reports = True
        await rig.tell(kind=SourceKind.RTSP, url=server.url, camera=INFO)
        rig.watch()
        await rig.until_pictures(3)
        server.waits_longer = 0.8

        def age_ms() -> float:
            rig.read()
            newest = rig.camera.newest
            return 0.0 if newest is None else rig.clock.mono_s() * 1000 - newest.captured_ms

        await until(lambda: age_ms() >= 1500.0)
        assert rig.camera.state == "live", "it is the screen that calls it late"
        assert rig.camera.describe()["is_dated"] is False, "how old the quickest was nobody knows"


@pytest.mark.slow
async def test_an_rtsp_camera_whose_pictures_go_on_waiting_is_opened_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(congestion, "AT_LEAST_MS", 300.0)
    async with rtsp_server() as server:
        server.has_reports, server.waits_longer = True, 0.9
        pull = RtspPull(Source("weeder-01", INFO, SourceKind.RTSP, server.url), Inbox())
        with pytest.raises(PullFailed, match="waited too long on their way"):
            await asyncio.wait_for(asyncio.to_thread(pull.run), 20)


@pytest.mark.slow
async def test_jpeg_of_an_rtsp_camera_is_made_for_who_wants_it() -> None:
    async with rtsp_server() as server, camera_rig() as rig:
        await rig.tell(kind=SourceKind.RTSP, url=server.url, camera=INFO)
        rig.watch(width=160)
        await rig.until_pictures(3)
        assert rig.pictures[0][24:26] == b"\xff\xd8"
        assert rig.camera.state == "live"
        assert server.viewers == 1


@pytest.mark.long
async def test_a_password_with_odd_letters_opens_an_rtsp_camera_and_a_wrong_one_is_said_so() -> None:
    async with rtsp_server(asks_password=True) as server, camera_rig() as rig:
        await rig.tell(kind=SourceKind.RTSP, url=server.url, camera=INFO, user=USER, password="wrong")
        rig.watch()
        await until(lambda: rig.camera.state == "failed")
        assert rig.camera.reason == "the camera does not accept the password it was given"
        await rig.tell(password=PASSWORD)
        await rig.until_pictures(1)


@pytest.mark.long
async def test_an_rtsp_camera_that_falls_silent_is_frozen_and_then_opened_anew() -> None:
    async with rtsp_server() as server, camera_rig() as rig:
        await rig.tell(kind=SourceKind.RTSP, url=server.url, camera=INFO)
        rig.watch()
        await rig.until_pictures(1)
        server.is_silent = True
        await until(lambda: rig.camera.state == "frozen")
        await until(lambda: rig.camera.restarts >= 1)
        server.is_silent = False
        await until(lambda: rig.camera.state == "live")


@pytest.mark.slow
async def test_a_stream_of_one_headland_is_a_whep_source_of_another() -> None:
    async with camera_rig() as origin, camera_rig() as rig, whep_endpoint(origin) as url:
        await rig.tell(kind=SourceKind.WHEP, url=url)
        viewer = await rig.view("H264")
        assert (await viewer.frame()).width == 640
        pieces: list[Piece] = rig.camera.group
        assert pieces[0].is_key
        await viewer.close()


@pytest.mark.slow
async def test_user_and_password_open_a_whep_source_and_wrong_ones_are_said_so() -> None:
    asks = httpx.BasicAuth(USER, PASSWORD)._auth_header
    async with camera_rig() as origin, camera_rig() as rig, whep_endpoint(origin, asks) as url:
        await rig.tell(kind=SourceKind.WHEP, url=url, token="", user=USER, password="wrong")
        rig.watch(width=160)
        await until(lambda: rig.camera.state == "failed")
        assert rig.camera.reason == "the camera does not accept the password or token it was given"
        await rig.tell(password=PASSWORD)
        await rig.until_pictures(1)
