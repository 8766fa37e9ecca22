"""The demo's stage: the tester's HTTP of the simulator, on this machine only."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import httpx

from hmi.api.demo import StageAway
from hmi.demo.fleet import read_demo_fleet

LIMIT_S = 5.0  # the simulator shares a small machine with everything else of the demo


class SimulatorStage:
    """Speaks to the simulator whose robots stand in the data folder's fleet file.

    Args:
        data: the data folder.
        transport: instead of the network, in tests.
    """

    def __init__(self, data: Path, transport: httpx.AsyncBaseTransport | None = None) -> None:
        self._data, self._transport = data, transport

    async def situations(self) -> dict[str, Any]:
        """Return what can be played and what is on."""
        answer = await self._ask("GET", "/_situations")
        if not answer.is_success:
            raise StageAway(f"it answered {answer.status_code}")
        told: dict[str, Any] = answer.json()
        return told

    async def play(self, robot_id: str, situation: str | None) -> str:
        """Play or end a situation; return why not. Raises ``KeyError`` for an unknown robot or situation."""
        answer = await self._ask("POST", f"/_situations/{robot_id}", {"situation": situation})
        if answer.status_code == 404:
            raise KeyError(robot_id)
        return "" if answer.is_success else str(answer.json().get("text", "The simulator refused it."))

    async def _ask(self, method: str, path: str, body: dict[str, Any] | None = None) -> httpx.Response:
        rows = read_demo_fleet(self._data)
        if not rows:
            raise StageAway("there is no fleet file")
        base = rows[0]["http_url"].rsplit("/", 1)[0]
        try:
            # plain HTTP on this machine: reading the certificates would only cost time
            client = httpx.AsyncClient(transport=self._transport, timeout=LIMIT_S, trust_env=False, verify=False)  # noqa: S501
            async with client:
                return await client.request(method, f"{base}{path}", json=body)
        except httpx.HTTPError as error:
            raise StageAway(str(error)) from error
