"""The catalogue of alarm types, read from ``catalogue.toml`` beside this module."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from hmi.domain.alarm.priority import Priority
from hmi.domain.alarm.steady import Limit

SOURCE = Path(__file__).with_name("catalogue.toml")


@dataclass(frozen=True, slots=True)
class AlarmType:
    """What all alarms of one type have in common.

    Args:
        cause, consequence: what it means, and what happens if nobody acts.
        steps: what to do, in this order.
        who: who can do it.
        on_s, off_s: how long the condition lasts, and is gone, before it counts.
        follows_from: codes of types that this one is a consequence of.
        limit: of the measured value behind it, in ``unit``.
        suppressed_by: codes that, while they hold at the console, keep this type silent by design.
        is_robot_code: whether a robot may report it under this code.
        diagnosis: names of what a guided check looks at.
    """

    code: str
    title: str
    priority: Priority
    cause: str
    consequence: str
    steps: tuple[str, ...]
    who: str
    is_latching: bool = False
    on_s: float = 0.0
    off_s: float = 0.0
    follows_from: frozenset[str] = frozenset()
    limit: Limit | None = None
    unit: str = ""
    suppressed_by: frozenset[str] = frozenset()
    is_robot_code: bool = False
    diagnosis: tuple[str, ...] = ()


@cache
def catalogue() -> dict[str, AlarmType]:
    """Return all types by code.

    Raises:
        ValueError: an entry is incomplete, has a word that is not known, or follows from itself.
    """
    types = {code: _type(code, entry) for code, entry in tomllib.loads(SOURCE.read_text("utf-8")).items()}
    for one in types.values():
        if unknown := (one.follows_from | one.suppressed_by) - types.keys():
            raise ValueError(f"{one.code} names {sorted(unknown)}, which are not in the catalogue")
        if one.code in _all_causes(one.code, types):
            raise ValueError(f"{one.code} follows from itself")
    return types


def follows_from(code: str) -> frozenset[str]:
    """Return the codes that a type may follow from."""
    return catalogue()[code].follows_from


def _type(code: str, entry: dict[str, Any]) -> AlarmType:
    given = dict(entry)
    limit, deadband = given.pop("limit", None), given.pop("deadband", 0.0)
    try:
        return AlarmType(
            code=code,
            priority=Priority(given.pop("priority")),
            steps=tuple(given.pop("steps")),
            is_latching=given.pop("latching", False),
            follows_from=frozenset(given.pop("follows_from", ())),
            suppressed_by=frozenset(given.pop("suppressed_by", ())),
            is_robot_code=given.pop("robot", False),
            diagnosis=tuple(given.pop("diagnosis", ())),
            limit=None if limit is None else Limit(limit, deadband),
            **given,
        )
    except (KeyError, TypeError) as error:
        raise ValueError(f"{code} in {SOURCE.name} is wrong: {error}") from error


def _all_causes(code: str, types: dict[str, AlarmType]) -> set[str]:
    found: set[str] = set()
    waiting = list(types[code].follows_from)
    while waiting:
        cause = waiting.pop()
        if cause not in found:
            found.add(cause)
            waiting.extend(types[cause].follows_from)
    return found
