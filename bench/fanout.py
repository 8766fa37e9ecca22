"""Fan-out: CPU of the server that shows 1,000 robots ten times a second to 100 browsers.

Prints ``fanout_cpu_pct`` and ``fanout_naive_ratio``. Ours is store, hub and lanes behind uvicorn; the browsers are
websocket clients in another process that count what they get. The naive way is a NiceGUI timer that sets the text of
a label per robot, measured smaller (it saturates far below) and compared per value shown in one browser.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import socket
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from datetime import UTC, datetime
from typing import Any

from websockets.asyncio.client import ClientConnection, connect

from bench.broker import free_port
from bench.nicegui_browser import nicegui_browser

ROBOTS, RATE_HZ, LANES, SECONDS = 1000, 10, 100, 10
NAIVE_ROBOTS, NAIVE_LANES = 100, 4
CONDITIONS = (
    f"{ROBOTS} robots x {RATE_HZ} Hz x {LANES} lanes (topic poses, all robots move), ticks included; naive: "
    f"ui.timer and labels, {NAIVE_ROBOTS} x {RATE_HZ} Hz x {NAIVE_LANES} browsers"
)


def run() -> Iterator[dict[str, Any]]:
    """Measure both ways and yield the figures."""
    ours = _measure("ours", LANES)
    naive = _measure("naive", NAIVE_LANES)
    shown = ours["frames"] / LANES / ours["wall_s"]
    conditions = (
        f"{CONDITIONS}; each lane got {shown:.1f} frames/s, {ours['bytes'] / LANES / ours['wall_s'] / 1000:.0f} kB/s"
    )
    # On a loaded machine frames are skipped; the figure is for the full rate all the same.
    cpu_pct = ours["cpu_s"] / ours["frames"] * LANES * RATE_HZ * 100
    naive_pct = naive["cpu_s"] / naive["wall_s"] * 100
    ours_us = ours["cpu_s"] / (ours["frames"] * ROBOTS) * 1e6
    naive_us = naive["cpu_s"] / naive["values"] * 1e6
    yield {
        "name": "fanout_cpu_pct",
        "value": round(cpu_pct, 1),
        "unit": "% of a core",
        "naive": round(naive_pct, 1),
        "ratio": None,
        "conditions": conditions,
    }
    yield {
        "name": "fanout_naive_ratio",
        "value": round(naive_us / ours_us),
        "unit": "times CPU per value shown",
        "naive": round(naive_us, 2),
        "ratio": round(naive_us / ours_us),
        "conditions": f"{CONDITIONS}; ours {ours_us:.3f} us a value",
    }


def _measure(side: str, lanes: int) -> dict[str, float]:
    command = [sys.executable, "-m", "bench.fanout", "--side"]
    server = subprocess.Popen([*command, side], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert server.stdin is not None
    assert server.stdout is not None
    try:
        port = int(line(server, "port"))
        browsers = subprocess.Popen(
            [*command, f"{side}-browsers", "--port", str(port), "--lanes", str(lanes)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert browsers.stdin is not None
        try:
            line(browsers, "open")
            for process in (server, browsers):
                tell(process)
            time.sleep(SECONDS)
            for process in (server, browsers):
                tell(process)
            return {**json.loads(line(server, "cpu")), **json.loads(line(browsers, "got"))}
        finally:
            browsers.stdin.close()
            browsers.wait(20)
    finally:
        server.stdin.close()
        server.wait(20)


def line(process: subprocess.Popen[str], key: str) -> str:
    """Return what a process prints after a word."""
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith(key + " "):
            return line.removeprefix(key + " ")
    raise RuntimeError(f"the process ended before it said {key!r}")


def tell(process: subprocess.Popen[str]) -> None:
    """Let a process go on."""
    assert process.stdin is not None
    process.stdin.write("\n")
    process.stdin.flush()


async def report_cpu(making: list[float]) -> None:
    """Wait for begin and end of the measurement, then print what it cost; ``making`` grows and is not part of it."""
    await asyncio.to_thread(sys.stdin.readline)
    cpu_s, wall_s = time.process_time() - making[0], time.monotonic()
    await asyncio.to_thread(sys.stdin.readline)
    cost = {"cpu_s": time.process_time() - making[0] - cpu_s, "wall_s": time.monotonic() - wall_s}
    print("cpu", json.dumps(cost), flush=True)
    await asyncio.to_thread(sys.stdin.readline)  # until the parent closes the pipe


@asynccontextmanager
async def served(robots: int, *, crowd: int | None) -> AsyncIterator[tuple[Any, int]]:
    """Serve a store by hub and lane on a free port of loopback; ``crowd`` as the hub takes it, ``None`` is its own."""
    import uvicorn
    from starlette.applications import Starlette

    from hmi.clock import SystemClock
    from hmi.domain.freshness import TickRing
    from hmi.domain.role import Role
    from hmi.live.hub import CROWD, LiveHub
    from hmi.live.lane import lane_route, same_origin_or
    from hmi.security.session_info import SessionInfo
    from hmi.store.fleet import FleetStore
    from tests.hmi.ingest.wire import Entry

    clock = SystemClock()
    store = FleetStore(clock.mono_s)
    store.set_registry([Entry(f"robot-{i:04d}") for i in range(robots)])
    hub = LiveHub(store, TickRing("bench1", clock.mono_s, clock.utc), clock, crowd=CROWD if crowd is None else crowd)
    one = SessionInfo("s", "u", "U", Role.VIEWER, "d", "", "farm", "c", datetime(2100, 1, 1, tzinfo=UTC))

    class Gate:
        def of_headers(self, _headers: object) -> SessionInfo:
            return one

        def get(self, _session_id: str) -> SessionInfo:
            return one

    route = lane_route(hub, Gate(), same_origin_or(), lambda _who, _lane, _frame: None, clock)
    config = uvicorn.Config(Starlette(routes=[route]), log_level="error", ws="websockets-sansio")
    config.ws_per_message_deflate = False
    server, listener = uvicorn.Server(config), _listener()
    serving = asyncio.create_task(server.serve(sockets=[listener]))
    await hub.start()
    try:
        yield store, listener.getsockname()[1]
    finally:
        await hub.stop()
        server.should_exit = True
        await serving


async def _ours() -> None:
    async with served(ROBOTS, crowd=ROBOTS) as (store, port):  # the full rate: ten times a second
        making = [0.0]
        moving = asyncio.create_task(_move(store, making))
        print("port", port, flush=True)
        await report_cpu(making)
        moving.cancel()


async def _move(store: Any, making: list[float]) -> None:
    """Let every robot move ten times a second, in 25 ms batches as ingest brings them.

    ``making`` takes the CPU time of inventing values: that is the cost of this bench, not of showing them.
    """
    from hmi.domain.robot import Pose, Stamp, Telemetry

    batches, step = 4, 0
    ids = [f"robot-{i:04d}" for i in range(ROBOTS)]
    due_s = time.monotonic()
    while True:
        step += 1
        now_s = time.monotonic()
        stamp = Stamp(now_s - 0.01, now_s)
        begun_s = time.thread_time()
        for index in range(step % batches, ROBOTS, batches):
            pose = Pose(52.0 + index * 1e-5 + step * 1e-7, 5.0, 0.0, 0.0, step * 0.01, 0.42, 0.0, stamp)
            store.put_telemetry(ids[index], Telemetry(pose, None, None, None, None, None))
        making[0] += time.thread_time() - begun_s
        store.announce()
        due_s += 1 / RATE_HZ / batches
        await asyncio.sleep(max(0.0, due_s - time.monotonic()))


async def _our_browsers(port: int, lanes: int) -> None:
    got = {"frames": 0, "bytes": 0}
    is_counting = False
    newest: dict[int, float] = {}

    async def browse(number: int) -> None:
        own = f"http://127.0.0.1:{port}"
        async with connect(f"ws://127.0.0.1:{port}/live", origin=own, compression=None) as ws:  # type: ignore[arg-type]
            await ws.send('{"k":"sub","topics":["poses"]}')
            pinging = asyncio.create_task(ping(ws, newest, number))
            try:
                async for frame in ws:
                    if is_counting:
                        got["bytes"] += len(frame)
                        got["frames"] += isinstance(frame, bytes)
                    if isinstance(frame, str) and frame.startswith('{"k":"tick"'):
                        newest[number] = json.loads(frame)["m"]
            finally:
                pinging.cancel()

    browsing = [asyncio.create_task(browse(n)) for n in range(lanes)]
    await asyncio.sleep(3)
    print("open ", flush=True)
    await asyncio.to_thread(sys.stdin.readline)
    is_counting = True
    await asyncio.to_thread(sys.stdin.readline)
    is_counting = False
    print("got", json.dumps(got), flush=True)
    for task in browsing:
        task.cancel()
    await asyncio.gather(*browsing, return_exceptions=True)


async def ping(ws: ClientConnection, newest: dict[int, float], number: int) -> None:
    """Say once a second how far we are, as lane.js does."""
    for n in range(10**6):
        await asyncio.sleep(1)
        if number in newest:
            await ws.send(json.dumps({"k": "ping", "n": n, "m": newest[number]}))


def _naive() -> None:
    from nicegui import app, ui

    port = free_port()

    @ui.page("/")
    def page() -> None:
        labels = [ui.label() for _ in range(NAIVE_ROBOTS)]
        step = 0

        def show() -> None:
            nonlocal step
            step += 1
            for index, label in enumerate(labels):
                label.text = f"52.{index:04d}{step:05d}, 5.0, {step % 360}"

        ui.timer(1 / RATE_HZ, show)

    async def report() -> None:
        print("port", port, flush=True)
        await report_cpu([0.0])
        app.shutdown()

    tasks = []
    app.on_startup(lambda: tasks.append(asyncio.create_task(report())))
    ui.run(
        port=port, host="127.0.0.1", show=False, reload=False, ws_per_message_deflate=False, show_welcome_message=False
    )


async def _naive_browsers(port: int, lanes: int) -> None:
    values = 0
    is_counting = False

    async def browse() -> None:
        nonlocal values
        async with nicegui_browser(port) as browser:
            async for frame in browser.frames():
                if is_counting:
                    values += frame.count('"text"')

    browsing = [asyncio.create_task(browse()) for _ in range(lanes)]
    await asyncio.sleep(4)
    print("open ", flush=True)
    await asyncio.to_thread(sys.stdin.readline)
    is_counting = True
    await asyncio.to_thread(sys.stdin.readline)
    is_counting = False
    for task in browsing:
        if task.done():
            task.result()
        task.cancel()
    print("got", json.dumps({"values": values}), flush=True)
    await asyncio.gather(*browsing, return_exceptions=True)


def _listener() -> socket.socket:
    listener = socket.socket()
    listener.bind(("127.0.0.1", 0))
    return listener


def main() -> None:
    """Run one side, for a parent that measures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--side", choices=("ours", "ours-browsers", "naive", "naive-browsers"), required=True)
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--lanes", type=int, default=0)
    options = parser.parse_args()
    if options.side == "ours":
        asyncio.run(_ours())
    elif options.side == "ours-browsers":
        asyncio.run(_our_browsers(options.port, options.lanes))
    elif options.side == "naive":
        _naive()
    else:
        asyncio.run(_naive_browsers(options.port, options.lanes))


if __name__ in {"__main__", "__mp_main__"}:
    main()
