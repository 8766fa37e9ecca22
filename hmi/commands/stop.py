"""STOP by the console: the second path beside the gateway, with the same rules and the same steps.

It keeps nothing on disk: the gateway's outbox and the browser's own repeats survive a restart.
"""

from __future__ import annotations

import asyncio
import logging
import secrets
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, Protocol

from hmi.clock import Clock
from hmi.domain.command import Acknowledgement, OrderSender, StopOrder
from hmi.domain.ids import is_id
from hmi.domain.robot import SafetyState
from hmi.domain.stop import STRANGER_HEARD_S, SafetyReport, StopAnswer, StopAttempt, StopTarget
from hmi.domain.stop_book import MAX_STRANGERS, StopBook

IDLE_S = 0.1  # longest wait of the repeating task
SWEEP_S = 10.0  # how often presses at robots that nobody knows are looked through
FRESH_SPEED_S = 1.0  # an older speed proves nothing about how fast it is now
MAX_HTTP_REPEATS = 3  # copies waiting for one robot's HTTP answer before a repeat is left out

Pressed = Callable[[str, str, str], None]
MovedOn = Callable[[Sequence[str]], None]
log = logging.getLogger(__name__)


class StopRegistry(Protocol):
    """The registered robots as STOP needs them."""

    def stop_targets(self) -> Mapping[str, StopTarget]:
        """Return every registered robot by its id."""
        ...


class StopService:
    """Sends STOP, repeats it until standstill is confirmed, and tells each step.

    All methods belong to the event loop; ``press`` sends before it returns. Run ``run`` as a task.

    Args:
        sender: puts orders on the wire.
        clock: where the time comes from.
        registry: names and limits; ``all`` means its robots, those heard lately and those with an open press.
        on_press: told robot id, stop id and person of each new press, after it was sent: a stop revokes the lease.
        on_move: told the robots at which a press moved on, such as to NOT CONFIRMED, at once.
    """

    def __init__(
        self,
        sender: OrderSender,
        clock: Clock,
        registry: StopRegistry,
        *,
        on_press: Pressed = lambda _robot, _stop_id, _by: None,
        on_move: MovedOn = lambda _robots: None,
    ) -> None:
        self._sender = sender
        self._clock = clock
        self._registry = registry
        self._on_press = on_press
        self._on_move = on_move
        self._book = StopBook()
        self._wake = asyncio.Event()
        self._reports_s: dict[str, float] = {}  # when each robot's newest safety report was made
        self._boot = secrets.token_hex(4)
        self._speeds: dict[str, tuple[float, float]] = {}
        self._next_sweep_s = 0.0
        self._http: dict[str, set[asyncio.Task[None]]] = {}

    def press(
        self,
        stop_id: str,
        robots: Sequence[str] | Literal["all"],
        by: str,
        device: str,
        user_id: str | None = None,
    ) -> list[dict[str, Any]]:
        """Send STOP at once on every path; the same ``stop_id`` again sends one more copy.

        Returns the step of each robot; ids that break the id rule, and strangers beyond a limit, are left out.
        """
        targets = self._registry.stop_targets()
        asked = self._everyone(targets) if robots == "all" else [r for r in dict.fromkeys(robots) if is_id(r)]
        known = {*targets, *self._speeds}
        wanted = [robot_id for robot_id in asked if self._book.admits(robot_id, known)]
        now_s, utc = self._clock.mono_s(), self._clock.utc()
        fresh = [robot_id for robot_id in wanted if not self._book.has(stop_id, robot_id)]
        for robot_id in wanted:
            target = targets.get(robot_id) or replace(
                StopTarget.unregistered(robot_id), is_stranger=robot_id not in known
            )
            attempt = self._book.press(
                stop_id,
                target,
                by,
                device,
                now_s=now_s,
                utc=utc,
                speed_mps=self._speed(robot_id, now_s),
                user_id=user_id,
            )
            if attempt.is_open:
                self._send(attempt, now_s)
        self._wake.set()
        for robot_id in fresh:
            self._tell_pressed(robot_id, stop_id, by)
        return self.steps(stop_id)

    def steps(self, stop_id: str) -> list[dict[str, Any]]:
        """Return the step of every robot of one press; empty if it is not known here.

        ``boot`` is another one after a restart, when ages begin anew; ``safety_ms`` is the age of the newest safety
        report, ``None`` if there was none.
        """
        self.pulse()
        now_s = self._clock.mono_s()
        told = self._book.steps(now_s, stop_id)
        return [{**step, "boot": self._boot, "safety_ms": self._safety_ms(step["robot"], now_s)} for step in told]

    def attempts_at(self, robot_id: str) -> list[StopAttempt]:
        """Return the presses at a robot that are not reset, oldest first."""
        return self._book.attempts_at(robot_id)

    def open_at(self, stop_id: str) -> list[str]:
        """Return the robots at which a press is not reset."""
        return [attempt.robot_id for attempt in self._book.attempts() if attempt.stop_id == stop_id]

    def on_ack(self, ack: Acknowledgement) -> None:
        """Take a robot's answer; those to other orders are ignored."""
        if ack.kind != "stop":
            return
        at_s = ack.stamp.source_s if ack.stamp else None
        answer = StopAnswer(ack.is_accepted, ack.code, ack.text, ack.speed_mps, at_s=at_s)
        self._moved(self._book.answered(ack.ref, ack.robot_id, answer, self._clock.mono_s()))

    def on_safety(self, robot_id: str, safety: SafetyState) -> None:
        """Take what a robot's safety controller says."""
        now_s = self._clock.mono_s()
        self._speeds[robot_id] = (safety.stamp.received_s, safety.speed_mps)
        self._reports_s[robot_id] = safety.stamp.source_s
        self._moved(self._book.reported(robot_id, _report(safety), now_s))

    def on_return(self, robot_id: str) -> None:
        """The robot is back after it was silent: what it has not confirmed goes first."""
        self._book.returned(robot_id, self._clock.mono_s())
        self._wake.set()

    def pulse(self) -> None:
        """Send what is due and let limits run out; ``run`` does this in time."""
        now_s = self._clock.mono_s()
        self._moved(self._book.tick(now_s))
        if now_s >= self._next_sweep_s:
            self._next_sweep_s = now_s + SWEEP_S
            self._moved(self._book.forget_strangers({*self._registry.stop_targets(), *self._speeds}, now_s))
        for attempt in self._book.due(now_s):
            self._send(attempt, now_s)

    async def run(self) -> None:
        """Repeat until cancelled."""
        while True:
            try:
                self.pulse()
            except Exception:  # a fault in one round must not end STOP for all that come after it
                log.exception("a round of STOP failed; the next one comes")
                await asyncio.sleep(IDLE_S)
            self._wake.clear()
            due_s = self._book.next_due_s()
            now_s = self._clock.mono_s()
            wait_s = IDLE_S if due_s is None else min(max(due_s - now_s, 0.005), IDLE_S)
            try:
                await asyncio.wait_for(self._wake.wait(), wait_s if len(self._book) else None)
            except TimeoutError:
                continue

    async def close(self) -> None:
        """End the HTTP copies that are still under way."""
        tasks = [task for under_way in self._http.values() for task in under_way]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def _everyone(self, registered: Mapping[str, StopTarget]) -> list[str]:
        """Return what ``all`` means, as for the gateway: registered, heard lately, or with an open press."""
        now_s = self._clock.mono_s()
        heard = [robot_id for robot_id, (at_s, _) in self._speeds.items() if now_s - at_s <= STRANGER_HEARD_S]
        strangers = [robot_id for robot_id in heard if robot_id not in registered]
        pressed = [attempt.robot_id for attempt in self._book.attempts()]
        return list(dict.fromkeys([*registered, *strangers[:MAX_STRANGERS], *pressed]))

    def _send(self, attempt: StopAttempt, now_s: float) -> None:
        order = StopOrder(attempt.robot_id, attempt.stop_id, attempt.by, attempt.device)
        by_mqtt = False
        try:
            by_mqtt = self._sender.send(order)
        except Exception:  # one robot that cannot be sent to must not keep STOP from the others, nor its own HTTP
            log.exception("STOP could not be handed to the broker for %s", attempt.robot_id)
        under_way = self._http.setdefault(attempt.robot_id, set())
        if attempt.count == 0 or len(under_way) < MAX_HTTP_REPEATS:
            task = asyncio.get_running_loop().create_task(self._send_by_http(order, now_s), name="stop-http")
            under_way.add(task)
            task.add_done_callback(under_way.discard)
        self._book.sent(attempt, now_s, by_mqtt=by_mqtt)

    async def _send_by_http(self, order: StopOrder, left_s: float) -> None:
        ack = await self._sender.stop_by_http(order)
        if ack is not None:
            self._book.carried_by_http(order.stop_id, order.robot_id, left_s)
            self.on_ack(ack)

    def _tell_pressed(self, robot_id: str, stop_id: str, by: str) -> None:
        try:
            self._on_press(robot_id, stop_id, by)
        except Exception:  # as below; and the lease of the next robot ends all the same
            log.exception("somebody could not be told of a STOP at %s", robot_id)

    def _moved(self, attempts: Sequence[StopAttempt]) -> None:
        if not attempts:
            return
        try:
            self._on_move(list(dict.fromkeys(one.robot_id for one in attempts)))
        except Exception:  # whoever is told must never stand between a person and STOP
            log.exception("somebody could not be told how a STOP went on")

    def _safety_ms(self, robot_id: str, now_s: float) -> int | None:
        made_s = self._reports_s.get(robot_id)
        return None if made_s is None else max(0, round((now_s - made_s) * 1000))

    def _speed(self, robot_id: str, now_s: float) -> float | None:
        heard_s, speed_mps = self._speeds.get(robot_id, (float("-inf"), 0.0))
        return speed_mps if now_s - heard_s <= FRESH_SPEED_S else None


def _report(safety: SafetyState) -> SafetyReport:
    # the robot's time is already mapped on our clock, through reboots too: one order for all reports
    return SafetyReport(
        boot="",
        at_s=safety.stamp.source_s,
        latched=safety.latched,
        standstill=safety.standstill,
        tool_off=safety.tool_off,
        hardware_stop=safety.hardware_stop,
        speed_mps=safety.speed_mps,
        live=frozenset(press.stop_id for press in safety.presses if not press.is_reset),
        reset=frozenset(press.stop_id for press in safety.presses if press.is_reset),
        stopping_distance_m=safety.stopping_distance_m,
    )
