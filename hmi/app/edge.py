"""The robots' side of the console: live store, coordinator and sender, with everybody who listens to them."""

from __future__ import annotations

import secrets

from hmi.clock import Clock
from hmi.domain.command import Acknowledgement
from hmi.domain.freshness import TickRing
from hmi.ingest.coordinator import EdgeCoordinator, mqtt_link
from hmi.ingest.sender import EdgeSender
from hmi.settings import Settings
from hmi.store.fleet import FleetStore


class Edge:
    """Live state of the robots and the way to them. ``sender`` exists after ``start``."""

    def __init__(self, settings: Settings, clock: Clock) -> None:
        self.boot = secrets.token_hex(6)
        self.fleet = FleetStore(clock.mono_s, settings.farm_id)
        self.ticks = TickRing(self.boot, clock.mono_s, clock.utc)
        ca_file = str(settings.broker_ca) if settings.broker_ca else None
        link = mqtt_link(settings.broker_url, f"headland-console-{self.boot}", ca_file=ca_file)
        self.coordinator = EdgeCoordinator(link, self.fleet, clock)
        self.sender = EdgeSender(_Broker(self.coordinator), self.fleet.address)
        self.coordinator.listeners.on_ack.append(self._acknowledged)

    async def start(self) -> None:
        """Connect to the broker in the background."""
        await self.coordinator.start()

    async def stop(self) -> None:
        """Disconnect and close the robots' HTTP connections."""
        await self.coordinator.stop()
        await self.sender.close()

    def _acknowledged(self, answer: Acknowledgement) -> None:
        self.sender.acknowledged(answer)


class _Broker:
    """The coordinator's link as something that can be named before it is connected."""

    def __init__(self, coordinator: EdgeCoordinator) -> None:
        self._coordinator = coordinator

    def publish(self, topic: str, payload: bytes, *, qos: int = 0, retain: bool = False) -> bool:
        """Send now or not at all."""
        if not self._coordinator.is_broker_up:
            return False
        return self._coordinator.link.publish(topic, payload, qos=qos, retain=retain)
