"""Links to a planner and to a forecast in words: what is so, what it means."""

from __future__ import annotations

from hmi.presenters.cloud import Words

MEANS = {
    "planner": "Missions are planned on this server meanwhile.",
    "forecast": "The queue goes on with what is measured; it does not say meanwhile when weather is expected to clear.",
}
OFF = {
    "planner": Words("Not set", "Missions are planned on this server. HEADLAND_PLANNER_URL names a service.", "ok"),
    "forecast": Words("Not set", "HEADLAND_FORECAST_URL names a service.", "ok"),
}
OK = {
    "planner": "Plans come from it; each is checked here before it is used.",
    "forecast": "Says when weather that missions wait for is expected to clear. Starts go by what is measured.",
}
HEADS = {
    "connecting": ("Connecting", "watch"),
    "ok": ("Connected", "ok"),
    "slow": ("Connected, slow", "watch"),
    "unreachable": ("Not reachable", "bad"),
    "silent": ("Does not answer", "bad"),
    "untrusted": ("Its certificate is not trusted", "bad"),
    "refused": ("Does not let us in", "bad"),
    "failing": ("It fails", "bad"),
    "busy": ("Asks for fewer requests", "watch"),
    "narrow": ("Takes only small requests", "bad"),
    "not_understood": ("Its answers cannot be used", "bad"),
    "misset": ("Its settings cannot be used", "bad"),
}
"""By the values of ``hmi.service_link.LinkState``; a test holds the two together."""


def service_words(key: str, state: str) -> Words:
    """Return the words of one service, ``planner`` or ``forecast``, in a state."""
    if state == "off":
        return OFF[key]
    head, level = HEADS[state]
    return Words(head, OK[key] if state in ("ok", "slow") else MEANS[key], level)
