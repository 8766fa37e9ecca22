"""Notifications: which subscriptions a change concerns, and sending them while requests go on."""

from __future__ import annotations

import asyncio
import uuid
from collections.abc import Mapping
from dataclasses import replace

import httpx

from backend_clients.simulator.context_broker.entity import Entity, View, render
from backend_clients.simulator.context_broker.json_text import Json, write
from backend_clients.simulator.context_broker.store import Change, Store
from backend_clients.simulator.context_broker.subscription import Subscription
from backend_clients.simulator.context_broker.tenancy import Scope
from hmi.clock import Clock

MAX_UNDER_WAY = 64  # more wait their turn; Orion's thread pool is bounded too
MAX_WAITING = 10_000  # what comes then is lost, as when Orion's queue is full


class Notifier:
    """Sends notifications over HTTP, unordered, one attempt each.

    Args:
        clock: for throttling and time stamps.
        transport: test seam, as in httpx.
    """

    def __init__(self, clock: Clock, transport: httpx.AsyncBaseTransport | None = None) -> None:
        self._clock = clock
        # any certificate will do: this broker runs beside what it notifies
        self._client = httpx.AsyncClient(transport=transport, trust_env=False, follow_redirects=False, verify=False)  # noqa: S501
        self._turns = asyncio.Semaphore(MAX_UNDER_WAY)
        self._tasks: set[asyncio.Task[None]] = set()
        self.lost = 0

    def changed(self, store: Store, tenant: str, change: Change, correlator: str) -> None:
        """Start what a change sets off; returns at once."""
        for subscription in list(store.tenant(tenant).subscriptions.values()):
            alteration = self._alteration(subscription, change)
            if alteration and self._may_send(subscription):
                self._start(tenant, subscription, change, alteration, correlator)

    async def settle(self) -> None:
        """Wait until everything under way is sent or has failed."""
        while self._tasks:
            await asyncio.gather(*self._tasks, return_exceptions=True)

    async def close(self) -> None:
        """Give up what is under way."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await self._client.aclose()

    def _alteration(self, subscription: Subscription, change: Change) -> str:
        """Return the kind of alteration that fires the subscription, empty if none does."""
        rule, entity = subscription.rule, change.entity
        if not Scope("", subscription.paths).sees(entity.key.path) or not rule.selection.means(entity):
            return ""
        if change.kind != "entityUpdate":
            concerned = not rule.condition_attrs or not rule.condition_attrs.isdisjoint(change.touched)
            fires = change.kind in rule.alterations and (concerned or change.kind == "entityDelete")
            return change.kind if fires else ""
        really = change.touched if change.forced else change.changed
        if not rule.on_metadata and not change.forced:
            really -= change.only_metadata
        if "entityUpdate" in rule.alterations and _concerned(rule.condition_attrs, change.touched):
            return "entityUpdate"
        return "entityChange" if "entityChange" in rule.alterations and _concerned(rule.condition_attrs, really) else ""

    def _may_send(self, subscription: Subscription) -> bool:
        if subscription.state(self._clock.utc()) not in ("active", "oneshot"):
            return False
        now_s, last_s = self._clock.mono_s(), subscription.throttle_mono_s
        if last_s is not None and now_s - last_s < subscription.rule.throttling_s:
            return False
        subscription.throttle_mono_s = now_s
        if subscription.status == "oneshot":
            subscription.status = "inactive"
        return True

    def _start(self, tenant: str, subscription: Subscription, change: Change, alteration: str, correlator: str) -> None:
        if len(self._tasks) >= MAX_WAITING:
            self.lost += 1
            return
        subscription.times_sent += 1
        subscription.last_sent = self._clock.utc()
        request = self._request(tenant, subscription, change, alteration, correlator)
        task = asyncio.create_task(self._send(subscription, request), name=f"notify {subscription.id}")
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _request(
        self, tenant: str, subscription: Subscription, change: Change, alteration: str, correlator: str
    ) -> httpx.Request:
        rule = subscription.rule
        view = _view(subscription, change)
        shown = render(change.entity, view, alteration=alteration)
        if rule.covered and view.form == "normalized":
            shown = _covered(shown, change.entity, view)
        bare = rule.wire_format.startswith("simplified")
        body = shown if bare else {"subscriptionId": subscription.id, "data": [shown]}
        headers = {
            "User-Agent": "orion/4.3.0",
            "Fiware-Servicepath": change.entity.key.path,
            "Fiware-Correlator": f"{correlator or uuid.uuid4()}; cbnotif=1",
            "Ngsiv2-AttrsFormat": rule.wire_format,
            "Content-Type": "application/json; charset=utf-8",
            **({"Fiware-Service": tenant} if tenant else {}),
            **dict(rule.target.headers),
        }
        return self._client.build_request(
            "POST",
            rule.target.url,
            content=write(body),
            headers=headers,
            params=dict(rule.target.qs) or None,
            timeout=rule.target.timeout_s,
        )

    async def _send(self, subscription: Subscription, request: httpx.Request) -> None:
        async with self._turns:
            try:
                response = await self._client.send(request)
            except (httpx.HTTPError, OSError) as error:
                self._failed(subscription, f"{type(error).__name__}: {error}"[:200])
            else:
                self._answered(subscription, response.status_code)

    def _answered(self, subscription: Subscription, status: int) -> None:
        # any answer is a success to Orion, whatever its status
        subscription.last_success, subscription.last_success_code = self._clock.utc(), status
        subscription.fails_in_a_row = 0

    def _failed(self, subscription: Subscription, reason: str) -> None:
        subscription.last_failure, subscription.last_failure_reason = self._clock.utc(), reason
        subscription.fails_in_a_row += 1
        limit = subscription.rule.max_fails
        if limit and subscription.fails_in_a_row >= limit:
            subscription.status = "inactive"


def _concerned(wanted: frozenset[str], names: frozenset[str]) -> bool:
    return bool(names) and (not wanted or not wanted.isdisjoint(names))


def _view(subscription: Subscription, change: Change) -> View:
    view = subscription.rule.view
    if not subscription.rule.only_changed or change.kind != "entityUpdate":
        return view
    return replace(view, left_out=view.left_out | (change.entity.attributes.keys() - change.changed))


def _covered(shown: Mapping[str, Json], entity: Entity, view: View) -> dict[str, Json]:
    missing = [name for name in view.attrs if name != "*" and name not in shown and name not in entity.attributes]
    return {**shown, **{name: {"type": "None", "value": None, "metadata": {}} for name in missing}}
