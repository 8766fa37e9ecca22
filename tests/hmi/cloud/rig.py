"""A console's cloud side against the simulated context broker, on a clock that only a test moves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import httpx

from backend_clients.http.retry import RetryPolicy
from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.connection import Broker
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.identifier import EntityRef
from backend_clients.ngsi.query import Query
from backend_clients.ngsi.tenant import Tenant
from backend_clients.simulator.context_broker.application import make_application
from backend_clients.simulator.context_broker.broker import ContextBroker
from backend_clients.simulator.context_broker.faults import FaultSwitch
from hmi.clock import FakeClock
from hmi.cloud.backlog import Backlog
from hmi.cloud.broker_link import broker_link
from hmi.cloud.link import CloudLink
from hmi.cloud.marker import Marker
from hmi.cloud.mirror import Mirror
from hmi.cloud.news import CloudNews
from hmi.cloud.outbox import Outbox
from hmi.cloud.refused import RefusedFile, RefusedRecords
from hmi.cloud.states import RobotStates
from hmi.domain.robot import Robot
from hmi.fiware.normalized import key_values
from hmi.fiware.urn import KeyValues, Urns
from hmi.store.fleet import Changes
from hmi.store.robot_record import Part


class Road(httpx.AsyncBaseTransport):
    """The network between console and broker; a test breaks it."""

    def __init__(self, inner: httpx.AsyncBaseTransport, clock: FakeClock) -> None:
        self._inner, self._clock = inner, clock
        self.broken: Callable[[httpx.Request], Exception | httpx.Response | None] | None = None
        self.delay_s = 0.0
        self.requests: list[httpx.Request] = []

    async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
        """See httpx."""
        self.requests.append(request)
        self._clock.advance(self.delay_s)
        if self.broken is not None:
            found = self.broken(request)
            if isinstance(found, Exception):
                raise found
            if found is not None:
                return found
        return await self._inner.handle_async_request(request)


class Fleet:
    """What ``RobotStates`` reads of the live store."""

    def __init__(self) -> None:
        self.known: dict[str, Robot] = {}
        self._changed: dict[str, int] = {}
        self._removed: dict[str, int] = {}
        self.revision = 0

    def put(self, *robots: Robot) -> None:
        """Change robots."""
        for robot in robots:
            self.revision += 1
            self.known[robot.id], self._changed[robot.id] = robot, self.revision

    def remove(self, robot_id: str) -> None:
        """Take a robot out of the farm."""
        self.revision += 1
        self._removed[robot_id] = self.revision
        del self.known[robot_id], self._changed[robot_id]

    def robot(self, robot_id: str) -> Robot | None:
        """See ``FleetStore``."""
        return self.known.get(robot_id)

    def since(self, revision: int) -> Changes:
        """See ``FleetStore``."""
        changed = {key: frozenset({Part.TELEMETRY}) for key, at in self._changed.items() if at > revision}
        removed = frozenset(key for key, at in self._removed.items() if at > revision)
        return Changes(self.revision, changed, removed)


class Rig:
    """Everything of one console; ``again`` is the same console after a restart."""

    def __init__(self, folder: Path, *, is_strict: bool = True, max_bytes: int = 10**7, max_age_s: float = 86_400.0,
                 clock: FakeClock | None = None, broker: ContextBroker | None = None) -> None:  # fmt: skip
        self.folder, self.clock = folder, clock or FakeClock()
        self.broker, self.switch = broker or ContextBroker(self.clock, None), FaultSwitch()
        inner = httpx.ASGITransport(make_application(self.broker, self.switch))
        self.road, self.urns, self.fleet = Road(inner, self.clock), Urns("hof"), Fleet()
        self.outbox = Outbox(folder / "outbox.db", max_bytes, max_age_s)
        self.backlog = Backlog(self.outbox, self.clock, memory=500)
        self.news = CloudNews(self.urns, self.clock, self.backlog.put, lambda _robot: None)
        self.whole: list[KeyValues] = []
        self.refused = RefusedRecords(RefusedFile(folder / "refused.db"), self.clock)
        self.link = self._link(Tenant("farm"), is_strict=is_strict)
        self.mirror = Mirror(self.link, RobotStates(self.fleet, self.urns, self.clock), self.backlog, self.clock,
                             self._whole, refused=self.refused)  # type: ignore[arg-type]  # a fleet of its own  # fmt: skip

    def _link(self, tenant: Tenant, *, is_strict: bool) -> CloudLink:
        broker = Broker("http://broker.test", tenant, timeout_s=5, retry=RetryPolicy(attempts=1))
        ref = EntityRef(self.urns.of("Headland", "console"), "Headland")
        self.marker = marker = Marker(self.folder / "console.json", ref, "Hof", is_strict=is_strict)
        client = NgsiClient(broker, transport=self.road)
        return CloudLink(client, marker, self.clock, broker_link(self.clock, jitter=1.0))

    async def _whole(self) -> Sequence[KeyValues]:
        return self.whole

    async def is_ours(self) -> bool:
        """Say whether the tenant that answers now is this console's."""
        return await self.marker.is_ours(self.link.client)

    async def run(self, seconds: float, step_s: float = 0.5) -> None:
        """Let the mirror do its rounds for so long."""
        for _ in range(max(1, round(seconds / step_s))):
            self.clock.advance(step_s)
            await self.mirror.round()

    async def in_cloud(self, kind: str, tenant: str = "farm") -> dict[str, dict[str, Any]]:
        """Return what the broker has of one type, by id, past every fault."""
        inner = httpx.ASGITransport(make_application(self.broker, FaultSwitch()))
        async with NgsiClient(Broker("http://broker.test", Tenant(tenant)), transport=inner) as client:
            found: list[Entity] = [one async for one in client.entities(Query(types=(kind,)))]
        return {one.ref.id: key_values(one) for one in found}

    async def close(self) -> None:
        """End it as the console does."""
        await self.backlog.close()
        await self.refused.close()
        await self.link.client.close()
