"""STOP the naive way: a button of the console's own page, sent by its loop, answered on labels.

One NiceGUI process is the console: it reads the broker, shows 200 robots on labels ten times a second and carries
STOP as a NiceGUI event. The measure is the one of ``bench.stop``: from the press until the last of 20 browsers was told
of the robot's acknowledgement.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import random
import secrets
import time
from typing import Any

from backend_clients.edge import messages_down as down
from backend_clients.edge.codec import decode_body, encode
from backend_clients.edge.mqtt import MqttLink
from backend_clients.edge.topics import Down, Up, every_robot, parse, topic
from bench.broker import free_port, mosquitto
from bench.nicegui_browser import NiceGuiBrowser, nicegui_browser
from bench.stop import BROWSERS, ROBOT, loads, percentile, process
from bench.storm import PERIOD_S, heavy_page

PRESSES = 60  # a press under load takes a second
LABELS = 200
SHOW_S = 0.1  # as often as a robot speaks


def p99_ms(name: str) -> float:
    """Return the p99 of the naive way under the load called ``name`` in ``bench.stop``, in ms."""
    return percentile(asyncio.run(_measure(name)), 99)


async def _measure(name: str) -> list[float]:
    with mosquitto() as broker, contextlib.ExitStack() as parts:
        parts.enter_context(process("bench.stop", "--robot", str(broker)))
        port = free_port()
        is_storm = ["--storm"] if name == "stop_storm_p99_ms" else []
        parts.enter_context(process("bench.stop_naive", "--broker", str(broker), "--port", str(port), *is_storm))
        await _answers(port)
        async with contextlib.AsyncExitStack() as pages:
            browsers = [await pages.enter_async_context(nicegui_browser(port)) for _ in range(BROWSERS)]
            if not is_storm:
                for arguments in loads(name, broker):
                    parts.enter_context(process(*arguments))
            return await _press(browsers)


async def _answers(port: int) -> None:
    async with asyncio.timeout(30):
        while True:
            with contextlib.suppress(OSError):
                _reader, writer = await asyncio.open_connection("127.0.0.1", port)
                writer.close()
                return
            await asyncio.sleep(0.1)


async def _press(browsers: list[NiceGuiBrowser]) -> list[float]:
    waiting: set[int] = set()
    done = asyncio.Event()
    number = 0

    async def read(place: int) -> None:
        async for frame in browsers[place].frames():
            if f'answered {number}"' in frame.replace("\\", ""):
                waiting.discard(place)
                if not waiting:
                    done.set()

    reading = [asyncio.create_task(read(place)) for place in range(len(browsers))]
    await asyncio.sleep(3)  # until the load runs
    times_ms = []
    for number in range(1, PRESSES + 1):
        await asyncio.sleep(random.uniform(0.03, 0.07))
        waiting.update(range(len(browsers)))
        done.clear()
        began = time.perf_counter()
        await browsers[number % len(browsers)].click(BUTTON_ID)
        async with asyncio.timeout(60):
            await done.wait()
        times_ms.append((time.perf_counter() - began) * 1000)
    for task in reading:
        task.cancel()
    return times_ms


BUTTON_ID = 4  # of the first element that a page makes


class NaiveConsole:
    """A console in one loop: pages with labels, the broker, and STOP as an event of the page."""

    def __init__(self, broker: int, *, is_storm: bool) -> None:
        self._newest: dict[str, Any] = {}
        self._answers: list[Any] = []
        self._pressed = self._opened = 0
        self._is_storm = is_storm
        self._loop: asyncio.AbstractEventLoop | None = None
        self._storm: asyncio.Task[None] | None = None
        self._link = MqttLink(
            f"mqtt://127.0.0.1:{broker}",
            "bench-naive",
            subscriptions=[(every_robot(kind), 1) for kind in (Up.ACK, Up.TELEMETRY, Up.HEARTBEAT, Up.SAFETY)],
            on_message=self._heard,
        )

    async def begin(self) -> None:
        """Connect to the broker; at start of the page server."""
        self._loop = asyncio.get_running_loop()
        self._link.start()

    def has_come(self) -> None:
        """Count a browser; the storm begins when all are there."""
        self._opened += 1
        if self._is_storm and self._opened == BROWSERS:
            self._storm = asyncio.create_task(_open_pages())

    def page(self) -> None:
        """Make one page: STOP, its answer, and a label for each robot."""
        from nicegui import ui

        ui.button("STOP", on_click=self._press)
        self._answers.append(ui.label("ready"))
        labels = [ui.label() for _ in range(LABELS)]

        def show() -> None:
            for label, (robot_id, state) in zip(labels, self._newest.items(), strict=False):
                label.text = f"{robot_id}: {state.lat_deg:.7f}, {state.lon_deg:.7f}, {state.speed_mps} m/s"

        ui.timer(SHOW_S, show)

    def _heard(self, name: str, data: bytes, _retained: bool) -> None:
        assert self._loop is not None
        self._loop.call_soon_threadsafe(self._told, name, data)

    def _told(self, name: str, data: bytes) -> None:
        address = parse(name)
        message = decode_body(address, data)
        if address.kind is Up.ACK and address.robot == ROBOT:
            for label in self._answers:
                label.text = f"answered {self._pressed}"
        elif address.kind is Up.TELEMETRY:
            self._newest[address.robot] = message

    def _press(self) -> None:
        self._pressed += 1
        message = down.Stop(robot=ROBOT, stop_id=secrets.token_hex(16), by="Bench")
        self._link.publish(topic(ROBOT, Down.STOP), encode(message), qos=1)


async def _open_pages() -> None:
    while True:
        began = time.monotonic()
        heavy_page()
        await asyncio.sleep(max(0.01, PERIOD_S - (time.monotonic() - began)))


def _serve(broker: int, port: int, *, is_storm: bool) -> None:
    from nicegui import app, ui

    console = NaiveConsole(broker, is_storm=is_storm)
    ui.page("/")(console.page)
    app.on_startup(console.begin)
    app.on_connect(console.has_come)
    ui.run(port=port, host="127.0.0.1", show=False, reload=False, show_welcome_message=False)


def main() -> None:
    """Be the naive console, or print the figure of one load."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--broker", type=int)
    parser.add_argument("--port", type=int)
    parser.add_argument("--storm", action="store_true")
    parser.add_argument("--measure")
    options = parser.parse_args()
    if options.measure:
        print(json.dumps(p99_ms(options.measure)))
    else:
        _serve(options.broker, options.port, is_storm=options.storm)


if __name__ in {"__main__", "__mp_main__"}:
    main()
