"""The MQTT connection to the broker: one object, its own network thread, no queue for later.

``MqttLink`` never queues a publication made while it is offline: what is late is refused, not delivered
(a QoS 1 publish handed to paho offline would arrive whenever the broker returns).
"""

from __future__ import annotations

import contextlib
import socket
import ssl
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, cast
from urllib.parse import urlsplit

import paho.mqtt.client as paho
from paho.mqtt.enums import CallbackAPIVersion
from paho.mqtt.reasoncodes import ReasonCode

from backend_clients.edge.buffered import BufferedClient, Publication

OnMessage = Callable[[str, bytes, bool], None]
OnLink = Callable[["LinkState", str], None]

KEEPALIVE_S = 5  # presence only; freshness is judged from heartbeats, which are faster
RECONNECT_MIN_S, RECONNECT_MAX_S = 1, 4


class LinkState(StrEnum):
    """State of the connection to the broker."""

    CONNECTING = "connecting"
    UP = "up"
    DOWN = "down"


@dataclass(frozen=True, slots=True)
class Will:
    """What the broker says for us when we vanish."""

    topic: str
    payload: bytes


@dataclass(frozen=True, slots=True)
class BrokerUrl:
    """A parsed ``mqtt://[user:password@]host:port`` or ``mqtts://`` address."""

    host: str
    port: int
    is_tls: bool
    username: str | None
    password: str | None

    @classmethod
    def parse(cls, url: str) -> BrokerUrl:
        """Parse ``url``; raises ``ValueError`` with what is wrong."""
        parts = urlsplit(url)
        if parts.scheme not in ("mqtt", "mqtts") or not parts.hostname:
            raise ValueError(
                f"broker address {parts.scheme}://{parts.hostname}: use mqtt://host:port or mqtts://host:port"
            )
        is_tls = parts.scheme == "mqtts"
        port = parts.port or (8883 if is_tls else 1883)
        return cls(parts.hostname, port, is_tls, parts.username, parts.password)

    def __str__(self) -> str:
        return f"{'mqtts' if self.is_tls else 'mqtt'}://{self.host}:{self.port}"  # never the credentials


class MqttLink:
    """One connection with its subscriptions, re-made for ever until ``stop``.

    ``on_message(topic, payload, retained)`` and ``on_link(state, text)`` are called on the network
    thread; whatever they raise is swallowed into ``on_fault`` so that the thread survives any payload.

    Args:
        url: broker address, see ``BrokerUrl``.
        client_id: unique at the broker.
        subscriptions: (filter, QoS) pairs, subscribed again at each connect.
        ca_file: PEM file to trust for ``mqtts``; the system's store otherwise.
    """

    def __init__(
        self,
        url: str,
        client_id: str,
        *,
        subscriptions: Sequence[tuple[str, int]] = (),
        on_message: OnMessage | None = None,
        on_link: OnLink | None = None,
        on_fault: Callable[[Exception], None] | None = None,
        will: Will | None = None,
        ca_file: str | None = None,
    ) -> None:
        self.url = BrokerUrl.parse(url)
        self._client_id = client_id
        self._subscriptions = list(subscriptions)
        self._on_message, self._on_link, self._on_fault = on_message, on_link, on_fault
        self._state = LinkState.CONNECTING
        self._has_subscribed = False
        self._lock = threading.Lock()
        # A clean session: the broker keeps nothing for us while we are away, so nothing arrives late.
        self._client = BufferedClient(
            CallbackAPIVersion.VERSION2, client_id=client_id, protocol=paho.MQTTv311, clean_session=True
        )
        self._client.max_queued_messages_set(2000)
        self._client.max_inflight_messages_set(200)
        self._client.reconnect_delay_set(RECONNECT_MIN_S, RECONNECT_MAX_S)
        if self.url.username:
            self._client.username_pw_set(self.url.username, self.url.password)
        if self.url.is_tls:
            self._client.tls_set_context(ssl.create_default_context(cafile=ca_file))
        if will is not None:
            self._client.will_set(will.topic, will.payload, qos=1, retain=True)
        self._client.on_socket_open = _without_delay
        self._client.on_connect = self._connected
        self._client.on_disconnect = self._disconnected
        self._client.on_connect_fail = self._connect_failed
        self._client.on_message = self._received
        self._client.on_publication = self._published

    @property
    def state(self) -> LinkState:
        """The present state; safe from any thread."""
        return self._state

    @property
    def is_up(self) -> bool:
        """Whether a publication made now would be sent."""
        return self._state is LinkState.UP and self._client.is_connected()

    @property
    def is_alive(self) -> bool:
        """Whether the network thread runs; an error inside paho itself can end it without a word."""
        name = f"paho-mqtt-client-{self._client_id}"
        return any(t.name == name and t.is_alive() for t in threading.enumerate())

    def start(self) -> None:
        """Connect in the background and keep trying; also starts a network thread that has died."""
        self._client.connect_async(self.url.host, self.url.port, keepalive=KEEPALIVE_S)
        self._client.loop_start()

    def stop(self) -> None:
        """Disconnect and end the network thread; returns when it has ended."""
        self._client.disconnect()
        self._client.loop_stop()
        self._set(LinkState.DOWN, "stopped")

    def drop(self) -> None:
        """Vanish without a goodbye, as when the power goes: the broker will say our last will."""
        sock = cast(socket.socket | None, self._client.socket())
        if sock is not None:
            with contextlib.suppress(OSError):  # it may have gone by itself in this moment
                sock.shutdown(socket.SHUT_RDWR)
        self._client.loop_stop()
        self._set(LinkState.DOWN, "dropped")

    def publish(self, topic: str, payload: bytes, *, qos: int = 0, retain: bool = False) -> bool:
        """Send now or not at all; return whether it was handed to a live connection."""
        if not self.is_up:
            return False
        return self._client.publish(topic, payload, qos=qos, retain=retain).rc == paho.MQTT_ERR_SUCCESS

    def subscribe(self, topic_filter: str, qos: int) -> None:
        """Add a subscription, now and at each later connect."""
        with self._lock:
            self._subscriptions.append((topic_filter, qos))
            is_now = self._has_subscribed
        if is_now:
            self._client.subscribe(topic_filter, qos)

    def unsubscribe(self, topic_filter: str) -> None:
        """Take a subscription away, now and for each later connect."""
        with self._lock:
            self._subscriptions = [one for one in self._subscriptions if one[0] != topic_filter]
        if self.is_up:
            self._client.unsubscribe(topic_filter)

    def _connected(self, client: paho.Client, _data: Any, _flags: Any, reason: ReasonCode, _props: Any) -> None:
        if reason.is_failure:
            self._set(LinkState.DOWN, f"broker refused: {reason}")
            return
        with self._lock:  # one that is added from now on is subscribed by itself
            subscriptions = list(self._subscriptions)
            self._has_subscribed = True
        if subscriptions:
            client.subscribe(subscriptions)
        self._set(LinkState.UP, str(self.url))

    def _disconnected(self, _client: paho.Client, _data: Any, _flags: Any, reason: ReasonCode, _props: Any) -> None:
        with self._lock:
            self._has_subscribed = False
        self._set(LinkState.DOWN, str(reason))

    def _connect_failed(self, _client: paho.Client, _data: Any) -> None:
        self._set(LinkState.DOWN, f"no answer from {self.url}")

    def _received(self, _client: paho.Client, _data: Any, message: paho.MQTTMessage) -> None:
        self._hand_on(lambda: message.topic, bytes(message.payload), message.retain)

    def _published(self, publication: Publication) -> None:
        self._hand_on(publication.topic.decode, publication.payload, publication.is_retained)

    def _hand_on(self, topic: Callable[[], str], payload: bytes, is_retained: bool) -> None:
        if self._on_message is None:
            return
        try:
            self._on_message(topic(), payload, is_retained)  # a topic may be no text
        except Exception as error:  # noqa: BLE001 - an exception here would end paho's thread silently
            self._fault(error)

    def _set(self, state: LinkState, text: str) -> None:
        self._state = state
        if self._on_link is None:
            return
        try:
            self._on_link(state, text)
        except Exception as error:  # noqa: BLE001 - same boundary as above
            self._fault(error)

    def _fault(self, error: Exception) -> None:
        if self._on_fault is not None:
            with contextlib.suppress(Exception):  # nothing may reach paho's thread
                self._on_fault(error)


def _without_delay(_client: paho.Client, _data: Any, sock: Any) -> None:
    # Nagle would hold a small message back until the one before is acknowledged: 40 ms on Linux
    with contextlib.suppress(OSError, AttributeError):
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
