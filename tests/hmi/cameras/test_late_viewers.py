"""Whoever comes long after the last key picture of a camera's own H.264 sees it all the same."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest
from aiortc.rtp import RtpPacket

from hmi.cameras import pull_whep
from hmi.cameras.camera import Camera
from hmi.cameras.group import MOST_BYTES, Group
from hmi.cameras.inbox import Inbox, Unit
from hmi.cameras.packet_track import MOST_WAITING, PacketTrack, packet_of
from hmi.cameras.picture_wire import HEAD, JpegWish, Kind, News, Piece, Plan, unpack_piece
from hmi.cameras.pull_whep import ASK_KEY_S, KEY_EVERY_S, WhepPull
from hmi.cameras.worker import MOST_BETWEEN_KEYS, Worker
from hmi.clock import FakeClock
from hmi.domain.camera import CameraInfo, Source, SourceKind
from tests.hmi.cameras.rtsp_server import encoded

SOURCE = Source("weeder-01", CameraInfo("front", "Front", 320, 240), SourceKind.WHEP, "http://192.0.2.1/whep")
KEY = b"\x00\x00\x00\x01\x67\x00\x00\x00\x00\x01\x65"


def piece(number: int) -> Piece:
    """Return a picture; number 0 can be decoded alone."""
    return Piece(Kind.H264, b"x", number * 33.0, number, 320, 240, is_key=number == 0, pts=number * 3000)


def pieces(link: socket.socket) -> Iterator[Piece]:
    """Return what a worker handed over, until it ended."""
    with link.makefile("rb") as read:
        while head := read.read(HEAD.size):
            yield unpack_piece(head, read.read(HEAD.unpack(head)[-1]))


async def test_a_long_group_is_sent_whole_and_what_comes_after_it_is_bounded_as_ever() -> None:
    group, asked = [piece(number) for number in range(3 * MOST_WAITING)], []
    track = PacketTrack(lambda: track.begin_with(group), lambda _piece: None, lambda: asked.append(1))
    first = await track.recv()
    assert first.pts == 0
    for number in range(len(group), len(group) + MOST_WAITING):
        track.put(piece(number), packet_of(piece(number)))
    got = [(await track.recv()).pts for _ in range(len(group) + MOST_WAITING - 1)]
    assert got == [number * 3000 for number in range(1, len(group) + MOST_WAITING)]
    for number in range(1, MOST_WAITING + 2):
        track.put(piece(number), packet_of(piece(number)))
    assert asked == [1], "who is behind begins again with a key picture"


async def test_without_a_group_a_viewer_begins_with_the_next_key_picture() -> None:
    track = PacketTrack(lambda: track.begin_with([]) or track.put(piece(1), packet_of(piece(1)))
                        or track.put(piece(0), packet_of(piece(0))), lambda _piece: None, lambda: None)  # fmt: skip
    assert (await track.recv()).pts == 0


def test_a_group_begins_with_a_key_picture_and_is_bounded_in_pictures_and_bytes() -> None:
    group: Group[Unit] = Group(3)
    for is_key in (False, True, False, False):
        group.add(Unit(b"x", 0.0, is_key))
    assert [one.is_key for one in group.row] == [True, False, False]
    group.add(Unit(b"x", 0.0, False))
    assert group.row == []
    group.add(Unit(b"x", 0.0, True))
    group.add(Unit(bytes(MOST_BYTES), 0.0, False))
    assert group.row == []


class Receiver:
    """Counts what a camera is asked."""

    asked = 0

    async def _send_rtcp_pli(self, _ssrc: int) -> None:
        self.asked += 1


async def test_a_whep_camera_is_asked_for_key_pictures_when_somebody_needs_one_and_now_and_then(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = SimpleNamespace(now=1000.0)
    monkeypatch.setattr(pull_whep, "mono_s", lambda: clock.now)
    pull, receiver = WhepPull(SOURCE, Inbox()), Receiver()
    pull._receiver = receiver  # type: ignore[assignment]
    units: list[Any] = [(KEY, True)]
    pull._units = SimpleNamespace(needs_key=False, add=lambda _packet: units.pop() if units else None)  # type: ignore[assignment]

    async def take(after_s: float) -> int:
        clock.now += after_s
        await pull._take(RtpPacket(), 0)
        return receiver.asked

    assert await take(0.0) == 0
    pull.ask_key()
    assert await take(0.1) == 1
    pull.ask_key()
    assert await take(ASK_KEY_S / 2) == 1, "not more often than that"
    assert await take(ASK_KEY_S) == 2
    assert await take(KEY_EVERY_S / 2) == 2
    assert await take(KEY_EVERY_S) == 3, "none came unasked"


def test_a_jpeg_is_made_at_once_of_a_stream_whose_key_picture_is_long_ago() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        worker = Worker(SOURCE, Plan(), theirs)
        units = [Unit(data, number * 33.0, number == 0) for number, data in enumerate(encoded(10))]
        for unit in units[:-1]:
            worker._handle_unit(unit, Plan())
        worker._handle_unit(units[-1], Plan(jpegs=(JpegWish(0, 15.0),)))
        ours.settimeout(5.0)
        head = ours.recv(HEAD.size, socket.MSG_WAITALL)
        assert Kind(head[0]) is Kind.JPEG


def test_a_viewer_of_vp8_puts_nothing_into_a_cameras_own_h264() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        plan = Plan(has_h264=True, has_vp8=True)
        worker = Worker(SOURCE, plan, theirs)
        now_ms, units = time.monotonic() * 1000, encoded(3)
        for number, data in enumerate(units):
            worker._handle(Unit(data, now_ms + number, number == 0))
        worker._wants_key = True
        worker._repeat()
        theirs.shutdown(socket.SHUT_WR)
        made = list(pieces(ours))
        assert [one.data for one in made if one.kind is Kind.H264] == units
        assert [one.is_key for one in made if one.kind is Kind.VP8] == [True, False, False, True]


def test_a_camera_whose_key_pictures_are_too_far_apart_gets_key_pictures_here() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 8 * 1024 * 1024)
        theirs.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 8 * 1024 * 1024)
        worker, units = Worker(SOURCE, Plan(), theirs), encoded(MOST_BETWEEN_KEYS + 40)
        now_ms = time.monotonic() * 1000
        sent = [Unit(data, now_ms + number * 33.0, number == 0) for number, data in enumerate(units)]
        for unit in sent[: MOST_BETWEEN_KEYS + 2]:
            worker._handle_unit(unit, Plan())
        for unit in sent[MOST_BETWEEN_KEYS + 2 :]:
            worker._last_item = unit
            worker._handle_unit(unit, Plan(has_h264=True))
        theirs.shutdown(socket.SHUT_WR)
        made = list(pieces(ours))
        assert len(made) == 38, "also when nobody looked while it was found out"
        assert made[0].is_key
        assert sum(one.is_key for one in made) >= 2, "every two seconds from then on"
        assert made[0].data not in units


def test_what_comes_before_the_first_key_picture_is_not_called_a_picture() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        worker, units = Worker(SOURCE, Plan(has_h264=True), theirs), encoded(3)
        worker._handle(Unit(units[1], 1.0, False))
        assert worker._news("").waits_key
        worker._handle(Unit(units[0], 2.0, True))
        assert not worker._news("").waits_key
        theirs.shutdown(socket.SHUT_WR)
        assert [one.data for one in pieces(ours)] == [units[0]]


async def test_a_camera_that_waits_for_a_key_picture_says_so_and_is_not_opened_anew_for_a_minute() -> None:
    clock = FakeClock()
    camera, worker = Camera(SOURCE, clock, 1280), SimpleNamespace(ends=0)
    worker.let_go = lambda: setattr(worker, "ends", worker.ends + 1)
    camera._count(News(pictures=40, size=1000, waits_key=True))
    camera._began_s = clock.mono_s()
    clock.advance(50.0)
    camera._end_silent(worker)  # type: ignore[arg-type]
    assert (worker.ends, camera.reason) == (0, "waiting for the camera's next key picture")
    clock.advance(20.0)
    camera._end_silent(worker)  # type: ignore[arg-type]
    assert worker.ends == 1
