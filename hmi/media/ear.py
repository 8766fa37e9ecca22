"""Listens to robots only while somebody looks at a picture: a message that nobody sees costs nothing."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Protocol

log = logging.getLogger(__name__)
GRACE_S = 20.0  # a page that is loaded again or changes to another robot finds everything still there


class Subscriber(Protocol):
    """The part of ``MqttLink`` that this needs."""

    def subscribe(self, topic_filter: str, qos: int) -> None:
        """Add a subscription."""

    def unsubscribe(self, topic_filter: str) -> None:
        """Take a subscription away."""


class Ear:
    """Open while somebody looks, and ``GRACE_S`` longer. Times are on the own monotonic clock."""

    def __init__(self, link: Subscriber, subscriptions: Sequence[tuple[str, int]]) -> None:
        self._link, self._subscriptions = link, list(subscriptions)
        self._seen_s: float | None = None

    @property
    def is_open(self) -> bool:
        """Whether robots are listened to."""
        return self._seen_s is not None

    def look(self, now_s: float) -> None:
        """Somebody looks now; what is retained at the broker comes at once."""
        if self._seen_s is None:
            for topic_filter, qos in self._subscriptions:
                self._link.subscribe(topic_filter, qos)
            log.info("somebody looks: listening to robots")
        self._seen_s = now_s

    def rest(self, now_s: float) -> bool:
        """Nobody looks now; return whether this was the moment to close."""
        if self._seen_s is None or now_s - self._seen_s < GRACE_S:
            return False
        self._seen_s = None
        for topic_filter, _ in self._subscriptions:
            self._link.unsubscribe(topic_filter)
        log.info("nobody looks: not listening to robots")
        return True
