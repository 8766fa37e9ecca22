"""Writes kept pictures into an MP4 without encoding them again.

In a process of its own, for libav reads there what cameras sent.
"""

from __future__ import annotations

import asyncio
import errno
import itertools
import os
import socket
import struct
from fractions import Fraction
from pathlib import Path
from typing import Any, BinaryIO

import msgspec
from msgspec import Struct

from hmi.cameras.picture_wire import Piece
from hmi.cameras.ring import GAP_S, Span
from hmi.cameras.worker_process import context

WRITE_S = 20.0
CLOCK = Fraction(1, 90_000)
HEAD = struct.Struct("<IQHH?")


class Written(Struct, frozen=True):
    """What is in a clip; times on the machine's monotonic clock, ms. ``has_before``: see ``Span``."""

    path: str
    from_m: float = msgspec.field(name="from")
    to_m: float = msgspec.field(name="to")
    pictures: int
    bytes: int
    width_px: int
    height_px: int
    has_gap: bool
    is_dated: bool
    has_before: bool


class ClipFailed(Exception):
    """No clip was written; ``status``, ``code`` and a sentence."""

    def __init__(self, status: int, code: str, text: str) -> None:
        super().__init__(text)
        self.status, self.code, self.text = status, code, text


async def write_clip(span: Span, path: Path, data: Path) -> Written:
    """Write a span, its first a key picture, to a new file below ``data``; raises ``ClipFailed``."""
    pieces = span.pieces
    size = await asyncio.to_thread(_write, pieces, path, data)
    times = [one.captured_ms for one in pieces]
    return Written(
        path=str(path),
        from_m=round(times[0], 1),
        to_m=round(times[-1], 1),
        pictures=len(times),
        bytes=size,
        width_px=pieces[-1].width,
        height_px=pieces[-1].height,
        has_gap=any(after - before > GAP_S * 1000 for before, after in itertools.pairwise(times)),
        is_dated=all(one.is_dated for one in pieces),
        has_before=span.has_before,
    )


def _write(pieces: list[Piece], path: Path, data: Path) -> int:
    if not path.is_absolute() or not path.resolve().is_relative_to(data.resolve()) or path.suffix != ".mp4":
        raise ClipFailed(422, "bad_path", "Clips are .mp4 files in the data folder.")
    part = path.with_name(f".{path.name}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists():
            _in_a_process(pieces, part)
            os.link(part, path)  # unlike a rename it never replaces what came meanwhile
            return path.stat().st_size
    except FileExistsError:
        pass
    except OSError as error:
        is_full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        code, status = ("disk_full", 507) if is_full else ("not_written", 500)
        raise ClipFailed(status, code, f"The clip was not written: {error.strerror}.") from error
    finally:
        part.unlink(missing_ok=True)
    raise ClipFailed(409, "exists", "There is a file of this name already.")


def _in_a_process(pieces: list[Piece], part: Path) -> None:
    ours, theirs = socket.socketpair()
    ours.settimeout(WRITE_S)
    process = context.Process(target=_serve, args=(theirs, str(part), len(pieces)), name="clip", daemon=True)
    try:
        process.start()
        theirs.close()
        with ours, ours.makefile("rb") as answers:
            for piece in pieces:
                head = HEAD.pack(len(piece.data), piece.pts, piece.width, piece.height, piece.is_key)
                ours.sendall(head + piece.data)
            said = answers.readline()
    finally:
        process.join(1.0)
        if process.exitcode is None:
            process.kill()
            process.join(1.0)
        process.close()
    code = int(said or b"-1")
    if code:
        raise OSError(code, os.strerror(code)) if code > 0 else OSError(errno.EIO, "the pictures cannot be joined")


def _serve(link: socket.socket, part: str, count: int) -> None:
    """Runs in the process that writes."""
    import av

    code = 0
    with link, link.makefile("rb") as pieces:
        try:
            _mux(pieces, part, count)
        except OSError as error:
            code = error.errno or -1
        except (av.FFmpegError, ValueError):
            code = -1
        link.sendall(f"{code}\n".encode())


def _mux(pieces: BinaryIO, part: str, count: int) -> None:
    import av

    first: int | None = None
    with av.open(part, "w", format="mp4") as container:
        stream: Any = None
        for _ in range(count):
            head = pieces.read(HEAD.size)
            length, pts, width, height, is_key = HEAD.unpack(head)
            packet: av.Packet[Any] = av.Packet(pieces.read(length))
            if stream is None or first is None:
                stream = container.add_mux_stream("h264", width=width, height=height, time_base=CLOCK)
                first = pts
            packet.stream, packet.time_base = stream, CLOCK
            packet.pts = packet.dts = pts - first
            packet.is_keyframe = is_key
            container.mux(packet)
