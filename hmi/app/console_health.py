"""How the console's own parts are, gathered once a second for the supervision."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import msgspec
import psutil

from hmi.api.health import KeeperReport
from hmi.app.records import Records
from hmi.clock import Clock
from hmi.domain.stop import StopState
from hmi.ingest.supervision.console import Health
from hmi.stop_gateway.outbox import Record
from hmi.store.batch_writer import WriterHealth

LOST_SHOWN_S = 60.0
DATABASE_EVERY_S, DATABASE_LIMIT_S = 5.0, 3.0
AUDIT_FIRST_S, AUDIT_EVERY_S = 60.0, 86_400.0
log = logging.getLogger(__name__)
_outbox = msgspec.json.Decoder(list[Record])


class ConsoleHealth:
    """Asks every part; slow ones in threads, so that the round is never held up.

    Args:
        writers: name -> how that writer is.
    """

    def __init__(
        self,
        records: Records,
        data: Path,
        clock: Clock,
        is_broker_up: Callable[[], bool],
        writers: Mapping[str, Callable[[], WriterHealth]],
        farm_id: str,
    ) -> None:
        self._records, self._data, self._clock, self._farm_id = records, data, clock, farm_id
        self._is_broker_up, self._writers = is_broker_up, writers
        self._keeper = KeeperReport(data)
        self._outbox_seen: tuple[int, int] | None = None
        self.not_confirmed: dict[str, str] = {}
        self._dropped: dict[str, tuple[int, float]] = {}
        self._clocks: tuple[float, float] | None = None
        self._probe: asyncio.Task[bool] | None = None
        self._asked_s = float("-inf")
        self.is_database_up = True
        self._audit: asyncio.Task[None] | None = None
        self._audit_due_s = clock.mono_s() + AUDIT_FIRST_S
        self._audit_text: str | None = None

    @property
    def is_audit_known(self) -> bool:
        """Whether the chain of the audit was walked since the console started."""
        return self._audit_text is not None

    async def gather(self, late_s: float) -> Health:
        """Return how everything is; ``late_s`` is how late this round came."""
        parts, disk = await asyncio.to_thread(self._read_files)
        self._ask_database()
        self._verify_audit()
        return Health(
            is_broker_up=self._is_broker_up(),
            parts=parts,
            disk_free=disk,
            writers={name: self._writer_text(name, health()) for name, health in self._writers.items()},
            is_database_up=self.is_database_up,
            late_s=late_s,
            clock_jump_s=self._jump_s(),
            audit_text=self._audit_text or "",
            utc=self._clock.utc(),
        )

    async def close(self) -> None:
        """End what is asked."""
        tasks = [task for task in (self._probe, self._audit) if task is not None]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def _read_files(self) -> tuple[dict[str, dict[str, Any]], tuple[int, float] | None]:
        self._read_outbox()
        try:
            usage = psutil.disk_usage(str(self._data))
        except OSError:
            return self._keeper.parts(), None
        return self._keeper.parts(), (usage.free, usage.free / max(1, usage.total))

    def _read_outbox(self) -> None:
        """Learn of presses that only the gateway heard, for instance while the console restarted."""
        path = self._data / "stop" / "outbox.json"
        try:
            status = path.stat()
            if (version := (status.st_mtime_ns, status.st_size)) == self._outbox_seen:
                return
            records = _outbox.decode(path.read_bytes())
        except FileNotFoundError:
            self.not_confirmed = {}
            return
        except (OSError, msgspec.DecodeError):
            return  # the gateway is writing, or says itself that it cannot be read
        self._outbox_seen = version
        open_ones = [one for one in records if one.state is StopState.NOT_CONFIRMED]
        self.not_confirmed = {one.robot: f"{one.by} pressed STOP. {one.text}".strip() for one in open_ones}

    def _writer_text(self, name: str, health: WriterHealth) -> str:
        now_s = self._clock.mono_s()
        count, since_s = self._dropped.get(name, (health.dropped, float("-inf")))
        if health.dropped > count:
            since_s = now_s
        self._dropped[name] = health.dropped, since_s
        if not health.is_ok:
            return health.last_error or "it stands still"
        return f"{health.dropped} lines were lost" if now_s - since_s < LOST_SHOWN_S else ""

    def _jump_s(self) -> float:
        now, now_s = self._clock.utc().timestamp(), self._clock.mono_s()
        before, self._clocks = self._clocks, (now, now_s)
        return 0.0 if before is None else (now - before[0]) - (now_s - before[1])

    def _ask_database(self) -> None:
        now_s = self._clock.mono_s()
        if self._probe is not None and self._probe.done():
            self.is_database_up = (
                not self._probe.cancelled() and self._probe.exception() is None and self._probe.result()
            )
            self._probe = None
        if self._probe is not None:
            self.is_database_up = self.is_database_up and now_s - self._asked_s < DATABASE_LIMIT_S
        elif now_s - self._asked_s >= DATABASE_EVERY_S:
            self._asked_s = now_s
            work = asyncio.to_thread(self._records.database.is_reachable)
            self._probe = asyncio.create_task(work, name="alarm-database")

    def _verify_audit(self) -> None:
        if (self._audit is None or self._audit.done()) and self._clock.mono_s() >= self._audit_due_s:
            self._audit_due_s = self._clock.mono_s() + AUDIT_EVERY_S
            self._audit = asyncio.create_task(self._walk_audit(), name="alarm-audit")

    async def _walk_audit(self) -> None:
        try:
            verdict = await self._records.database.run(self._records.audit.verify, self._farm_id)
        except Exception:  # asked again in a day; an unreachable database is an alarm of its own
            log.exception("the audit chain could not be checked")
            return
        self._audit_text = "" if verdict.first_broken_seq is None else verdict.text
