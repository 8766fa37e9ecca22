"""STOP by the robot's own HTTP, beside MQTT and without the broker."""

from __future__ import annotations

import asyncio
import logging
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from backend_clients.edge import messages_up as up
from backend_clients.edge.http import RobotHttp
from backend_clients.errors import ClientError, Refused
from hmi.domain.stop import StopAnswer, StopAttempt
from hmi.stop_gateway.registry import RobotEntry
from hmi.stop_gateway.wire import stop_message

MAX_REPEATS_AT_ONCE = 3  # of eight connections a robot has: a new press never waits behind old ones
MAX_POLLS_AT_ONCE = 32  # over all robots
_log = logging.getLogger("headland.stop")


@dataclass(frozen=True, slots=True)
class HttpEvents:
    """Where results go, all called on the loop.

    ``on_answer(attempt, answer, left_s)``: the robot answered a copy that left at ``left_s``.
    ``on_safety(robot_id, message)``: the robot answered a question, ``None`` if it did not.
    """

    on_answer: Callable[[StopAttempt, up.Ack | StopAnswer, float], None]
    on_safety: Callable[[str, up.Safety | None], None]


class HttpPath:
    """One HTTP client per registered robot, made before it is needed: the first press must not wait for it."""

    def __init__(self, events: HttpEvents) -> None:
        self._events = events
        self._clients: dict[str, tuple[tuple[str, str], RobotHttp]] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        self._sending: Counter[str] = Counter()
        self._polling: set[str] = set()

    def follow(self, robots: dict[str, RobotEntry]) -> None:
        """Make, replace and close clients after a change of the registry."""
        wanted = {r.id: (r.http_url, r.token or "") for r in robots.values() if r.http_url}
        for robot_id, (address, client) in list(self._clients.items()):
            if wanted.get(robot_id) != address:
                del self._clients[robot_id]
                self._spawn(client.close(), f"close {robot_id}")
        for robot_id, address in wanted.items():
            if robot_id not in self._clients:
                try:
                    self._clients[robot_id] = (address, RobotHttp(robot_id, *address))
                except Exception:  # noqa: BLE001 - what is wrong with one robot must not keep STOP from the others
                    _log.exception("%s cannot be reached by HTTP", robot_id)

    def has(self, robot_id: str) -> bool:
        """Say whether the robot has an HTTP address."""
        return robot_id in self._clients

    def send(self, attempt: StopAttempt, left_s: float) -> None:
        """Start one copy; a repeat is left out while enough of them still wait for an answer."""
        known = self._clients.get(attempt.robot_id)
        if known is None or (attempt.count > 0 and self._sending[attempt.robot_id] >= MAX_REPEATS_AT_ONCE):
            return
        self._sending[attempt.robot_id] += 1
        self._spawn(self._stop(known[1], attempt, left_s), f"stop {attempt.robot_id}")

    def ask(self, robot_id: str) -> None:
        """Ask for the safety state, one question at a time for each robot."""
        known = self._clients.get(robot_id)
        if known is None or robot_id in self._polling or len(self._polling) >= MAX_POLLS_AT_ONCE:
            return
        self._polling.add(robot_id)
        self._spawn(self._safety(known[1]), f"ask {robot_id}")

    async def close(self) -> None:
        """End what is under way and close all connections."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await asyncio.gather(*(client.close() for _, client in self._clients.values()), return_exceptions=True)

    async def _stop(self, client: RobotHttp, attempt: StopAttempt, left_s: float) -> None:
        try:
            self._events.on_answer(attempt, await client.stop(stop_message(attempt)), left_s)
        except Refused as error:
            self._events.on_answer(attempt, StopAnswer(False, error.code, error.text), left_s)
        except ClientError:
            pass  # the next copy goes in 0.2 s; silence is what the limits are for
        finally:
            self._sending[attempt.robot_id] -= 1

    async def _safety(self, client: RobotHttp) -> None:
        try:
            answer: up.Safety | None = await client.safety()
        except ClientError:
            answer = None
        finally:
            self._polling.discard(client.robot)
        self._events.on_safety(client.robot, answer)

    def _spawn(self, work: object, name: str) -> None:
        task = asyncio.ensure_future(work)  # type: ignore[call-overload]
        task.set_name(name)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
