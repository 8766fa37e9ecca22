"""Asks a planner: hand a wish in, look how far it is, take the path, cancel. Every answer is checked on arrival."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable
from typing import TypeVar

import httpx
from pydantic import ValidationError

from backend_clients.planner.messages import (
    MAX_ANSWER,
    MAX_REQUEST,
    PlanPath,
    PlanReport,
    PlanRequest,
    PlanState,
    ServiceInfo,
    Told,
    Wish,
    wish_sha256,
)
from backend_clients.service.connection import Call, Reply, Service, ServiceConnection
from backend_clients.service.errors import Gone, ServiceError, Unreadable

log = logging.getLogger(__name__)
FIRST_LOOK_S, LONGEST_LOOK_S = 0.1, 1.0
CANCEL_LIMIT_S = 3.0
T = TypeVar("T", bound=Told)
Progress = Callable[[float, str], None]
"""Called with a share, 0 to 1, and words, as the planner tells them."""


class PlanFailed(ServiceError):
    """The planner understood the wish and cannot plan it; ``text`` says why."""

    mend = "Change the wish as the planner says."

    def __init__(self, code: str, text: str, field: str = "") -> None:
        super().__init__(text)
        self.code, self.text, self.field = code, text, field


class TooSlow(ServiceError):
    """The planner answers, and had no plan in time."""

    mend = "Raise planner_timeout_s, or give the planner a faster machine."


class PlannerClient:
    """One planner service. Close it.

    Args:
        plan_limit_s: the longest a plan may take, from handing in to the path.
        transport, sleep, mono_s: test seams, see ``ServiceConnection``.
    """

    def __init__(
        self,
        service: Service,
        plan_limit_s: float,
        *,
        transport: httpx.AsyncBaseTransport | None = None,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        mono_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._connection = ServiceConnection(service, transport=transport, sleep=sleep, mono_s=mono_s)
        self._limit_s, self._sleep, self._mono_s = plan_limit_s, sleep, mono_s
        self._cancelling: set[asyncio.Task[None]] = set()
        self.timeout_s = service.timeout_s

    async def close(self) -> None:
        """Wait for cancels under way, a few seconds at most, and close all connections."""
        await asyncio.gather(*self._cancelling, return_exceptions=True)
        await self._connection.close()

    async def info(self) -> tuple[ServiceInfo, httpx.Headers]:
        """Return what the service says it is; raises ``ServiceError``."""
        reply = await self._connection.send(Call("GET", ""))
        return _read(ServiceInfo, reply), reply.headers

    async def path(self, wish: Wish, key: str, told: Progress = lambda _share, _words: None) -> PlanPath:
        """Return the planned path; cancelling this cancels the plan at the service too.

        Args:
            key: id of the plan, 1 to 64 letters, digits, - or _; sent twice it is one plan.
            told: hears how far it is.

        Raises:
            PlanFailed: the planner says it cannot be planned.
            TooSlow: it took longer than ``plan_limit_s``.
            ServiceError: the service failed, or answered for another wish.
        """
        sha256, begin_s, look_s = wish_sha256(wish), self._mono_s(), FIRST_LOOK_S
        body = PlanRequest(wish_sha256=sha256, wish=wish).model_dump_json().encode()
        try:
            call = Call("POST", "plans", headers={"Idempotency-Key": key}, body=body)
            report = await self._asked(call, sha256, key)
            while report.state in (PlanState.QUEUED, PlanState.RUNNING):
                told(report.progress, report.words)
                if self._mono_s() - begin_s + look_s > self._limit_s:
                    raise TooSlow(f"it had no plan after {self._limit_s:g} s")
                await self._sleep(look_s)
                look_s = min(look_s * 1.5, LONGEST_LOOK_S)
                report = await self._asked(Call("GET", f"plans/{key}"), sha256, key)
            return _ended(report)
        finally:
            # cancelled, failed, or ours now: the service need not go on with it. Its id is ours, so that this holds
            # for a wish whose answer never came, too
            self._give_up(key)

    async def _asked(self, call: Call, sha256: str, key: str) -> PlanReport:
        report = _read(PlanReport, await self._connection.send(call))
        if report.wish_sha256 != sha256 or report.id != key:
            raise Unreadable("the planner answered for another wish")
        return report

    def _give_up(self, plan_id: str) -> None:
        """Tell the service beside; nobody waits for it."""
        task = asyncio.get_running_loop().create_task(self._cancel(plan_id), name="planner-cancel")
        self._cancelling.add(task)
        task.add_done_callback(self._cancelling.discard)

    async def _cancel(self, plan_id: str) -> None:
        try:
            async with asyncio.timeout(CANCEL_LIMIT_S):
                await self._connection.send(Call("DELETE", f"plans/{plan_id}"))
        except (ServiceError, TimeoutError) as error:
            # the service gives old plans up by itself
            log.debug("the planner was not told that %s is not wanted any more: %s", plan_id, type(error).__name__)


def _ended(report: PlanReport) -> PlanPath:
    if report.state is PlanState.DONE and report.result is not None:
        return report.result
    if report.state is PlanState.FAILED and report.problem is not None:
        raise PlanFailed(report.problem.code, report.problem.text, report.problem.field)
    if report.state is PlanState.CANCELLED:
        raise Gone(410, "the plan was cancelled at the service")
    raise Unreadable(f"the planner says {report.state.value} without what belongs to it")


def _read(kind: type[T], reply: Reply) -> T:
    try:
        return kind.model_validate_json(reply.content)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False, include_context=False)[0]
        where = ".".join(str(part) for part in first["loc"])[:80]
        raise Unreadable(f"the answer is not what the format promises: {where} {first['msg']}"[:200]) from None


def limited(service: Service) -> Service:
    """Return the service with the sizes of this format."""
    return Service(service.url, service.token, service.ca, service.timeout_s, MAX_REQUEST, MAX_ANSWER, service.retry)
