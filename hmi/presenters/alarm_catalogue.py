"""The catalogue of alarm types as a page of the documentation: ``docs/alarm_catalogue.md``."""

from __future__ import annotations

from collections.abc import Iterable

from hmi.domain.alarm.catalogue import AlarmType, catalogue
from hmi.domain.alarm.priority import Priority
from hmi.presenters.diagnosis import CHECKS
from hmi.presenters.scene import Scene

HEAD = """# Alarm types

Made from `hmi/domain/alarm/catalogue.toml` by `make alarm-catalogue`; do not edit this page.
How alarms live, who is told and how they are kept: [alarms.md](alarms.md).
"""
_LEVELS = {
    Priority.CRITICAL: "critical: somebody may be hurt, or everybody is blind",
    Priority.HIGH: "high: act within minutes",
    Priority.MEDIUM: "medium: act within half an hour",
    Priority.LOW: "low: in the next days",
}


def markdown() -> str:
    """Return the page: a table by priority, then each type with everything it says."""
    types = sorted(catalogue().values(), key=lambda one: (one.priority, one.code))
    table = ["| priority | type | title | who | stays until cleared |", "|---|---|---|---|---|"]
    table += [_row(one) for one in types]
    levels = [f"- {int(level)} {words}" for level, words in _LEVELS.items()]
    return "\n".join([HEAD, *levels, "", *table, "", *(line for one in types for line in _type(one, types))])


def _row(one: AlarmType) -> str:
    stays = "yes" if one.is_latching else ""
    return f"| {int(one.priority)} | [`{one.code}`](#{one.code}) | {one.title} | {one.who} | {stays} |"


def _type(one: AlarmType, types: Iterable[AlarmType]) -> list[str]:
    looks = [CHECKS[name](Scene(0.0, None)).text for name in one.diagnosis]
    causes = [other.code for other in types if one.code in other.follows_from]
    lines = [f"## {one.code}", f"**{one.title}**, priority {int(one.priority)}.", one.cause, one.consequence, ""]
    lines += [f"{number}. {step}." for number, step in enumerate(one.steps, 1)]
    lines += ["", f"- Who: {one.who}."]
    if one.limit is not None:
        back = f", back {one.limit.deadband:g} {one.unit} before it" if one.limit.deadband else ""
        lines.append(f"- Limit: {one.limit.at:g} {one.unit}{back}.")
    if one.on_s or one.off_s:
        lines.append(f"- Counts after {one.on_s:g} s, is gone after {one.off_s:g} s.")
    lines += _list("- Follows from", sorted(one.follows_from))
    lines += _list("- May cause", sorted(causes))
    lines += _list("- Says nothing during", sorted(one.suppressed_by))
    if looks:
        lines.append(f"- Guided check: {' '.join(looks)}")
    return [*lines, ""]


def _list(head: str, codes: list[str]) -> list[str]:
    return [f"{head}: {', '.join(f'`{code}`' for code in codes)}."] if codes else []
