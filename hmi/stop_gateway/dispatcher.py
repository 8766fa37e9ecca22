"""STOP from a press to a confirmed standstill: sends, repeats, listens, and never gives up by itself."""

from __future__ import annotations

import asyncio
import logging
import math
import secrets
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

from backend_clients.edge import messages_up as up
from hmi.clock import Clock
from hmi.domain.stop import STRANGER_HEARD_S, StopAnswer, StopAttempt
from hmi.domain.stop_book import MAX_STRANGERS, StopBook
from hmi.domain.stop_token import StopToken
from hmi.stop_gateway.errors import TooManyRobots
from hmi.stop_gateway.http_path import HttpEvents, HttpPath
from hmi.stop_gateway.registry import Registry, RobotEntry
from hmi.stop_gateway.watch import RobotWatch
from hmi.stop_gateway.wire import BrokerWire, Heard, LinkChanged, answer_of, report_of

MAX_AT_ONCE = 8  # copies of different presses for one robot in one round; the least sent go first
POLL_S = 0.2  # the robot's HTTP safety state while a press is not confirmed
POLL_IF_OLDER_S = 0.3  # no question while MQTT brings the answer at 5 to 10 Hz
KEEP_S, KEEP_IF_OLDER_S = 0.5, 0.7  # of a stopped robot: a report counts 2 s, and lines of large fleets come at 1 Hz
ASK_S, ASK_MAX_S = 1.0, 8.0  # signs of life by HTTP from robots that are silent on MQTT
PING_S = (0.9, 1.5)  # jittered: the robot echoes one nonce a heartbeat, and the console measures too
LISTED_S = 5.0  # whoever a browser's last ``hb`` listed is sent to, also if he was dropped from the list since
LONGEST_WAIT_S = 0.1

_log = logging.getLogger("headland.stop")

Changed = Callable[[list[StopAttempt]], None]


class StopDispatcher:
    """All presses of the farm and the two paths to its robots.

    Args:
        on_changed: told every attempt whose state, times or paths moved on; must not block.
    """

    def __init__(
        self, clock: Clock, registry: Registry, on_changed: Changed, broker_url: str, *, broker_ca: str | None = None
    ) -> None:
        self._clock = clock
        self._on_changed = on_changed
        self.registry = registry
        self.book = StopBook()
        self.watch = RobotWatch()
        self.wire = BrokerWire(broker_url, self._hear, ca_file=broker_ca)
        self._http = HttpPath(HttpEvents(self._answered_by_http, self._safety_by_http))
        self._wake = asyncio.Event()
        self._ask_at: dict[str, float] = {}
        self._ask_pause: dict[str, float] = {}
        self._pings: dict[str, tuple[str, float]] = {}
        self._left: dict[str, RobotEntry] = {}

    # -- browsers ---------------------------------------------------------------------------------------

    def press(self, stop_id: str, robots: Sequence[str] | str, token: StopToken) -> list[dict[str, Any]]:
        """Send STOP to ``robots`` (or ``"all"``) at once, on every path; return the steps.

        Raises:
            TooManyRobots: it names only robots that nobody knows, and the gateway keeps enough of those.
        """
        now_s = self._clock.mono_s()
        utc = self._clock.utc()
        attempts, known = [], self._known()
        asked = self._everyone(now_s, LISTED_S) if isinstance(robots, str) else dict.fromkeys(robots)
        for robot_id in self._admitted(asked):
            speed = self.watch.speed_mps(robot_id, now_s)
            target = replace(self.registry.target(robot_id), is_stranger=robot_id not in known)
            attempts.append(
                self.book.press(
                    stop_id,
                    target,
                    token.who,
                    token.device_name,
                    now_s=now_s,
                    utc=utc,
                    speed_mps=speed,
                    user_id=token.user_id,
                )
            )
        for attempt in attempts:
            if attempt.is_open:
                self._send(attempt, now_s)
        self._wake.set()
        self._on_changed([self._newest(attempt) for attempt in attempts])
        return self.book.steps(now_s, stop_id)

    def steps(self, stop_id: str | None = None) -> list[dict[str, Any]]:
        """Return the steps of one press, or of all that are not reset."""
        return self.book.steps(self._clock.mono_s(), stop_id)

    def heartbeat(self) -> dict[str, Any]:
        """Return the robots of the ``hb`` frame: whom ``all`` means."""
        now_s = self._clock.mono_s()
        names = {robot_id: entry.name or robot_id for robot_id, entry in self.registry.robots.items()}
        for attempt in self.book.attempts():
            names.setdefault(attempt.robot_id, attempt.target.name)
        for robot_id in self._everyone(now_s):
            if robot_id not in names:
                names[robot_id] = self.registry.target(robot_id).name
        return {robot_id: self.watch.line(robot_id, name, now_s) for robot_id, name in names.items()}

    def _everyone(self, now_s: float, more_s: float = 0.0) -> list[str]:
        """Return what ``all`` means: the registered robots, whoever else was heard lately, and who has an open press.

        Before the first list it means whoever was heard. A browser expects an answer from every robot of ``hb``:
        one that is listed there and not sent to would stay NOT CONFIRMED for good.
        """
        pressed = [attempt.robot_id for attempt in self.book.attempts()]
        registered = self.registry.robots
        if not self.registry.is_known:
            return list(dict.fromkeys([*self.watch.known(), *pressed]))
        listed = [r for r in self.watch.lately(now_s, STRANGER_HEARD_S) if r not in registered]
        more = [r for r in self.watch.lately(now_s, STRANGER_HEARD_S + more_s) if r not in registered]
        # whoever is listed now goes before who was dropped: together they may be more than are kept
        return list(dict.fromkeys([*registered, *listed[:MAX_STRANGERS], *more[:MAX_STRANGERS], *pressed]))

    def _admitted(self, robots: Iterable[str]) -> list[str]:
        asked = list(robots)
        known = self._known()
        admitted = [robot_id for robot_id in asked if self.book.admits(robot_id, known)]
        if asked and not admitted:
            raise TooManyRobots(f"Nobody knows {asked[0]}, and the gateway keeps too many such robots already.")
        return admitted

    def _known(self) -> set[str]:
        return {*self.registry.robots, *self.watch.known()}

    def _newest(self, attempt: StopAttempt) -> StopAttempt:
        for other in self.book.attempts_at(attempt.robot_id):
            if other.stop_id == attempt.stop_id:
                return other
        return attempt

    # -- time -------------------------------------------------------------------------------------------

    async def run(self) -> None:
        """Repeat, let limits run out, ask silent robots; until cancelled."""
        while True:
            now_s = self._clock.mono_s()
            self._changed(self.book.tick(now_s))
            self._send_due(now_s)
            self._ask(now_s)
            self._wake.clear()
            next_s = self.book.next_due_s()
            wait_s = LONGEST_WAIT_S if next_s is None else min(max(next_s - now_s, 0.005), LONGEST_WAIT_S)
            try:
                await asyncio.wait_for(self._wake.wait(), wait_s)
            except TimeoutError:
                continue

    async def ping(self) -> None:
        """Measure the round trip to every robot, for ever."""
        low_s, high_s = PING_S
        while True:
            await asyncio.sleep(low_s + (high_s - low_s) * secrets.randbelow(1000) / 1000)
            nonce = f"stop-{secrets.token_hex(6)}"
            for robot_id in list(self.registry.robots)[:100]:  # a round trip is shown, not relied on
                if self.watch.of(robot_id).heard_s is not None and self.wire.ping(robot_id, nonce):
                    self._pings[robot_id] = (nonce, self._clock.mono_s())

    async def close(self) -> None:
        """Close the HTTP connections; the broker connection is closed by its owner."""
        await self._http.close()

    def restore(self, attempts: list[StopAttempt]) -> None:
        """Go on with the presses of before a restart, at once."""
        self.book.restore(attempts)
        self._wake.set()

    async def refresh(self) -> bool:
        """Follow the console's files; return whether the robots changed."""
        self._changed(self.book.forget_strangers(self._known(), self._clock.mono_s()))
        before = self.registry.robots
        if not await asyncio.to_thread(self.registry.refresh):
            return False
        # a robot that was taken out of the list may still drive: its STOP goes on, on both paths, until it answers
        self._left = {**self._left, **before}
        self._left = {a.robot_id: self._left[a.robot_id] for a in self.book.attempts() if a.robot_id in self._left}
        self._http.follow({**self._left, **self.registry.robots})
        return True

    def _send_due(self, now_s: float) -> None:
        by_robot: dict[str, list[StopAttempt]] = defaultdict(list)
        for attempt in self.book.due(now_s):
            by_robot[attempt.robot_id].append(attempt)
        for attempts in by_robot.values():
            for attempt in sorted(attempts, key=lambda a: a.count)[:MAX_AT_ONCE]:
                self._send(attempt, now_s)

    def _send(self, attempt: StopAttempt, now_s: float) -> None:
        by_mqtt = False
        try:
            by_mqtt = self.wire.send(attempt)
            self._http.send(attempt, now_s)
        except Exception:  # noqa: BLE001 - one robot that cannot be sent to must not keep STOP from the others
            _log.exception("STOP could not be handed to a path of %s", attempt.robot_id)
        self.book.sent(attempt, now_s, by_mqtt=by_mqtt)

    def _ask(self, now_s: float) -> None:
        attempts = self.book.attempts()
        pressed = {attempt.robot_id for attempt in attempts}
        unsure = {attempt.robot_id for attempt in attempts if attempt.wants_sending}
        for robot_id in {*self.registry.robots, *pressed}:
            if not self._http.has(robot_id) or now_s < self._ask_at.get(robot_id, 0.0):
                continue
            heard = self.watch.of(robot_id)
            report_age_s = math.inf if heard.report_s is None else now_s - heard.report_s
            if robot_id in unsure:
                if report_age_s > POLL_IF_OLDER_S:
                    self._ask_at[robot_id] = now_s + POLL_S
                    self._http.ask(robot_id)
            elif robot_id in pressed:
                if report_age_s > KEEP_IF_OLDER_S:
                    self._ask_at[robot_id] = now_s + self._ask_pause.get(robot_id, KEEP_S)
                    self._http.ask(robot_id)
            elif heard.heard_s is None or heard.via == "http" or now_s - heard.heard_s > ASK_S:
                self._ask_at[robot_id] = now_s + self._ask_pause.get(robot_id, ASK_S)
                self._http.ask(robot_id)

    # -- robots -----------------------------------------------------------------------------------------

    def _hear(self, batch: list[Heard]) -> None:
        now_s = self._clock.mono_s()
        for message in batch:
            match message:
                case up.Ack():
                    self._heard(message.robot, now_s)
                    if message.kind == "stop":
                        self._changed(self.book.answered(message.ref, message.robot, answer_of(message), now_s))
                case up.Safety():
                    self._heard(message.robot, now_s)
                    self._reported(message, now_s)
                case up.Heartbeat():
                    self._heard(message.robot, now_s)
                    self._echoed(message, now_s)
                case up.Presence() if message.online:
                    self.book.returned(message.robot, now_s)
                    self._wake.set()
                case LinkChanged(is_up=True):
                    self.book.path_returned(now_s)
                    self._wake.set()

    def _heard(self, robot_id: str, now_s: float, via: str = "mqtt") -> None:
        if self.watch.heard(robot_id, now_s, via):
            self.book.returned(robot_id, now_s)
            self._wake.set()

    def _reported(self, safety: up.Safety, now_s: float) -> None:
        report = report_of(safety)
        self.watch.reported(safety.robot, report, now_s)
        self._changed(self.book.reported(safety.robot, report, now_s))

    def _echoed(self, heartbeat: up.Heartbeat, now_s: float) -> None:
        nonce, sent_s = self._pings.get(heartbeat.robot, ("", 0.0))
        if nonce and heartbeat.echo_nonce == nonce:
            del self._pings[heartbeat.robot]
            self.watch.measured(heartbeat.robot, max(0.0, now_s - sent_s - heartbeat.echo_held_ms / 1000), now_s)

    def _answered_by_http(self, attempt: StopAttempt, ack: up.Ack | StopAnswer, left_s: float) -> None:
        now_s = self._clock.mono_s()
        self.book.carried_by_http(attempt.stop_id, attempt.robot_id, left_s)
        if isinstance(ack, up.Ack):
            self._heard(attempt.robot_id, now_s, "http")
            ack = answer_of(ack)
        self._changed(self.book.answered(attempt.stop_id, attempt.robot_id, ack, now_s))

    def _safety_by_http(self, robot_id: str, safety: up.Safety | None) -> None:
        now_s = self._clock.mono_s()
        if safety is None:
            self._ask_pause[robot_id] = min(self._ask_pause.get(robot_id, ASK_S) * 2, ASK_MAX_S)
            return
        self._ask_pause.pop(robot_id, None)
        self._heard(robot_id, now_s, "http")
        self._reported(safety, now_s)

    def _changed(self, attempts: list[StopAttempt]) -> None:
        if attempts:
            self._wake.set()
            self._on_changed(attempts)
