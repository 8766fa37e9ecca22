"""Many browsers in a process of their own, so that what they cost is not what the server costs.

``python -m tests.faults.browsers PORT COUNT ROBOTS`` opens all lanes at once, waits until each has the state of every
robot, says so in a line, and dies without a goodbye when its input ends.
"""

from __future__ import annotations

import asyncio
import json
import os
import sys

from websockets.asyncio.client import ClientConnection, connect

PATIENCE_S = 60
SUBSCRIBE = '{"k":"sub","topics":["fleet"]}'


async def come_back(port: int, robots: int) -> ClientConnection:
    """Open a lane as a browser does after an outage: hello, subscription, full state."""
    ws = await connect(
        f"ws://127.0.0.1:{port}/live",
        additional_headers={"Cookie": "headland_session=secret"},
        origin=f"http://127.0.0.1:{port}",  # type: ignore[arg-type]
        compression=None,
        open_timeout=PATIENCE_S,
    )
    await ws.send(SUBSCRIBE)
    while True:
        found = json.loads(await ws.recv())
        if found["k"] == "snap" and len(found["d"].get("fleet", {}).get("robots", {})) == robots:
            return ws


async def main(port: int, count: int, robots: int) -> None:
    """Come, say so, and stay until the input ends."""
    lanes = await asyncio.gather(*(come_back(port, robots) for _ in range(count)))
    print(len(lanes), flush=True)
    await asyncio.to_thread(sys.stdin.read)
    os._exit(0)  # no goodbye, as when an access point dies


if __name__ == "__main__":
    asyncio.run(main(*(int(word) for word in sys.argv[1:])))
