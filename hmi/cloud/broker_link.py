"""How a context broker is asked again; apart from the client, which a console loads some seconds after its start."""

from __future__ import annotations

from hmi.clock import Clock
from hmi.service_link import Pauses, ServiceLink

PAUSES = Pauses(1.0, 30.0)  # robots are mirrored each second: a broker that is back is found soon
SLOW_S = 1.0


def broker_link(clock: Clock, jitter: float | None = None) -> ServiceLink:
    """Return the link to a context broker before anything is known of it."""
    return ServiceLink(clock, SLOW_S, PAUSES, jitter, name="context broker")
