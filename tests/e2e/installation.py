"""A running demo: started by the tests on free ports, ended by them, nothing left."""

from __future__ import annotations

import json
import os
import selectors
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx

from hmi.keeper.ports import free_port
from tests.e2e.caller import Caller

ROOT = Path(__file__).parents[2]
START_LIMIT_S = 60.0
CALM_LIMIT_S = 20.0
ROBOTS = ("weeder-01", "weeder-02", "weeder-03")
END_LIMIT_S = 3.0  # the promise: Ctrl+C ends everything within 3 s


@dataclass
class Installation:
    """Handle on a running `headland demo`."""

    process: subprocess.Popen[str]
    url: str
    data: Path
    ready_s: float

    @classmethod
    def start(
        cls,
        data: Path,
        *options: str,
        host: str = "127.0.0.1",
        fleet: str = "small",
        has_media: bool = False,
        has_cameras: bool = False,
        map_engine: str = "full",
        has_cloud: bool = False,
        has_planner: bool = False,
    ) -> Installation:
        """Start the demo with its data in ``data`` and wait until it says that it is ready; twin and cameras on demand.

        Args:
            map_engine: browsers of tests draw WebGL in software, where ``auto`` would never show the full map.
        """
        port = free_port()
        env = {k: v for k, v in os.environ.items() if not k.startswith("HEADLAND_")}
        env |= {"HEADLAND_HOST": host, "HEADLAND_PORT": str(port), "HEADLAND_DATA": str(data)}
        env |= {
            "HEADLAND_MAP_ENGINE": map_engine,
            "HEADLAND_DEMO_FLEET": fleet,
            "HEADLAND_MEDIA": str(has_media).lower(),
            "HEADLAND_CAMERAS": str(has_cameras).lower(),
            "HEADLAND_DEMO_CLOUD": str(has_cloud).lower(),
            "HEADLAND_DEMO_PLANNER": str(has_planner).lower(),
        }
        started_s = time.monotonic()
        process = subprocess.Popen(
            [sys.executable, "-m", "hmi", "demo", *options],
            cwd=ROOT,
            env=env,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        line = _wait_for_line(process, "Headland is ready at ")
        return cls(process, line.rsplit(" ", 1)[1], data, time.monotonic() - started_s)

    def health(self) -> dict[str, Any]:
        """Return what the console says of its parts."""
        answer: dict[str, Any] = httpx.get(f"{self.url}/api/v1/health", timeout=5, trust_env=False).json()
        return answer

    def keeper(self) -> dict[str, Any]:
        """Return the keeper's own view, which works while the console is frozen."""
        parts: dict[str, Any] = json.loads((self.data / "run" / "keeper.json").read_text())["parts"]
        return parts

    def pid(self, part: str) -> int:
        """Return the process id of one part."""
        pid: int = self.keeper()[part]["pid"]
        return pid

    def simulator(self, method: str, path: str, body: dict[str, Any] | None = None) -> Any:
        """Ask or tell the simulator something that only a simulator can do."""
        base = self.keeper()["simulator"]["url"]
        answer = httpx.request(method, f"{base}{path}", json=body, timeout=5, trust_env=False)
        answer.raise_for_status()
        return answer.json() if answer.content else None

    def world(self, robot: str) -> dict[str, Any]:
        """Return the ground truth about one robot."""
        truth: dict[str, Any] = self.simulator("GET", f"/_world/{robot}")
        return truth

    def fault(self, robot: str, name: str, **more: Any) -> None:
        """Switch a fault of a robot on."""
        self.simulator("POST", f"/_faults/{robot}", {"fault": name, **more})

    def mend(self, robot: str, name: str | None = None) -> None:
        """Switch one fault off, or all of them."""
        self.simulator("DELETE", f"/_faults/{robot}" + (f"?fault={name}" if name else ""))

    def calm(self) -> None:
        """Let every robot be healthy, heard, not stopped and idle, the console know it, and the queue not be frozen."""
        for robot in ROBOTS:
            self.mend(robot)
        deadline_s = time.monotonic() + CALM_LIMIT_S
        caller = Caller(self.url, "supervisor")
        try:
            while any(not self._is_calm(caller, robot) for robot in ROBOTS):
                assert time.monotonic() < deadline_s, "the robots do not calm down"
                for robot in ROBOTS:
                    caller.calm(robot)
                time.sleep(0.1)
            caller.thaw()
        finally:
            caller.close()

    def _is_calm(self, caller: Caller, robot: str) -> bool:
        shown, truth = caller.get(f"/robots/{robot}"), self.world(robot)
        return bool(
            not truth["latched"]
            and truth["standstill"]
            and truth["mode"] in ("idle", "paused")
            and (shown.get("link") or {}).get("is_online")
            and not (shown.get("lease") or {}).get("owner")
            and not (shown.get("safety") or {}).get("latched")
            and (shown.get("mission") or {}).get("status") not in ("running", "paused")
        )

    def end(self) -> float:
        """Press Ctrl+C; return how many seconds it took to end."""
        started_s = time.monotonic()
        self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(END_LIMIT_S + 10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        if self.process.stdout:
            self.process.stdout.close()
        return time.monotonic() - started_s


def _wait_for_line(process: subprocess.Popen[str], start: str) -> str:
    assert process.stdout is not None
    deadline_s = time.monotonic() + START_LIMIT_S
    seen: list[str] = []
    with selectors.DefaultSelector() as selector:
        selector.register(process.stdout, selectors.EVENT_READ)
        while time.monotonic() < deadline_s:
            if not selector.select(timeout=0.5):
                continue
            line = process.stdout.readline()
            if not line:
                break
            seen.append(line.strip())
            if line.startswith(start):
                return line.strip()
    process.kill()
    process.wait()
    raise AssertionError("the demo did not become ready:\n" + "\n".join(seen))
