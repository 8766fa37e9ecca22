"""A gateway in its own process, as in an installation, and a browser's side of its protocol."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import secrets
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import httpx
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from hmi.domain.stop_token import StopToken
from tests.hmi.stop_gateway.fake_robot import FakeRobot

SECRET = "a-secret-of-the-tests-0123456789"
CONSOLE_PORT = 8080
TOKEN = StopToken("tablet-3", "Tablet 3", "martha", "Martha Keller", "farm").sign(SECRET)
ROOT = Path(__file__).parents[3]


class RunningGateway:
    """``python -m hmi.stop_gateway`` with its data in ``data``."""

    def __init__(self, data: Path, broker_url: str, console_port: int = CONSOLE_PORT) -> None:
        self.data = data
        self.url = ""
        self._env = {k: v for k, v in os.environ.items() if not k.startswith("HEADLAND_")} | {
            "HEADLAND_DATA": str(data),
            "HEADLAND_SECRET": SECRET,
            "HEADLAND_BROKER_URL": broker_url,
            "HEADLAND_STOP_PORT": "0",
            "HEADLAND_PORT": str(console_port),
        }
        self._process: subprocess.Popen[bytes] | None = None

    def register(self, *robots: FakeRobot, **fields: Any) -> None:
        """Write ``robots.json`` as the console does."""
        folder = self.data / "stop"
        folder.mkdir(parents=True, exist_ok=True)
        entries = [
            {"id": r.id, "name": r.id.title().replace("-", " "), "http_url": r.http_url, "token": r.token,
             "decel_mps2": 2.0, "ack_limit_s": 1.0, "standstill_limit_s": 3.0, "keep_out_m": 15.0,
             "contact_name": "Jonas Weber", "contact_phone": "0123", **fields}
            for r in robots
        ]  # fmt: skip
        draft = folder / "robots.draft"
        draft.write_text(json.dumps(entries))
        draft.replace(folder / "robots.json")

    @property
    def pid(self) -> int:
        assert self._process is not None
        return self._process.pid

    @property
    def is_running(self) -> bool:
        return self._process is not None

    def start(self) -> None:
        """Start it and wait until its note says where it listens."""
        note = self.data / "run" / "stop.json"
        started = time.monotonic()
        self.begin()
        assert self._process is not None
        while True:
            assert self._process.poll() is None, "the gateway ended"
            assert time.monotonic() - started < 10, "the gateway does not listen"
            if note.exists() and (said := json.loads(note.read_text()))["pid"] == self._process.pid:
                break
            time.sleep(0.01)  # a process has no event to wait for
        self.url = said["url"]

    def begin(self, port: int = 0) -> None:
        """Start it and wait for nothing."""
        self._process = subprocess.Popen(
            [sys.executable, "-W", "error", "-m", "hmi.stop_gateway"],
            cwd=ROOT,
            env=self._env | {"HEADLAND_STOP_PORT": str(port)},
        )

    def kill(self) -> None:
        """End it as a crash would."""
        assert self._process is not None
        self._process.kill()
        self._process.wait()
        self._process = None

    def terminate(self) -> float:
        """End it politely; return how long that took, in seconds."""
        assert self._process is not None
        began = time.monotonic()
        self._process.send_signal(signal.SIGTERM)
        code = self._process.wait(timeout=5)
        self._process = None
        assert code == 0
        return time.monotonic() - began

    def close(self) -> None:
        """End it if it runs."""
        if self._process is not None:
            self.kill()

    def http(self) -> httpx.AsyncClient:
        """Return a client with the STOP token."""
        return httpx.AsyncClient(
            base_url=self.url, headers={"Authorization": f"Bearer {TOKEN}"}, trust_env=False, timeout=5
        )


class Tablet:
    """One browser's websocket: keeps the newest step of each press and everything else in order."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket
        self.frames: list[dict[str, Any]] = []
        self.steps: dict[tuple[str, str], dict[str, Any]] = {}
        self.states: dict[tuple[str, str], list[str]] = {}
        self._more = asyncio.Event()
        self._task = asyncio.create_task(self._read())

    @classmethod
    async def open(cls, gateway: RunningGateway, token: str = TOKEN) -> Tablet:
        """Connect and say who we are."""
        socket = await connect(gateway.url.replace("http", "ws") + "/ws", compression=None)
        await socket.send(json.dumps({"k": "auth", "token": token}))
        return cls(socket)

    async def close(self) -> None:
        """Go away."""
        await self._socket.close()
        await self._task

    async def send(self, frame: object) -> None:
        """Send a frame; a string goes as it is."""
        await self._socket.send(frame if isinstance(frame, str | bytes) else json.dumps(frame))

    async def press(self, robots: list[str] | str) -> str:
        """Press STOP; return the stop id."""
        stop_id = secrets.token_hex(16)
        await self.send({"k": "stop", "stop_id": stop_id, "robots": robots})
        return stop_id

    async def until(self, is_true: Any, limit_s: float = 6.0) -> Any:
        """Wait until ``is_true(self)`` and return what it returned."""
        async with asyncio.timeout(limit_s):
            while not (result := is_true(self)):
                self._more.clear()
                await self._more.wait()
            return result

    async def until_state(self, stop_id: str, robot: str, state: str, limit_s: float = 6.0) -> dict[str, Any]:
        """Wait until a press at a robot is in ``state``; return its step."""

        def reached(tablet: Tablet) -> dict[str, Any] | None:
            step = tablet.steps.get((stop_id, robot))
            return step if step is not None and step["state"] == state else None

        return await self.until(reached, limit_s)

    async def until_frame(self, kind: str, is_right: Any = lambda _frame: True) -> dict[str, Any]:
        """Wait for a frame of a kind that ``is_right``; return it."""

        def found(tablet: Tablet) -> dict[str, Any] | None:
            return next((f for f in tablet.frames if f["k"] == kind and is_right(f)), None)

        return await self.until(found)

    @property
    def close_code(self) -> int | None:
        return self._socket.close_code

    async def _read(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            await self._read_all()
        self._more.set()

    async def _read_all(self) -> None:
        async for text in self._socket:
            frame = json.loads(text)
            self.frames.append(frame)
            if frame["k"] == "step":
                key = (frame["stop_id"], frame["robot"])
                self.steps[key] = frame
                seen = self.states.setdefault(key, [])
                if not seen or seen[-1] != frame["state"]:
                    seen.append(frame["state"])
            self._more.set()
