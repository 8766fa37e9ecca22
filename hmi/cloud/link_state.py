"""How the link to the cloud is: one state, one sentence, one thing to do."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from backend_clients.ngsi import errors as ngsi


class LinkState(StrEnum):
    """States a person is shown; only ``OK`` and ``SLOW`` deliver."""

    OFF = "off"
    CONNECTING = "connecting"
    OK = "ok"
    SLOW = "slow"
    UNREACHABLE = "unreachable"
    SILENT = "silent"
    UNTRUSTED = "untrusted"
    REFUSED = "refused"
    FAILING = "failing"
    BUSY = "busy"
    NOT_A_BROKER = "not_a_broker"
    OTHER_TENANT = "other_tenant"
    OTHER_CONSOLE = "other_console"


DELIVERS = frozenset({LinkState.OK, LinkState.SLOW})
NEEDS_ADMIN = frozenset(
    {LinkState.UNTRUSTED, LinkState.REFUSED, LinkState.NOT_A_BROKER, LinkState.OTHER_TENANT, LinkState.OTHER_CONSOLE}
)
"""States that no waiting mends."""


@dataclass(frozen=True, slots=True)
class Link:
    """How the link is now.

    Args:
        since_s: since when, on the console's monotonic clock.
        why: what the broker or the network said, for whoever mends it.
    """

    state: LinkState
    since_s: float
    why: str = ""
    mend: str = ""


def state_of(error: ngsi.NgsiError) -> LinkState:
    """Return what a failed call means for the link as a whole."""
    table: tuple[tuple[type[ngsi.NgsiError], LinkState], ...] = (
        (ngsi.Untrusted, LinkState.UNTRUSTED),
        (ngsi.NoAnswer, LinkState.SILENT),
        (ngsi.Unreachable, LinkState.UNREACHABLE),
        (ngsi.NoToken, LinkState.REFUSED),
        (ngsi.NotAllowed, LinkState.REFUSED),
        (ngsi.Overloaded, LinkState.BUSY),
        (ngsi.BrokerFailed, LinkState.FAILING),
    )
    return next((state for kind, state in table if isinstance(error, kind)), LinkState.NOT_A_BROKER)


def is_about_one(error: ngsi.NgsiError) -> bool:
    """Say whether an error is about the entity alone: the link is well, and no other try would help."""
    if isinstance(error, ngsi.BadInput):
        return True
    passing = ngsi.NotAllowed | ngsi.Overloaded | ngsi.BrokerFailed
    return isinstance(error, ngsi.BrokerRefused) and not isinstance(error, passing)
