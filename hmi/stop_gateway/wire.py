"""The gateway's own broker connections: what robots say, handed to the loop in batches.

There are two: one for STOP and its acknowledgements, one for heartbeats and safety states, so that a press and
its answer never queue behind the traffic of a large fleet. Payloads are decoded on the network threads, one hop
to the loop per batch, so that a burst costs the loop one callback.
"""

from __future__ import annotations

import asyncio
import secrets
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import decode, encode
from backend_clients.edge.mqtt import LinkState, MqttLink, OnLink
from backend_clients.edge.topics import Down, Up, every_robot, topic
from hmi.domain.stop import SafetyReport, StopAnswer, StopAttempt

MAX_WAITING = 20_000  # a loop this far behind needs the newest, not all; acknowledgements are kept
_ANSWERS = {Up.ACK: 1, Up.PRESENCE: 1}
_TRAFFIC = {Up.HEARTBEAT: 0, Up.SAFETY: 1}


@dataclass(frozen=True, slots=True)
class LinkChanged:
    """The broker came or went."""

    is_up: bool
    text: str


Heard = up.Header | LinkChanged


class BrokerWire:
    """MQTT for STOP.

    Args:
        url: broker address.
        on_batch: called on the loop with messages in the order they came.
        ca_file: PEM file to trust for ``mqtts``.
    """

    def __init__(self, url: str, on_batch: Callable[[list[Heard]], None], *, ca_file: str | None = None) -> None:
        self._on_batch = on_batch
        self._loop: asyncio.AbstractEventLoop | None = None
        self._waiting: deque[Heard] = deque()
        self._is_hopping = False
        self.faults = 0
        self._orders = self._link(url, "", _ANSWERS, self._link_changed, ca_file)
        self._traffic = self._link(url, "-watch", _TRAFFIC, None, ca_file)

    @property
    def is_up(self) -> bool:
        """Whether a STOP published now would be sent, and its acknowledgement heard."""
        return self._orders.is_up and self._orders.is_alive

    def start(self) -> None:
        """Connect in the background; must be called on the loop."""
        self._loop = asyncio.get_running_loop()
        self._orders.start()
        self._traffic.start()

    def look_after(self) -> int:
        """Start network threads that have died again; return how many had."""
        dead = [link for link in (self._orders, self._traffic) if not link.is_alive]
        for link in dead:
            link.start()
        self.faults += len(dead)
        return len(dead)

    def stop(self) -> None:
        """Disconnect; blocks up to two reconnect pauses."""
        self._orders.stop()
        self._traffic.stop()

    def send(self, attempt: StopAttempt) -> bool:
        """Publish one copy of STOP; return whether it left."""
        return self._orders.publish(topic(attempt.robot_id, Down.STOP), encode(stop_message(attempt)), qos=1)

    def ping(self, robot_id: str, nonce: str) -> bool:
        """Ask a robot to echo ``nonce`` in its next heartbeat."""
        return self._traffic.publish(topic(robot_id, Down.PING), encode(down.Ping(robot=robot_id, nonce=nonce)))

    def _link(
        self, url: str, suffix: str, topics: dict[Up, int], on_link: OnLink | None, ca_file: str | None
    ) -> MqttLink:
        return MqttLink(
            url,
            f"headland-stop{suffix}-{secrets.token_hex(6)}",  # random: a second gateway must not throw the first out
            subscriptions=[(every_robot(kind), qos) for kind, qos in topics.items()],
            on_message=self._received,
            on_link=on_link,
            on_fault=self._faulted,
            ca_file=ca_file,
        )

    def _received(self, name: str, payload: bytes, retained: bool) -> None:
        _, message = decode(name, payload)  # on paho's thread; what it raises ends in _faulted
        if retained or not isinstance(message, up.Header):
            return  # retained is the past: nobody was heard
        self._hand_over(message)

    def _link_changed(self, state: LinkState, text: str) -> None:
        self._hand_over(LinkChanged(state is LinkState.UP, text))

    def _faulted(self, _error: Exception) -> None:
        self.faults += 1

    def _hand_over(self, item: Heard) -> None:
        if len(self._waiting) > MAX_WAITING and not isinstance(item, up.Ack):
            return
        self._waiting.append(item)
        if not self._is_hopping and self._loop is not None and not self._loop.is_closed():
            self._is_hopping = True
            self._loop.call_soon_threadsafe(self._drain)

    def _drain(self) -> None:
        self._is_hopping = False  # before the batch is taken: a message in between asks for another hop
        batch: list[Heard] = []
        while self._waiting:
            batch.append(self._waiting.popleft())
        if batch:
            self._on_batch(batch)


def stop_message(attempt: StopAttempt) -> down.Stop:
    """Return the edge contract's STOP for an attempt."""
    return down.Stop(robot=attempt.robot_id, stop_id=attempt.stop_id, by=attempt.by[:80], device=attempt.device[:80])


def answer_of(ack: up.Ack) -> StopAnswer:
    """Return a robot's acknowledgement as the rules read it."""
    return StopAnswer(ack.outcome == "accepted", ack.code, ack.text, ack.speed_mps, ack.boot, ack.mono_ms / 1000)


def report_of(safety: up.Safety) -> SafetyReport:
    """Return a robot's safety state as the rules read it."""
    return SafetyReport(
        boot=safety.boot,
        at_s=safety.mono_ms / 1000,
        latched=safety.latched,
        standstill=safety.standstill,
        tool_off=safety.tool_off,
        hardware_stop=safety.hardware_stop,
        speed_mps=safety.speed_mps,
        live=frozenset(press.stop_id for press in safety.presses if not press.is_reset),
        reset=frozenset(press.stop_id for press in safety.presses if press.is_reset),
        stopping_distance_m=safety.stopping_distance_m,
    )
