"""What a robot said on the broker, beside what a screen shows of it."""

from __future__ import annotations

import json
from types import TracebackType
from typing import Any, Self
from urllib.parse import urlsplit

from paho.mqtt.client import Client, MQTTMessage
from paho.mqtt.enums import CallbackAPIVersion

from backend_clients.edge.topics import Up, topic


class Heard:
    """Collects ``(cross-track in m, wall clock in ms)`` of one robot's telemetry in ``values``."""

    def __init__(self, broker_url: str, robot: str) -> None:
        self.values: list[tuple[float, float]] = []
        self._address = urlsplit(broker_url)
        self._topic = topic(robot, Up.TELEMETRY)
        self._client = Client(CallbackAPIVersion.VERSION2)
        self._client.on_message = self._note

    def __enter__(self) -> Self:
        """Connect and listen."""
        self._client.connect(str(self._address.hostname), self._address.port or 1883)
        self._client.subscribe(self._topic)
        self._client.loop_start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Disconnect."""
        self._client.disconnect()
        self._client.loop_stop()

    def _note(self, _client: Client, _user: Any, message: MQTTMessage) -> None:
        body = json.loads(message.payload)
        if body.get("cross_track_m") is not None:
            self.values.append((body["cross_track_m"], body["wall_ms"]))
