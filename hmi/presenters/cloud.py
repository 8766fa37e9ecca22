"""The link to the cloud in words: what is so, what it means, what to do."""

from __future__ import annotations

from typing import NamedTuple

CLOCK_OFF_S = 10.0  # Orion and its proxies keep time within a second; from here on records do not fit together

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
    "narrow": Words("Takes only small requests", MEND, "bad"),
    "untrusted": Words("Its certificate is not trusted", MEND, "bad"),
    "refused": Words("Does not let us in", MEND, "bad"),
    "not_understood": Words("No context broker answers there", MEND, "bad"),
    "misset": Words("Its settings cannot be used", MEND, "bad"),
    "other_tenant": Words("The tenant is not ours, or was emptied", MEND, "bad"),
    "other_console": Words("Another console keeps this farm there", MEND, "bad"),
}
"""By the values of ``hmi.service_link.LinkState``; a test holds the two together."""
PARTLY = Words("Connected, but not everything goes up", "Something failed in this program. The rest goes up.", "bad")
PARTLY_MEND = "Tell whoever looks after this program what it says; the log has the details."


def words_of(state: str) -> Words:
    """Return the words of a state."""
    return WORDS[state]


def clock_words(skew_s: float | None) -> str:
    """Return a sentence about a service's clock that is off, empty while it agrees or is not known.

    Args:
        skew_s: how far it is ahead of ours, seconds.
    """
    if skew_s is None or abs(skew_s) < CLOCK_OFF_S:
        return ""
    way = "ahead of" if skew_s > 0 else "behind"
    return f"Its clock is {_span(abs(skew_s))} {way} this server's."


def _span(seconds: float) -> str:
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.0f} h"
