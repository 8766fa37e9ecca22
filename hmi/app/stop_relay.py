"""Presses that came to the console alone, told to the STOP gateway: every slab shows what the gateway knows.

A browser presses at both. Another program may press at the console only, and a browser may have lost the gateway for
a moment; without this the slabs of all others would say READY while that machine is braking, or is not.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence

import httpx
import msgspec

from hmi.domain.stop_token import StopToken
from hmi.settings import Settings
from hmi.stop_gateway.outbox import open_presses

FIRST_S = 0.3  # who presses at both has told the gateway by then
LONGEST_S = 5.0
LIMIT_S = 2.0
MOST = 500  # robots of one request: the gateway reads 64 KiB, an id has 64 letters at most


class StopRelay:
    """Tells the gateway until it holds the press, or nothing of the press is open here any more.

    Args:
        open_at: ids of the robots at which a press is not reset here.
        transport: instead of the network.
    """

    def __init__(
        self,
        settings: Settings,
        open_at: Callable[[str], Sequence[str]],
        transport: httpx.AsyncBaseTransport | None = None,
    ) -> None:
        self._settings, self._open_at, self._transport = settings, open_at, transport
        self._note = settings.data / "run" / "stop.json"
        self._outbox = settings.data / "stop" / "outbox.json"
        self._telling: dict[str, asyncio.Task[None]] = {}

    def press(self, stop_id: str, token: StopToken) -> None:
        """Begin to tell of a press, in the background."""
        if stop_id in self._telling:
            return
        task = asyncio.get_running_loop().create_task(self._tell(stop_id, token), name="stop-relay")
        self._telling[stop_id] = task
        task.add_done_callback(lambda _task: self._telling.pop(stop_id, None))

    async def settled(self) -> None:
        """Wait until nothing is on its way to the gateway."""
        while self._telling:
            await asyncio.wait(list(self._telling.values()))

    async def close(self) -> None:
        """Tell nothing more."""
        tasks = list(self._telling.values())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _tell(self, stop_id: str, token: StopToken) -> None:
        wait_s = FIRST_S
        while True:
            await asyncio.sleep(wait_s)
            held = {(one.stop_id, one.robot) for one in await asyncio.to_thread(open_presses, self._outbox)}
            robots = [one for one in self._open_at(stop_id) if (stop_id, one) not in held]
            if not robots or await self._post(stop_id, robots, token):
                return
            wait_s = min(2 * wait_s, LONGEST_S)

    async def _post(self, stop_id: str, robots: Sequence[str], token: StopToken) -> bool:
        url = await asyncio.to_thread(self._address)
        if url is None:
            return False
        header = {"Authorization": f"Bearer {token.sign(self._settings.secret)}"}
        try:
            # this machine speaks to itself, and its certificate names it as others call it
            client = httpx.AsyncClient(transport=self._transport, timeout=LIMIT_S, trust_env=False, verify=False)  # noqa: S501
            async with client:
                answers = [
                    await client.post(
                        url, json={"stop_id": stop_id, "robots": robots[begin : begin + MOST]}, headers=header
                    )
                    for begin in range(0, len(robots), MOST)
                ]
        except httpx.HTTPError:
            return False
        # one that was refused stays so: the gateway judges the tablet by the same list of revoked ones
        return all(answer.status_code < 500 for answer in answers)

    def _address(self) -> str | None:
        """Where the gateway listens on this machine now; blocks."""
        try:
            port = msgspec.json.decode(self._note.read_bytes(), type=dict[str, object])["port"]
        except (OSError, msgspec.DecodeError, KeyError):
            return None
        host = self._settings.near_host
        return f"{'https' if self._settings.is_tls else 'http'}://{f'[{host}]' if ':' in host else host}:{port}/stop"
