"""Cameras: what viewers cost, how late pictures are, and how soon the first comes.

Ours is the real camera process with its worker (``python -m hmi.cameras``) in front of a robot's picture stream that
another process serves; viewers are WebRTC clients in this one. The naive way is aiortc's own: a ``MediaRelay`` and one
encoder a viewer, in a process of its own, fed with decoded pictures and measured with fewer viewers.

- ``video_32_viewers_cpu_pct``: CPU of camera process and worker, 32 viewers of one 640x480@15 camera.
- ``video_viewer_naive_ratio``: CPU that one more viewer costs, the naive way by ours.
- ``video_delay_p50_ms``: from capture to the decoded picture in the viewer, 640x480@15, one viewer.
- ``video_first_frame_ms``: from the wish to the first decoded picture of a camera that nobody watched.
- ``video_large_cpu_pct``: CPU of a 2048x1536@4 camera, one WebRTC viewer (1280 wide), one of full-size JPEG.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import av
import psutil
from aiortc import RTCConfiguration, RTCPeerConnection, RTCSessionDescription
from aiortc.rtp import RtpPacket

from hmi.app.camera_link import CameraLink
from hmi.cameras.depacketizer import Depacketizer
from hmi.cameras.door import VIEWER_HEADER, WATCHER_HEADER
from hmi.cameras.encoders import Decoder
from hmi.cameras.pull_whep import take_packets
from hmi.domain.camera import CameraInfo, Source
from tests.hmi.app.camera_console import camera_process
from tests.hmi.cameras.fake_camera import TOKEN, FakeCamera, fake_camera

VIEWERS, NAIVE_VIEWERS = 32, 4
SECONDS, SETTLE_S = 6.0, 2.0
SMALL, LARGE = (640, 480, 15.0), (2048, 1536, 4.0)
HEADERS = {VIEWER_HEADER: "bench"}
MAX_FRAME_BYTES = 64 * 1024 * 1024


def run() -> Iterator[dict[str, Any]]:
    """Yield the figures."""
    naive_one, naive_many = _naive(1), _naive(NAIVE_VIEWERS)
    naive_viewer = (naive_many - naive_one) / (NAIVE_VIEWERS - 1)
    small = asyncio.run(_small())
    viewer = max(0.01, (small["many"] - small["one"]) / (VIEWERS - 1))
    conditions = (
        f"640x480@15, {small['one']:.1f} % for 1 viewer and {small['many']:.1f} % for {VIEWERS}; of "
        f"{small['given']:.1f} pictures/s that came from the robot the one viewer of this process got "
        f"{small['seen']:.1f} and each of the others {small['fps']:.1f}, in one process that took "
        f"{small['crowd']:.0f} % of a core for it; "
        f"naive: {naive_one:.0f} % for 1 and {naive_many:.0f} % for {NAIVE_VIEWERS}"
    )
    naive_32 = naive_one + naive_viewer * (VIEWERS - 1)
    yield _figure("video_32_viewers_cpu_pct", small["many"], "% of a core", naive_32, conditions)
    yield _figure("video_viewer_naive_ratio", naive_viewer / viewer, "times CPU per added viewer", None, conditions)
    yield _figure("video_delay_p50_ms", small["delay"], "ms", None, "capture to decoded picture, 640x480@15, loopback")
    yield _figure("video_first_frame_ms", small["first"], "ms", None, "camera idle before, worker started for it")
    large = asyncio.run(_large())
    conditions = (
        f"2048x1536@4, JPEG of {large['kb']:.0f} kB, WebRTC 1280 wide and every JPEG in full size; "
        f"{large['jpeg']:.1f} % with JPEG alone"
    )
    yield _figure("video_large_cpu_pct", large["both"], "% of a core", None, conditions)


def _figure(name: str, value: float, unit: str, naive: float | None, conditions: str) -> dict[str, Any]:
    shown = None if naive is None else round(naive, 1)
    ratio = None if naive is None else round(naive / value, 1)
    return {"name": name, "value": round(value, 1), "unit": unit, "naive": shown, "ratio": ratio,
            "conditions": conditions}  # fmt: skip


class Site:
    """A camera process, a robot and a page."""

    def __init__(self, stack: ExitStack, size: tuple[int, int, float]) -> None:
        width, height, fps = size
        data = self.data = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        url = stack.enter_context(_robot(width, height, fps))
        self.process = psutil.Process(stack.enter_context(camera_process(data)).pid)
        self.link = CameraLink(data)
        self.source = Source("weeder-01", CameraInfo("front", "Front", width, height, fps=fps), url=url, token=TOKEN)
        self.times: dict[int, float] = {}
        self.jpegs = 0
        self.kb = 0.0

    async def open(self) -> None:
        """Tell the camera process, and open the page's socket."""
        await self.link.ask("PUT", "/sources", {"sources": [self.source]})
        self.socket = await self.link.live("bench")
        hello = json.loads(await self.socket.recv())
        self.watcher = hello["watcher"]
        self._tasks = [asyncio.create_task(self._ping()), asyncio.create_task(self._read())]
        await self.say(k="watch", n=2, robot="weeder-01", camera="front", way="times")
        await asyncio.sleep(2.0)  # its zygote imports

    async def say(self, **frame: Any) -> None:
        """Send a frame."""
        await self.socket.send(json.dumps(frame))

    async def cpu_pct(self, seconds: float = SECONDS) -> float:
        """Return what camera process and workers use."""
        before, began_s = self._cpu_s(), time.monotonic()
        await asyncio.sleep(seconds)
        return 100 * (self._cpu_s() - before) / (time.monotonic() - began_s)

    async def close(self) -> None:
        """End."""
        for task in self._tasks:
            task.cancel()
        await self.socket.close()
        await self.link.close()

    def _cpu_s(self) -> float:
        return sum(_used_s(one) for one in (self.process, *self.process.children(recursive=True)))

    async def _ping(self) -> None:
        while True:
            await self.say(k="ping", m=1.0)
            await asyncio.sleep(0.4)

    async def _read(self) -> None:
        while True:
            said = await self.socket.recv()
            if isinstance(said, bytes):
                self.jpegs, self.kb = self.jpegs + 1, len(said) / 1000
                continue
            frame = json.loads(said)
            if frame["k"] == "times":
                self.times |= {rtp: captured for rtp, captured, _ in frame["p"]}


class Viewer:
    """A WebRTC viewer that counts pictures, and decodes them if asked."""

    def __init__(self, *, decodes: bool) -> None:
        self.peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        self.units = 0
        self.seen: list[tuple[int, float]] = []
        self.first = asyncio.Event()
        self._depacketizer = Depacketizer()
        self._decoder = Decoder("h264") if decodes else None

    async def open(self, link: CameraLink, watcher: str) -> None:
        """Offer, and take the answer."""
        receiver = self.peer.addTransceiver("video", direction="recvonly").receiver
        take_packets(receiver, self._take)
        await self.peer.setLocalDescription(await self.peer.createOffer())
        headers = {**HEADERS, WATCHER_HEADER: watcher}
        offer = self.peer.localDescription.sdp.encode()
        answer = await link.ask("POST", "/cameras/weeder-01/front/whep", offer, headers)
        assert answer.status_code == 201, answer.text
        await self.peer.setRemoteDescription(RTCSessionDescription(answer.text, "answer"))

    async def _take(self, packet: RtpPacket, arrival_time_ms: int) -> None:
        if self._decoder is None:
            self.units += packet.marker
            return
        unit = self._depacketizer.add(packet)
        if unit is not None:
            frame = self._decoder.decode(unit[0])
            if isinstance(frame, av.VideoFrame):
                self.seen.append((packet.timestamp, time.monotonic() * 1000))
                self.first.set()


async def _small() -> dict[str, float]:
    with ExitStack() as stack:
        site = Site(stack, SMALL)
        await site.open()
        began_s = time.monotonic()
        one = Viewer(decodes=True)
        await one.open(site.link, site.watcher)
        await one.first.wait()
        first_ms = 1000 * (time.monotonic() - began_s)
        await asyncio.sleep(SETTLE_S)
        cpu_one = await site.cpu_pct()
        delays = [at - site.times[rtp] for rtp, at in one.seen[5:] if rtp in site.times]
        crowd = stack.enter_context(_crowd(site))
        assert crowd.stdout is not None
        await asyncio.to_thread(crowd.stdout.readline)
        await asyncio.sleep(SETTLE_S)
        others = psutil.Process(crowd.pid)
        before, used_s, began_s = await asyncio.to_thread(_units, crowd), _used_s(others), time.monotonic()
        seen = len(one.seen)
        cpu_many = await site.cpu_pct()
        units, span_s = await asyncio.to_thread(_units, crowd) - before, time.monotonic() - began_s
        got = {
            "fps": units / span_s / (VIEWERS - 1),
            "seen": (len(one.seen) - seen) / span_s,
            "crowd": 100 * (_used_s(others) - used_s) / span_s,
            "given": (await site.link.ask("GET", "/cameras")).json()["cameras"][0]["fps"],
        }
        await one.peer.close()
        await site.close()
        return {"one": cpu_one, "many": cpu_many, "delay": statistics.median(delays), "first": first_ms, **got}


async def _large() -> dict[str, float]:
    with ExitStack() as stack:
        site = Site(stack, LARGE)
        await site.open()
        await site.say(k="watch", n=1, robot="weeder-01", camera="front", way="jpeg", width=0, fps=15)
        await asyncio.sleep(SETTLE_S)
        jpeg = await site.cpu_pct()
        viewer = Viewer(decodes=True)
        await viewer.open(site.link, site.watcher)
        await viewer.first.wait()
        await asyncio.sleep(SETTLE_S)
        both = await site.cpu_pct()
        await viewer.peer.close()
        await site.close()
        return {"jpeg": jpeg, "both": both, "kb": site.kb}


@contextmanager
def _crowd(site: Site) -> Iterator[subprocess.Popen[str]]:
    """Let many watch from a process of their own."""
    arguments = [sys.executable, "-m", "bench.video", "crowd", str(VIEWERS - 1), str(site.data), site.watcher]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, stdin=subprocess.PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.terminate()


def _used_s(process: psutil.Process) -> float:
    """Return the CPU a process used so far."""
    times = process.cpu_times()
    return float(times.user + times.system)


def _units(crowd: subprocess.Popen[str]) -> int:
    assert crowd.stdin is not None
    assert crowd.stdout is not None
    crowd.stdin.write("\n")
    crowd.stdin.flush()
    return int(crowd.stdout.readline())


async def _watch_many(count: int, data: Path, watcher: str) -> None:
    """Runs in the process of the crowd: says how many pictures came whenever it is asked."""
    link, viewers = CameraLink(data), [Viewer(decodes=False) for _ in range(count)]
    for viewer in viewers:
        await viewer.open(link, watcher)
    print("watching", flush=True)
    while await asyncio.to_thread(sys.stdin.readline):
        print(sum(viewer.units for viewer in viewers), flush=True)


@contextmanager
def _robot(width: int, height: int, fps: float) -> Iterator[str]:
    """Serve a robot's camera from a process of its own; yield its address."""
    arguments = [sys.executable, "-m", "bench.video", "robot", str(width), str(height), str(fps)]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, stdin=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            yield process.stdout.readline().strip()
        finally:
            process.terminate()


def _naive(viewers: int) -> float:
    """Return CPU of a process that encodes for each viewer."""
    arguments = [sys.executable, "-m", "bench.video", "naive", str(viewers)]
    done = subprocess.run(arguments, capture_output=True, text=True, check=True, timeout=90)
    return float(json.loads(done.stdout.splitlines()[-1])["cpu_pct"])


def _serve_robot(width: int, height: int, fps: float) -> None:
    with fake_camera(FakeCamera(width, height, fps)) as camera:
        print(camera.url, flush=True)
        sys.stdin.read()


def main() -> None:
    """Run one of the helping processes."""
    parser = argparse.ArgumentParser()
    parser.add_argument("what", choices=["robot", "naive", "crowd"])
    parser.add_argument("more", nargs="+")
    wanted = parser.parse_args()
    more = wanted.more
    if wanted.what == "robot":
        _serve_robot(int(more[0]), int(more[1]), float(more[2]))
    elif wanted.what == "crowd":
        asyncio.run(_watch_many(int(more[0]), Path(more[1]), more[2]))
    else:
        from bench.video_naive import measure

        print(json.dumps({"cpu_pct": asyncio.run(measure(int(more[0]), SECONDS))}))


if __name__ == "__main__":
    main()
