"""What a console does every second, every few seconds and every day beside its work."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from hmi.api.health import KeeperReport
from hmi.app.records import Records
from hmi.clock import Clock
from hmi.live.hub import LiveHub
from hmi.store.errors import StoreError

WATCH_S = 1.0
AGREE_S = 5.0  # how long a person disabled by the command line may go on
THIN_S = 600.0  # history is thinned in small steps; nobody waits for it
DAY_S = 86_400.0
log = logging.getLogger(__name__)


class Chores:
    """Runs them as tasks; one that fails is logged and comes round again."""

    def __init__(self, records: Records, hub: LiveHub, keeper: KeeperReport, clock: Clock) -> None:
        self._records, self._hub, self._keeper, self._clock = records, hub, keeper, clock
        self._tasks: list[asyncio.Task[None]] = []
        self.further: list[Callable[[], Awaitable[None]]] = []  # what else has to agree with who may do what now

    def start(self) -> None:
        """Begin."""
        rounds: list[tuple[str, float, Callable[[], Awaitable[Any]]]] = [
            ("watch", WATCH_S, self._watch),
            ("agree", AGREE_S, self._agree),
            ("thin", THIN_S, self._thin),
            ("forget", DAY_S, self._records.sessions.forget_old),
        ]
        self._tasks = [asyncio.create_task(_every(*one), name=f"console-{one[0]}") for one in rounds]

    async def stop(self) -> None:
        """End all of them."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self._tasks = []

    def health(self) -> dict[str, dict[str, Any]]:
        """Return the parts of the records for ``/api/v1/health``."""
        records = self._records
        is_ok = {
            "audit": records.audit.health().is_ok,
            "recorder": records.recorder.health().is_ok,
            "stop_list": records.stop_list.is_written,
        }
        return {name: {"state": "ok" if ok else "degraded"} for name, ok in is_ok.items()}

    async def _watch(self) -> None:
        parts = await asyncio.to_thread(self._keeper.parts)
        self._hub.stop_state = str(parts.get("stop", {}).get("state", "unknown"))
        self._hub.keeper = worth_telling(parts)
        self._records.sessions.sweep()

    async def _agree(self) -> None:
        """Take over what other consoles and the command line changed; write what could not be written before."""
        await self._records.sessions.reconcile()
        for agree in self.further:
            await agree()
        if not self._records.stop_list.is_written:
            await asyncio.to_thread(self._records.stop_list.export)

    async def _thin(self) -> None:
        await asyncio.to_thread(self._records.thinning.run, self._clock.utc())


async def _every(name: str, period_s: float, work: Callable[[], Awaitable[Any]]) -> None:
    while True:
        try:
            await work()
        except StoreError as error:
            log.warning("%s: %s", name, error)
        except Exception:
            log.exception("%s failed and is tried again", name)
        await asyncio.sleep(period_s)


def worth_telling(parts: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return what pages are told of the parts: those that are down, and those that were.

    One that starts for the first time was never missed; only STOP is missed from the first moment.
    """
    return [
        {"name": name, "state": part.get("state"), "last_down": part.get("last_down")}
        for name, part in parts.items()
        if part.get("down_since_utc") or part.get("last_down") or (name == "stop" and part.get("state") != "ok")
    ]
