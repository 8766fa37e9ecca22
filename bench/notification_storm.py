"""A storm of notifications: what a context broker that tells of 1,000 changes a second does to the console.

Prints ``notify_storm_cpu_points``, ``notify_storm_rest_p99_ms`` and ``notify_storm_newest_s``. The notifications come
in any order, of fields that are ours and of others, while one field is really changed again and again; at the end the
console has to propose its newest state. The naive way, beside the first, reads each entity it is told of.
"""

from __future__ import annotations

import asyncio
import itertools
import json
import random
import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import httpx
import psutil

from tests.e2e.caller import Caller
from tests.e2e.installation import Installation
from tests.e2e.person import wait_for

RATE, SECONDS, CONNECTIONS = 1000, 20, 8
SETTLED_S, IDLE_S = 20.0, 10.0
TENANT = {"Fiware-Service": "demo"}
CHANGES = 40
CONDITIONS = f"{RATE} notifications/s for {SECONDS} s over {CONNECTIONS} connections, out of order; three robots"


def run() -> Iterator[dict[str, Any]]:
    """Start a demo with its cloud and let the storm come."""
    with tempfile.TemporaryDirectory() as folder:
        running = Installation.start(Path(folder) / "data", has_cloud=True)
        try:
            yield from _measure(running)
        finally:
            running.end()


def _measure(running: Installation) -> Iterator[dict[str, Any]]:
    caller = Caller(running.url, "admin")
    wait_for(lambda: caller.get("/cloud").get("map", {}).get("subscribed"), within_s=60, what="the subscription")
    time.sleep(SETTLED_S)
    console = psutil.Process(running.pid("console"))
    idle, _ = _cpu(console, lambda: time.sleep(IDLE_S))
    broker = running.keeper()["context_broker"]["url"]
    target, fields = _target(broker), _fields(broker)
    taken = caller.get("/cloud")["map"]["notifications"]
    storm = _Storm(broker, target, fields, running.url)
    busy, _ = _cpu(console, lambda: asyncio.run(storm.run()))
    begin_s = time.monotonic()
    name = f"Storm {CHANGES}"
    wait_for(lambda: name in json.dumps(caller.get("/map/proposals")), within_s=60, what="the newest name")
    newest_s = time.monotonic() - begin_s
    told = caller.get("/cloud")
    taken = told["map"]["notifications"] - taken
    caller.close()
    conditions = f"{CONDITIONS}; {storm.sent} sent in {storm.took_s:.1f} s, {taken} taken, {storm.failed} failed"
    scale = RATE * storm.took_s / storm.sent  # on a loaded machine the sender falls behind
    points = (busy - idle) * scale
    naive = RATE * _read_s(broker, fields) * 100
    worst, usual = statistics.quantiles(storm.rest_s, n=100)[98] * 1000, statistics.median(storm.rest_s) * 1000
    yield _figure("notify_storm_cpu_points", points, "% of a core", f"{conditions}; idle {idle:.1f} %", naive)
    asked = f"{len(storm.rest_s)} questions to /health meanwhile, median {usual:.1f} ms; {conditions}"
    yield _figure("notify_storm_rest_p99_ms", worst, "ms", asked)
    after = f"from the end of the storm until the newest of {CHANGES} changes is proposed"
    yield _figure("notify_storm_newest_s", newest_s, "s", after)


def _figure(name: str, value: float, unit: str, conditions: str, naive: float | None = None) -> dict[str, Any]:
    ratio = None if naive is None else round(naive / value, 2)
    shown = None if naive is None else round(naive, 1)
    return {"name": name, "value": round(value, 2), "unit": unit, "naive": shown, "ratio": ratio,
            "conditions": conditions}  # fmt: skip


class _Storm:
    """Posts as a broker does, changes a field meanwhile, and asks the console how it is."""

    def __init__(self, broker: str, target: str, fields: list[str], console: str) -> None:
        self._broker, self._target, self._fields, self._console = broker, target, fields, console
        self.sent = self.failed = 0
        self.took_s = 0.0
        self.rest_s: list[float] = []

    async def run(self) -> None:
        """Let it come."""
        begin_s = time.monotonic()
        numbers = itertools.count()
        async with asyncio.TaskGroup() as group:
            for _ in range(CONNECTIONS):
                group.create_task(self._post(begin_s, numbers))
            group.create_task(self._change(begin_s))
            group.create_task(self._ask(begin_s))
        self.took_s = time.monotonic() - begin_s

    async def _post(self, begin_s: float, numbers: Iterator[int]) -> None:
        where, chance = urlsplit(self._target), random.Random(1)
        reader, writer = await asyncio.open_connection(where.hostname, where.port)
        for number in numbers:
            if number >= RATE * SECONDS:
                break
            await asyncio.sleep(max(0.0, begin_s + number / RATE - time.monotonic()))
            at_s = time.time() - chance.uniform(0, 4)
            writer.write(_request(where, _body(self._fields, number, at_s)))
            head = await reader.readuntil(b"\r\n\r\n")
            self.sent += 1
            self.failed += not head.startswith(b"HTTP/1.1 204")
        writer.close()

    async def _change(self, begin_s: float) -> None:
        async with httpx.AsyncClient(headers=TENANT, trust_env=False) as client:
            for number in range(1, CHANGES + 1):
                await asyncio.sleep(max(0.0, begin_s + number * SECONDS / CHANGES - time.monotonic()))
                change = {"name": {"type": "Text", "value": f"Storm {number}"}}
                where = f"{self._broker}/v2/entities/{self._fields[0]}/attrs?type=AgriParcel"
                await client.post(where, json=change)

    async def _ask(self, begin_s: float) -> None:
        async with httpx.AsyncClient(trust_env=False, timeout=30) as client:
            while time.monotonic() - begin_s < SECONDS:
                asked_s = time.monotonic()
                await client.get(f"{self._console}/api/v1/health")
                self.rest_s.append(time.monotonic() - asked_s)
                await asyncio.sleep(0.1)


def _request(where: Any, body: bytes) -> bytes:
    head = (
        f"POST {where.path} HTTP/1.1\r\nHost: {where.netloc}\r\nContent-Type: application/json\r\n"
        f"Fiware-Service: demo\r\nFiware-Servicepath: /\r\nContent-Length: {len(body)}\r\n\r\n"
    )
    return head.encode() + body


def _body(fields: list[str], number: int, at_s: float) -> bytes:
    ref = fields[number % len(fields)] if number % 2 else f"urn:ngsi-ld:AgriParcel:other:{number % 3000}"
    moment = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(at_s)) + f".{int(at_s % 1 * 1000):03d}Z"
    entity = {"id": ref, "type": "AgriParcel", "name": {"type": "Text", "value": "x", "metadata": {}},
              "dateModified": {"type": "DateTime", "value": moment, "metadata": {}}}  # fmt: skip
    return json.dumps({"subscriptionId": "0" * 24, "data": [entity]}).encode()


def _target(broker: str) -> str:
    found = httpx.get(f"{broker}/v2/subscriptions", headers=TENANT, trust_env=False).json()
    return str(next(one for one in found if one["description"].startswith("headland/"))["notification"]["http"]["url"])


def _fields(broker: str) -> list[str]:
    url = f"{broker}/v2/entities?type=AgriParcel&options=keyValues&limit=100"
    return [one["id"] for one in httpx.get(url, headers=TENANT, trust_env=False).json()]


def _read_s(broker: str, fields: list[str]) -> float:
    """Return the CPU of reading one entity as the console would for each it is told of."""
    begin_s = time.process_time()
    with httpx.Client(headers=TENANT, trust_env=False) as client:
        for number in range(200):
            client.get(f"{broker}/v2/entities/{fields[number % len(fields)]}?type=AgriParcel").json()
    return (time.process_time() - begin_s) / 200


def _cpu(process: psutil.Process, work: Any) -> tuple[float, float]:
    """Return CPU in percent of a core while ``work`` runs, and for how long it did."""
    before, begin_s = sum(process.cpu_times()[:2]), time.monotonic()
    work()
    took_s = time.monotonic() - begin_s
    return (sum(process.cpu_times()[:2]) - before) / took_s * 100, took_s
