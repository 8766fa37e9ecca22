"""The camera process starts workers and loads nothing of what they decode with."""

from __future__ import annotations

import subprocess
import sys

STARTS_ONE = """
import asyncio, sys
from hmi.cameras.picture_wire import Plan
from hmi.cameras.service import serve
from hmi.cameras.worker_process import WorkerProcess, start_zygote
from hmi.domain.camera import CameraInfo, Source, SourceKind

async def start():
    camera = CameraInfo("front", "Front", 640, 480)
    source = Source("weeder-01", camera, SourceKind.ROBOT, "http://127.0.0.1:9", "token")
    worker = await WorkerProcess.start(source, Plan())
    found = [one async for one in worker.messages()]  # until it says that nothing answers there
    print(found[-1].ended, await worker.end())

if __name__ == "__main__":
    start_zygote()
    asyncio.run(start())
    print(sorted(one for one in sys.modules if one in ("hmi.cameras.worker", "hmi.cameras.pull_http")))
"""


def test_a_worker_starts_without_its_decoders_in_the_camera_process() -> None:
    done = subprocess.run([sys.executable, "-c", STARTS_ONE], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.splitlines() == ["nothing answers at the camera's address ", "[]"]
