"""A viewer whose WebRTC is not ours: werift on Node.js, installed for this test from a lock with hashes.

A long test: it needs npm once. Where that does not install, it is skipped and says so.
"""

from __future__ import annotations

import asyncio
import json
import shutil
import subprocess
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from hmi.cameras.demand import Way
from tests.hmi.cameras.rig import camera_rig
from tests.hmi.cameras.waiting import until

pytestmark = pytest.mark.long
SOURCE = Path(__file__).parents[2] / "interop" / "webrtc"
INSTALL_S = 90
CONSENT_S = 60  # its page is still there, and it left without a word: only ICE's consent tells


@pytest.fixture(scope="session")
def stack(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the script of the viewer beside what it needs."""
    node, npm = shutil.which("node"), shutil.which("npm")
    if node is None or npm is None:
        pytest.skip("no Node.js here")
    folder = tmp_path_factory.mktemp("webrtc")
    for one in SOURCE.iterdir():
        shutil.copy(one, folder)
    command = [npm, "ci", "--ignore-scripts", "--no-audit", "--no-fund"]
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=INSTALL_S, check=False)
    except subprocess.TimeoutExpired:
        pytest.skip("npm did not install the other WebRTC in time")
    if done.returncode:
        pytest.skip(f"npm does not install the other WebRTC: {done.stderr[-200:]}")
    return folder / "viewer.mjs"


class ForeignViewer:
    """A process that views; ``came`` is what it said last."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._process = process
        self.offer = ""
        self.came: dict[str, Any] = {}
        self.states: list[str] = []
        self._task = asyncio.create_task(self._hear())

    async def _hear(self) -> None:
        assert self._process.stdout is not None
        async for line in self._process.stdout:
            said = json.loads(line)
            self.offer = said.get("offer", self.offer)
            self.came = said.get("came", self.came)
            self.states += [said["state"]] if "state" in said else []

    def answer(self, sdp: str) -> None:
        """Give it the answer; an empty one lets it leave."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps({"answer": sdp}).encode() + b"\n")

    async def end(self) -> None:
        """Let it leave."""
        self.answer("")
        try:
            async with asyncio.timeout(5):
                await self._process.wait()
        except TimeoutError:
            self._process.kill()
        await self._task


@asynccontextmanager
async def foreign(script: Path, codec: str) -> AsyncIterator[ForeignViewer]:
    """Start a viewer that takes one codec."""
    process = await asyncio.create_subprocess_exec(
        "node", script.name, codec, cwd=script.parent, stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE
    )
    viewer = ForeignViewer(process)
    try:
        await until(lambda: viewer.offer)
        yield viewer
    finally:
        await viewer.end()


@pytest.mark.parametrize(("codec", "way"), [("H264", Way.H264), ("VP8", Way.VP8)])
async def test_another_webrtc_sees_our_pictures(stack: Path, codec: str, way: Way) -> None:
    async with camera_rig() as rig, foreign(stack, codec) as viewer:
        session_id, answer = await rig.whep.open(rig.page, rig.camera, viewer.offer)
        viewer.answer(answer)
        await until(lambda: viewer.came.get("pictures", 0) >= 8)
        assert rig.whep.sessions[session_id].wish.way is way
        assert viewer.came["codec"] == f"video/{codec}"
        assert viewer.came["keys"] >= 1 or way is Way.VP8
        times = viewer.came["times"]
        assert all(0 < (after - before) % 2**32 < 90_000 for before, after in pairwise(times))


async def test_another_webrtc_that_leaves_is_let_go(stack: Path) -> None:
    async with camera_rig() as rig:
        async with foreign(stack, "H264") as viewer:
            _, answer = await rig.whep.open(rig.page, rig.camera, viewer.offer)
            viewer.answer(answer)
            await until(lambda: viewer.came.get("pictures", 0) >= 2)
        await until(lambda: not rig.whep.sessions, CONSENT_S)
        assert rig.camera.describe()["viewers"] == 0
