"""STOP: from a press to the last of 20 browsers showing the robot's acknowledgement.

Prints ``stop_idle_p99_ms``, ``stop_loaded_p99_ms``, ``stop_burst_p99_ms`` and ``stop_storm_p99_ms``. Ours is the
gateway process with a real mosquitto and a robot in a process of its own that answers at once; the browsers are raw
websockets here. *Loaded* is 4,000 messages a second of 200 robots on the same broker, half of which the gateway has to
read. *Burst* is 10,000 of them at once every two seconds. *Storm* is a console that builds a heavy page every half
second. The naive way is one NiceGUI process that also is the console: the press comes by its event, its loop sends, and
labels show the answer (``bench.stop_naive``).
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import os
import random
import secrets
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
from websockets.asyncio.client import ClientConnection, connect

from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import decode_body, encode
from backend_clients.edge.mqtt import MqttLink
from backend_clients.edge.topics import Address, Down, Up, topic
from bench.broker import mosquitto
from bench.storm import PERIOD_S, heavy_page
from hmi.domain.stop_token import StopToken

BROWSERS = 20
PRESSES = 300
PAUSE_S = (0.03, 0.07)  # between presses; jittered so that no timer of ours falls into step with them
WARM_UP = 20
ROBOT = "weeder-01"
SECRET = secrets.token_hex(16)
LOADS = {
    "stop_idle_p99_ms": "idle",
    "stop_loaded_p99_ms": "4,000 msg/s of 200 robots on the broker",
    "stop_burst_p99_ms": "10,000 messages of 200 robots at once every 2 s",
    "stop_storm_p99_ms": "a heavy page is built every 0.5 s in the console's process",
}


def run() -> Iterator[dict[str, Any]]:
    """Measure both ways under each load and yield the figures."""
    from bench.stop_naive import p99_ms  # here, because it measures with what is in this module

    for name, load in LOADS.items():
        times_ms = asyncio.run(measure(name))
        naive_ms = p99_ms(name)
        value = percentile(times_ms, 99)
        yield {
            "name": name,
            "value": value,
            "unit": "ms",
            "naive": naive_ms,
            "ratio": round(naive_ms / value, 1),
            "conditions": f"p99 of {len(times_ms)} presses, {BROWSERS} browsers, {load}; "
            f"p50 {percentile(times_ms, 50)} ms, worst {max(times_ms):.1f} ms",
        }


def percentile(times_ms: list[float], share: int) -> float:
    """Return a percentile, rounded to a tenth."""
    return round(statistics.quantiles(times_ms, n=100, method="inclusive")[share - 1], 1)


async def measure(name: str) -> list[float]:
    """Return the time of each press under the load called ``name``, in ms."""
    with tempfile.TemporaryDirectory() as folder, mosquitto() as port, contextlib.ExitStack() as parts:
        data = Path(folder)
        (data / "stop").mkdir()
        (data / "stop" / "robots.json").write_text(json.dumps([{"id": ROBOT, "name": "Weeder 01"}]))
        env = {
            "HEADLAND_DATA": folder,
            "HEADLAND_SECRET": SECRET,
            "HEADLAND_BROKER_URL": f"mqtt://127.0.0.1:{port}",
            "HEADLAND_STOP_PORT": "0",
        }
        parts.enter_context(process("bench.stop", "--robot", str(port)))
        parts.enter_context(process("hmi.stop_gateway", env=env))
        for arguments in loads(name, port):
            parts.enter_context(process(*arguments))
        return await _press(await _address(data / "run" / "stop.json"))


def loads(name: str, port: int) -> list[list[str]]:
    """Return the processes, as arguments of Python's ``-m``, that make the load called ``name``."""
    if name == "stop_loaded_p99_ms":
        return [["bench.mqtt_load", "--port", str(port), "--robots", "200", "--rate", "4000", "--seconds", "120"]]
    if name == "stop_burst_p99_ms":
        return [["bench.mqtt_load", "--port", str(port), "--robots", "200", "--burst", "10000", "--seconds", "120"]]
    return [["bench.stop", "--storm"]] if name == "stop_storm_p99_ms" else []


@contextlib.contextmanager
def process(module: str, *arguments: str, env: dict[str, str] | None = None) -> Iterator[None]:
    """Run one of our modules as long as the context lives."""
    running = subprocess.Popen(
        [sys.executable, "-m", module, *arguments], env={**os.environ, **(env or {})}, stdout=subprocess.DEVNULL
    )
    try:
        yield
    finally:
        running.kill()
        running.wait()


async def _address(note: Path) -> str:
    async with asyncio.timeout(20):
        while not note.exists():  # noqa: ASYNC110, ASYNC240 - a process has no event to wait for
            await asyncio.sleep(0.05)
    return str(json.loads(note.read_text())["url"])  # noqa: ASYNC240 - before anything is measured


async def _press(url: str) -> list[float]:
    token = StopToken("bench", "Bench", "", "", "farm").sign(SECRET)
    async with contextlib.AsyncExitStack() as sockets:
        browsers = [
            await sockets.enter_async_context(connect(f"{url.replace('http', 'ws')}/ws", compression=None))
            for _ in range(BROWSERS)
        ]
        shown = _Shown()
        readers = [asyncio.create_task(shown.read(place, browser, token)) for place, browser in enumerate(browsers)]
        async with asyncio.timeout(20):
            await shown.linked.wait()
        times_ms = []
        for number in range(PRESSES + WARM_UP):
            await asyncio.sleep(random.uniform(*PAUSE_S))
            taken_ms = await shown.press(browsers[number % BROWSERS])
            if number >= WARM_UP:
                times_ms.append(taken_ms)
        for reader in readers:
            reader.cancel()
        return times_ms


class _Shown:
    """Counts the browsers that show the acknowledgement of the newest press."""

    def __init__(self) -> None:
        self.linked = asyncio.Event()
        self._unlinked = set(range(BROWSERS))
        self._stop_id = ""
        self._waiting: set[int] = set()
        self._done = asyncio.Event()

    async def press(self, browser: ClientConnection) -> float:
        """Press, wait until all browsers show the answer, return the time in ms."""
        self._stop_id = secrets.token_hex(16)
        self._waiting = set(range(BROWSERS))
        self._done.clear()
        frame = json.dumps({"k": "stop", "stop_id": self._stop_id, "robots": [ROBOT]})
        began = time.perf_counter()
        await browser.send(frame)
        async with asyncio.timeout(10):
            await self._done.wait()
        return (time.perf_counter() - began) * 1000

    async def read(self, place: int, browser: ClientConnection, token: str) -> None:
        """Be the browser number ``place``."""
        await browser.send(json.dumps({"k": "auth", "token": token}))
        async for text in browser:
            frame = msgspec.json.decode(text)
            if frame["k"] == "hb" and (frame.get("robots", {}).get(ROBOT) or {}).get("heard_ms") is not None:
                self._unlinked.discard(place)
                if not self._unlinked:
                    self.linked.set()
            if frame["k"] != "step" or frame["stop_id"] != self._stop_id or frame["ack_ms"] is None:
                continue
            self._waiting.discard(place)
            if not self._waiting:
                self._done.set()


def robot(port: int) -> None:
    """Be a robot that acknowledges at once, stands at once, and forgets a press when the next one comes."""
    presses: list[str] = []
    seq = 0

    def head() -> dict[str, Any]:
        nonlocal seq
        seq += 1
        return {
            "robot": ROBOT,
            "boot": "boot-bench",
            "seq": seq,
            "mono_ms": time.monotonic_ns() // 1_000_000,
            "wall_ms": 0,
        }

    def heard(_name: str, data: bytes, _retained: bool) -> None:
        message = decode_body(Address(ROBOT, Down.STOP), data)
        assert isinstance(message, down.Stop)
        link.publish(
            topic(ROBOT, Up.ACK), encode(up.Ack(**head(), kind="stop", ref=message.stop_id, outcome="accepted")), qos=1
        )
        if message.stop_id not in presses:
            presses.append(message.stop_id)
        listed = [
            up.Press(stop_id=stop_id, by="Bench", mono_ms=0, is_reset=stop_id != presses[-1])
            for stop_id in presses[-8:]
        ]
        state = up.Safety(
            **head(), hardware_stop=False, latched=True, standstill=True, speed_mps=0.0, tool_off=True, presses=listed
        )
        link.publish(topic(ROBOT, Up.SAFETY), encode(state))

    link = MqttLink(
        f"mqtt://127.0.0.1:{port}", "bench-robot", subscriptions=[(topic(ROBOT, Down.STOP), 1)], on_message=heard
    )
    link.start()
    while True:
        link.publish(topic(ROBOT, Up.HEARTBEAT), encode(up.Heartbeat(**head(), challenge="c" * 16)))
        time.sleep(0.2)


def storm() -> None:
    """Be a console that builds heavy pages: what blocks its loop must not reach STOP."""
    while True:
        began = time.monotonic()
        heavy_page()
        time.sleep(max(0.0, PERIOD_S - (time.monotonic() - began)))


def main() -> None:
    """Be one of the processes of the measurement."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", type=int, metavar="PORT")
    parser.add_argument("--storm", action="store_true")
    options = parser.parse_args()
    if options.robot:
        robot(options.robot)
    elif options.storm:
        storm()
    else:
        for figure in run():
            print(json.dumps(figure), flush=True)


if __name__ == "__main__":
    main()
