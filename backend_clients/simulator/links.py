"""Connections of simulated robots to the broker: one each, or one for many."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Protocol

from backend_clients.edge.mqtt import LinkState, MqttLink, OnLink, OnMessage, Will
from backend_clients.edge.topics import Down, topic

FAST = frozenset({Down.DRIVE, Down.JOG, Down.OPERATOR, Down.PING})
"""Orders at QoS 0: only the newest counts."""


class RobotLink(Protocol):
    """What one robot says and hears on the broker."""

    @property
    def is_up(self) -> bool:
        """Whether a publication made now would be sent."""
        ...

    def start(self) -> None:
        """Connect and keep trying."""
        ...

    def stop(self) -> None:
        """Leave."""
        ...

    def drop(self) -> None:
        """Vanish without a goodbye."""
        ...

    def publish(self, topic: str, payload: bytes, *, qos: int = 0, retain: bool = False) -> bool:
        """Send now or not at all; return whether it was handed to a live connection."""
        ...


LinkMaker = Callable[[str, str, OnMessage, OnLink, Will], RobotLink]
"""Makes a link from robot id, client id, two listeners and a last will."""


def orders_for(robot_id: str) -> list[tuple[str, int]]:
    """Return the topics a robot listens to, each with its QoS."""
    return [(topic(robot_id, kind), 0 if kind in FAST else 1) for kind in Down]


def own_links(broker_url: str) -> LinkMaker:
    """Give every robot a connection of its own, with its last will."""

    def make(robot_id: str, client_id: str, on_message: OnMessage, on_link: OnLink, will: Will) -> RobotLink:
        return MqttLink(
            broker_url,
            client_id,
            subscriptions=orders_for(robot_id),
            on_message=on_message,
            on_link=on_link,
            will=will,
        )

    return make


class SharedLink:
    """One connection for many robots. It carries no last wills: a connection has one, and these are many.

    Args:
        robot_ids: all that will ever use it.
    """

    def __init__(self, broker_url: str, client_id: str, robot_ids: Sequence[str]) -> None:
        self._members: dict[str, Member] = {}
        self._lock = threading.Lock()
        self._is_started = False
        self.link = MqttLink(
            broker_url,
            client_id,
            subscriptions=[one for robot_id in robot_ids for one in orders_for(robot_id)],
            on_message=self._heard,
            on_link=self._changed,
        )

    def make(self, robot_id: str, _client_id: str, on_message: OnMessage, on_link: OnLink, _will: Will) -> RobotLink:
        """Return the link of one robot; a ``LinkMaker``."""
        return Member(self, robot_id, on_message, on_link)

    def join(self, member: Member) -> None:
        """Let a robot take part; the first one connects."""
        with self._lock:
            self._members[member.robot_id] = member
            is_first, self._is_started = not self._is_started, True
        if is_first:
            self.link.start()
        elif self.link.is_up:
            member.on_link(LinkState.UP, "shared")

    def leave(self, member: Member) -> None:
        """Let a robot go; the last one disconnects."""
        with self._lock:
            if self._members.get(member.robot_id) is member:
                del self._members[member.robot_id]
            is_last = self._is_started and not self._members
            self._is_started = self._is_started and not is_last
        if is_last:
            self.link.stop()

    def _heard(self, name: str, payload: bytes, is_retained: bool) -> None:
        parts = name.split("/")
        member = self._members.get(parts[2]) if len(parts) > 2 else None
        if member is not None:
            member.on_message(name, payload, is_retained)

    def _changed(self, state: LinkState, text: str) -> None:
        for member in list(self._members.values()):
            member.on_link(state, text)


class Member:
    """One robot's part of a ``SharedLink``."""

    def __init__(self, shared: SharedLink, robot_id: str, on_message: OnMessage, on_link: OnLink) -> None:
        self._shared, self.robot_id, self.on_message, self.on_link = shared, robot_id, on_message, on_link

    @property
    def is_up(self) -> bool:
        """Whether the shared connection stands."""
        return self._shared.link.is_up

    def start(self) -> None:
        """Take part."""
        self._shared.join(self)

    def stop(self) -> None:
        """Leave."""
        self._shared.leave(self)

    def drop(self) -> None:
        """Leave; there is no last will to be said."""
        self._shared.leave(self)

    def publish(self, topic: str, payload: bytes, *, qos: int = 0, retain: bool = False) -> bool:
        """Send now or not at all."""
        return self._shared.link.publish(topic, payload, qos=qos, retain=retain)
