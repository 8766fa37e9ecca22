"""A link to a service outside as Admin, Cloud shows it."""

from __future__ import annotations

from typing import Any

from hmi.clock import Clock
from hmi.presenters.services import service_words
from hmi.service_link import ServiceLink


def service_report(
    key: str, name: str, url: str, link: ServiceLink, clock: Clock, facts: list[tuple[str, str]]
) -> dict[str, Any]:
    """Return the row of one service.

    Args:
        facts: further lines, what and value.
    """
    words, last = service_words(key, link.state.value), link.last_error
    return {
        "key": key,
        "name": name,
        "state": link.state.value,
        "head": words.head,
        "text": words.text,
        "level": words.level,
        "why": link.why,
        "mend": link.mend,
        "for_s": round(clock.mono_s() - link.since_s, 1),
        "again_in_s": round(link.again_in_s, 1),
        "url": url,
        "heard_utc": None if link.heard_at is None else link.heard_at.isoformat(timespec="milliseconds"),
        "delay_s": None if link.median_s is None else round(link.median_s, 3),
        "skew_s": link.skew_s,
        "last_error": None if last is None else {"text": last.text, "utc": last.at.isoformat(timespec="milliseconds")},
        "facts": [list(fact) for fact in facts],
    }


def service_off(key: str, name: str) -> dict[str, Any]:
    """Return the row of a service that is not set."""
    words = service_words(key, "off")
    return {"key": key, "name": name, "state": "off", "head": words.head, "text": words.text, "level": words.level}
