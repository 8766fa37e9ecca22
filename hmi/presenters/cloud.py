"""The link to the cloud in words: what is so, what it means, what to do."""

from __future__ import annotations

from typing import NamedTuple

KEPT = "Everything is kept here and goes up when it is back. Robots and STOP do not need it."
MEND = "Nothing goes up until this is mended. It is kept here."


class Words(NamedTuple):
    """A heading and one sentence; ``level`` is ``ok``, ``watch`` or ``bad``."""

    head: str
    text: str
    level: str


WORDS = {
    "off": Words("No cloud is set", "Set HEADLAND_CLOUD_URL to the address of a context broker.", "ok"),
    "connecting": Words("Connecting", "Not reached yet since the start.", "watch"),
    "ok": Words("Connected", "Robots, missions and alarms go up as they happen.", "ok"),
    "slow": Words("Connected, slow", "The cloud takes more than a second to answer.", "watch"),
    "unreachable": Words("Not reachable", KEPT, "bad"),
    "silent": Words("Takes requests, does not answer", KEPT, "bad"),
    "failing": Words("Its broker fails", KEPT, "bad"),
    "busy": Words("Asks for fewer requests", KEPT, "watch"),
    "untrusted": Words("Its certificate is not trusted", MEND, "bad"),
    "refused": Words("Does not let us in", MEND, "bad"),
    "not_a_broker": Words("No context broker answers there", MEND, "bad"),
    "other_tenant": Words("The tenant is not ours, or was emptied", MEND, "bad"),
    "other_console": Words("Another console keeps this farm there", MEND, "bad"),
}
"""By the values of ``hmi.cloud.link_state.LinkState``; a test holds the two together."""


def words_of(state: str) -> Words:
    """Return the words of a state."""
    return WORDS[state]
