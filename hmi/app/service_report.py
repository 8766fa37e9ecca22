"""A link to a service outside, the context broker among them, as Admin, Cloud and the alarms have it."""

from __future__ import annotations

from typing import Any

from hmi.clock import Clock
from hmi.domain.alarm.finding import MAX_TEXT, NOTHING, Finding, Findings
from hmi.presenters.cloud import Words, clock_words, words_of
from hmi.presenters.services import service_words
from hmi.service_link import NEEDS_PERSON, LinkState, ServiceLink


def link_report(link: ServiceLink, words: Words, clock: Clock) -> dict[str, Any]:
    """Return what is said of every link."""
    last = link.last_error
    again_s = 0.0 if link.state is LinkState.MISSET else link.again_in_s  # settings change with a restart only
    return {
        "state": link.state.value,
        "head": words.head,
        "text": words.text,
        "level": words.level,
        "why": link.why,
        "mend": link.mend,
        "for_s": round(clock.mono_s() - link.since_s, 1),
        "again_in_s": round(again_s, 1),
        "heard_utc": None if link.heard_at is None else link.heard_at.isoformat(timespec="milliseconds"),
        "delay_s": None if link.median_s is None else round(link.median_s, 3),
        "skew_s": link.skew_s,
        "clock": clock_words(link.skew_s),
        "last_error": None if last is None else {"text": last.text, "utc": last.at.isoformat(timespec="milliseconds")},
    }


def service_report(
    key: str, name: str, url: str, link: ServiceLink, clock: Clock, facts: list[tuple[str, str]]
) -> dict[str, Any]:
    """Return the row of one service.

    Args:
        facts: further lines, what and value.
    """
    shown = link_report(link, service_words(key, link.state.value), clock)
    return {"key": key, "name": name, "url": url, "facts": [list(fact) for fact in facts], **shown}


def service_off(key: str, name: str) -> dict[str, Any]:
    """Return the row of a service that is not set."""
    words = service_words(key, "off")
    return {"key": key, "name": name, "state": "off", "head": words.head, "text": words.text, "level": words.level}


def away_finding(code: str, link: ServiceLink) -> Findings:
    """Return what is wrong with a service that missions do without."""
    if link.is_well or link.state is LinkState.CONNECTING:
        return NOTHING
    return (Finding(code, link.why[:MAX_TEXT]),)


def clock_finding(name: str, link: ServiceLink) -> Findings:
    """Return that a service's clock is off, for the alarms; nothing while it agrees or is not known."""
    words = clock_words(link.skew_s)
    return (Finding("service-clock", f"{name}. {words}"[:MAX_TEXT]),) if words else NOTHING


def waits(count: int) -> str:
    """Return a sentence that says how many records wait here."""
    return "1 record waits." if count == 1 else f"{count} records wait."


def broker_findings(link: ServiceLink, waiting: int) -> Findings:
    """Return what is wrong with the way to a broker.

    Args:
        waiting: how many records wait here.
    """
    found, words = clock_finding("Context broker", link), words_of(link.state.value)
    text = f"{words.head}: {link.why}" if link.why else words.head
    if link.state in NEEDS_PERSON:
        return (Finding("cloud-refused", text[:MAX_TEXT], since_s=link.since_s), *found)
    if not link.is_well:
        return (Finding("cloud-away", f"{text.rstrip('.')}. {waits(waiting)}"[:MAX_TEXT]), *found)
    return found
