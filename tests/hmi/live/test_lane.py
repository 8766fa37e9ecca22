"""The lane over a real websocket: who may open it, what it carries, how it ends."""

from __future__ import annotations

import asyncio
import json

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from hmi.clock import SystemClock
from hmi.live.frames import BadFrame, Drive, Here, decode_client
from tests.hmi.live.site import ID, frame, running


async def test_hello_comes_first_then_ticks_that_the_console_accepts() -> None:
    async with running() as site, site.open() as ws:
        hello = json.loads(await ws.recv())
        assert abs(hello.pop("m") / 1000 - SystemClock().mono_s()) < 5
        assert hello == {
            "k": "hello",
            "boot": "boot1",
            "user": {"id": "martha", "name": "Martha", "role": "operator"},
            "device": {"id": "tablet-3", "name": "Tablet 3"},
        }
        tick = await frame(ws, "tick")
        assert site.ticks.is_fresh(tick["id"])


async def test_a_subscription_brings_a_snapshot_and_changes_bring_deltas() -> None:
    async with running() as site, site.open() as ws:
        await ws.send('{"k":"sub","topics":["robot/weeder-01"]}')
        snap = await frame(ws, "snap")
        assert snap["d"]["robot/weeder-01"]["id"]["name"] == "Weeder 01"
        site.store.put_heartbeat(ID, boot="boot-aaaa", challenge="challenge", heard_s=SystemClock().mono_s())
        site.store.announce()
        delta = await frame(ws, "delta")
        assert delta["d"]["robot/weeder-01"]["link"]["is_online"] is True


async def test_here_and_drive_reach_the_handler_with_their_session() -> None:
    async with running() as site, site.open() as ws:
        await ws.send('{"k":"here","robot":"weeder-01","tick":"boot1-1"}')
        await ws.send('{"k":"drive","robot":"weeder-01","v":0.2,"w":-0.1,"tick":"boot1-2"}')
        await ws.send('{"k":"ping","n":1}')
        await frame(ws, "pong")
        assert site.heard == [
            ("martha", Here("boot1-1", ID)),
            ("martha", Drive(ID, 0.2, -0.1, "boot1-2")),
        ]


async def test_a_handler_that_fails_does_not_end_the_lane() -> None:
    async with running() as site, site.open() as ws:
        site.fails = True
        await ws.send('{"k":"here","robot":"weeder-01","tick":"boot1-1"}')
        await ws.send('{"k":"ping","n":7}')
        assert (await frame(ws, "pong"))["n"] == 7


@pytest.mark.parametrize("origin", [None, "null", "http://evil.example", "http://127.0.0.1:1"])
async def test_a_foreign_or_missing_origin_is_refused(origin: str | None) -> None:
    async with running() as site:
        with pytest.raises(InvalidStatus):
            async with site.open(origin=origin):
                pass
        assert site.hub.lanes == 0


async def test_an_origin_from_the_settings_is_allowed() -> None:
    async with running() as site, site.open(origin="https://farm.example") as ws:
        assert json.loads(await ws.recv())["k"] == "hello"


@pytest.mark.parametrize("cookie", [None, "wrong"])
async def test_without_a_session_the_lane_says_bye(cookie: str | None) -> None:
    async with running() as site, site.open(cookie=cookie) as ws:
        assert (await frame(ws, "bye"))["code"] == "signed_out"
        with pytest.raises(ConnectionClosed):
            await ws.recv()
        assert ws.close_code == 4401


async def test_signing_out_closes_every_page_of_the_session() -> None:
    async with running() as site, site.open() as one, site.open() as two:
        await frame(one, "tick")
        await frame(two, "tick")
        site.hub.end_session("session-martha", "signed_out", "You signed out.")
        for ws in (one, two):
            assert (await frame(ws, "bye"))["text"] == "You signed out."
            await ws.wait_closed()
            assert ws.close_code == 4401


async def test_a_frame_after_the_session_ended_moves_nothing() -> None:
    async with running() as site, site.open() as ws:
        await frame(ws, "tick")
        site.gate.open.clear()
        await ws.send('{"k":"drive","robot":"weeder-01","v":0.2,"w":0,"tick":"boot1-2"}')
        assert (await frame(ws, "bye"))["code"] == "signed_out"
        assert site.heard == []


@pytest.mark.parametrize(
    "text",
    [
        "{",
        "[]",
        '{"k":"move"}',
        '{"k":"drive","robot":"weeder-01","v":99,"w":0,"tick":"t"}',
        '{"k":"drive","robot":"weeder-01","v":NaN,"w":0,"tick":"t"}',
        '{"k":"drive","robot":"../x","v":0,"w":0,"tick":"t"}',
        '{"k":"drive","robot":"weeder-01","v":0.2,"w":0,"tick":"t","picture":-1}',
        '{"k":"here","robot":"weeder-01"}',
        '{"k":"ping","n":1,"x":2}',
        '{"k":"sub","topics":"fleet"}',
        "x" * 9000,
    ],
)
async def test_what_is_no_frame_closes_the_lane(text: str) -> None:
    async with running() as site, site.open() as ws:
        await ws.send(text)
        await ws.wait_closed()
        assert ws.close_code == 4400
        assert site.heard == []


async def test_a_flood_of_frames_is_cut_down_and_the_lane_lives_on() -> None:
    async with running() as site, site.open() as ws:
        for _ in range(1000):
            await ws.send('{"k":"drive","robot":"weeder-01","v":0.2,"w":0,"tick":"boot1-2"}')
        await frame(ws, "tick")
        await frame(ws, "tick")
        assert len(site.heard) < 400


async def test_a_browser_that_left_is_forgotten() -> None:
    async with running() as site, site.open() as stays:
        async with site.open() as leaves:
            await frame(leaves, "tick")
            assert site.hub.lanes == 2
        async with asyncio.timeout(5):
            while site.hub.lanes > 1:
                await frame(stays, "tick")


async def test_a_browser_that_reads_nothing_gets_a_snapshot_not_a_backlog() -> None:
    async with running() as site, site.open() as ws:
        await ws.send('{"k":"sub","topics":["robot/weeder-01"]}')
        await frame(ws, "snap")
        # It tells that what it shows is old: everything since lies in buffers between us.
        await ws.send(json.dumps({"k": "ping", "n": 1, "m": SystemClock().mono_s() * 1000 - 9000}))
        await frame(ws, "pong")
        for number in range(20):
            site.hub.set_group(ID, "lease", {"since_s": number})
        await ws.send(json.dumps({"k": "ping", "n": 2, "m": SystemClock().mono_s() * 1000}))
        kinds = []
        async with asyncio.timeout(5):
            while "snap" not in kinds:
                kinds.append((found := json.loads(await ws.recv()))["k"])
        assert "delta" not in kinds
        assert found["d"]["robot/weeder-01"]["lease"] == {"since_s": 19}


def test_one_frame_of_a_page_keeps_control_of_several_robots() -> None:
    frame = decode_client('{"k":"here","robots":["weeder-01","weeder-02"],"tick":"boot1-1"}')
    assert isinstance(frame, Here)
    assert frame.each() == ["weeder-01", "weeder-02"]
    for bad in ('{"k":"here","robots":["../x"],"tick":"t"}', '{"k":"here","robot":"weeder-01"}'):
        with pytest.raises(BadFrame):
            decode_client(bad)
    many = json.dumps({"k": "here", "tick": "t", "robots": [f"w{i}" for i in range(101)]})
    with pytest.raises(BadFrame):
        decode_client(many)


def test_a_setpoint_may_say_how_old_the_picture_is_that_somebody_steers_by() -> None:
    frame = decode_client('{"k":"drive","robot":"weeder-01","v":0.2,"w":0,"tick":"t","picture":180.5}')
    assert isinstance(frame, Drive)
    assert frame.picture == 180.5
