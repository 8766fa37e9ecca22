"""Measures the round trip console - robot: one ping a second each, answered in the robot's heartbeat.

An unattended robot works on only while it hears these pings, so nobody but the console may send them.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable, Sequence
from typing import Protocol

from backend_clients.edge import messages_down as down
from backend_clients.edge.codec import encode
from backend_clients.edge.topics import Down, topic

PERIOD_S = 1.0
REMEMBERED = 5  # an answer later than this many pings is no measure of the link any more


class Publisher(Protocol):
    """Sends now or not at all."""

    def publish(self, topic: str, payload: bytes, *, qos: int = 0, retain: bool = False) -> bool:
        """Send now or not at all."""
        ...


class Pinger:
    """Sends pings spread over the second and takes the time of their answers."""

    def __init__(self, link: Publisher, mono_s: Callable[[], float]) -> None:
        self._link, self._mono_s = link, mono_s
        self._prefix = down.CONSOLE_NONCE + secrets.token_hex(4)
        self._number = 0
        self._due_s: dict[str, float] = {}
        self._sent: dict[str, dict[str, float]] = {}

    def ping_due(self, robots: Sequence[str]) -> None:
        """Ping those whose second is over; call every 50 ms."""
        now_s = self._mono_s()
        for gone in self._due_s.keys() - set(robots):
            del self._due_s[gone]
            self._sent.pop(gone, None)
        for index, robot in enumerate(robots):
            due_s = self._due_s.get(robot)
            if due_s is None:  # spread over the second, so that a thousand pings never leave at once
                self._due_s[robot] = now_s + (index % 20) / 20 * PERIOD_S
            elif now_s >= due_s:
                self._due_s[robot] = max(due_s + PERIOD_S, now_s)
                self._ping(robot, now_s)

    def answered(self, robot: str, nonce: str, received_s: float) -> float | None:
        """Return how long the answer took, in seconds; ``None`` for an unknown or repeated nonce."""
        sent_s = self._sent.get(robot, {}).pop(nonce, None)
        return None if sent_s is None else max(0.0, received_s - sent_s)

    def _ping(self, robot: str, now_s: float) -> None:
        self._number += 1
        nonce = f"{self._prefix}{self._number:x}"
        if self._link.publish(topic(robot, Down.PING), encode(down.Ping(robot=robot, nonce=nonce))):
            sent = self._sent.setdefault(robot, {})
            sent[nonce] = now_s
            if len(sent) > REMEMBERED:
                del sent[next(iter(sent))]
