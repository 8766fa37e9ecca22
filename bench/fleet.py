"""One more viewer of the fleet screen: CPU of the server with 1,000 robots that report twice a second.

Prints ``fleet_viewer_cpu_points``: percent of a core that each further browser costs. The server is store, hub and
lanes behind uvicorn; browsers are websocket clients in another process that listen to ``fleet`` and ``poses``. The
naive way encodes the list of all robots for each browser twice a second.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

from websockets.asyncio.client import connect

from bench import fanout

ROBOTS, RATE_HZ, SECONDS = 1000, 2, 10
FEW, MANY = 2, 42
NAME = "fleet_viewer_cpu_points"


def run() -> Iterator[dict[str, Any]]:
    """Measure with few and with many viewers; the difference is what one costs."""
    few, many = _measure(FEW), _measure(MANY)
    points = (_percent(many) - _percent(few)) / (MANY - FEW)
    naive_ms = few["naive_s"] * 1000
    naive = naive_ms / 1000 * RATE_HZ * 100
    kilobytes = many["bytes"] / MANY / many["wall_s"] / 1000
    yield {
        "name": NAME,
        "value": round(points, 3),
        "unit": "% of a core a viewer",
        "naive": round(naive, 2),
        "ratio": round(naive / points) if points > 0 else None,
        "conditions": f"{ROBOTS} robots x {RATE_HZ} Hz, topics fleet and poses, {FEW} and {MANY} viewers; a viewer "
        f"gets {kilobytes:.0f} kB/s; the server with {FEW} viewers: {_percent(few):.1f} %; naive: the list encoded "
        f"for each viewer, {naive_ms:.1f} ms",
    }


def _percent(cost: dict[str, float]) -> float:
    return cost["cpu_s"] / cost["wall_s"] * 100


def _measure(lanes: int) -> dict[str, float]:
    command = [sys.executable, "-m", "bench.fleet", "--side"]
    server = subprocess.Popen([*command, "server"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert server.stdin is not None
    try:
        port = fanout.line(server, "port")
        naive_s = float(fanout.line(server, "naive"))
        viewers = subprocess.Popen(
            [*command, "viewers", "--port", port, "--lanes", str(lanes)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert viewers.stdin is not None
        try:
            fanout.line(viewers, "open")
            for process in (server, viewers):
                fanout.tell(process)
            time.sleep(SECONDS)
            for process in (server, viewers):
                fanout.tell(process)
            cost = {**json.loads(fanout.line(server, "cpu")), **json.loads(fanout.line(viewers, "got"))}
            return {**cost, "naive_s": naive_s}
        finally:
            viewers.stdin.close()
            viewers.wait(20)
    finally:
        server.stdin.close()
        server.wait(20)


async def _server() -> None:
    from hmi.presenters.fleet import entry
    from tests.hmi.live.crowd import Crowd

    async with fanout.served(ROBOTS, crowd=None) as (store, port):
        crowd = Crowd(store, ROBOTS)
        crowd.step()
        store.robots()  # what both ways need is not the difference
        begun_s = time.process_time()
        json.dumps({robot.id: entry(robot) for robot in store.robots()})
        naive_s = time.process_time() - begun_s
        making = [0.0]
        moving = asyncio.create_task(_move(crowd, making))
        print("port", port, flush=True)
        print("naive", naive_s, flush=True)
        await fanout.report_cpu(making)
        moving.cancel()


async def _move(crowd: Any, making: list[float]) -> None:
    due_s = time.monotonic()
    while True:
        begun_s = time.thread_time()
        crowd.step()
        making[0] += time.thread_time() - begun_s
        due_s += 1 / RATE_HZ
        await asyncio.sleep(max(0.0, due_s - time.monotonic()))


async def _viewers(port: int, lanes: int) -> None:
    got = {"bytes": 0}
    is_counting = False
    newest: dict[int, float] = {}

    async def watch(number: int) -> None:
        own = f"http://127.0.0.1:{port}"
        async with connect(f"ws://127.0.0.1:{port}/live", origin=own, compression=None, max_size=None) as ws:  # type: ignore[arg-type]
            await ws.send('{"k":"sub","topics":["fleet","poses"]}')
            pinging = asyncio.create_task(fanout.ping(ws, newest, number))
            try:
                async for frame in ws:
                    if is_counting:
                        got["bytes"] += len(frame)
                    if isinstance(frame, str) and frame.startswith('{"k":"tick"'):
                        newest[number] = json.loads(frame)["m"]
            finally:
                pinging.cancel()

    watching = [asyncio.create_task(watch(n)) for n in range(lanes)]
    await asyncio.sleep(4)
    print("open ", flush=True)
    await asyncio.to_thread(sys.stdin.readline)
    is_counting = True
    await asyncio.to_thread(sys.stdin.readline)
    is_counting = False
    print("got", json.dumps(got), flush=True)
    for task in watching:
        task.cancel()
    await asyncio.gather(*watching, return_exceptions=True)


def main() -> None:
    """Run one side, for a parent that measures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--side", choices=("server", "viewers"), required=True)
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--lanes", type=int, default=0)
    options = parser.parse_args()
    asyncio.run(_server() if options.side == "server" else _viewers(options.port, options.lanes))


if __name__ in {"__main__", "__mp_main__"}:
    main()
