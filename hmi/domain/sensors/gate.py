"""May treatment go on in this weather? What is not known never counts as good."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from enum import StrEnum

from hmi.domain.sensors.limit import SensorLimit
from hmi.domain.sensors.quantity import Channel

NO_LIMITS = "No treatment limits are set."
WAITS_WORD = ": waits"


class GateState(StrEnum):
    """What the gate says."""

    OPEN = "open"
    WAITS = "waits"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class GateFact:
    """One limit and what is measured, worst at ``station_id``; ``is_ok`` is ``None`` where nothing fresh is known."""

    label: str
    text: str
    is_ok: bool | None
    station_id: str = ""


@dataclass(frozen=True, slots=True)
class Gate:
    """The whole answer; ``is_asked`` is whether any treatment limit is set."""

    state: GateState
    sentence: str
    facts: tuple[GateFact, ...] = ()
    is_asked: bool = True

    @property
    def reason(self) -> str:
        """Return what it waits for, to stand within another sentence."""
        return self.sentence.removesuffix(WAITS_WORD)


@dataclass(frozen=True, slots=True)
class Measured:
    """The newest value of a channel at one station; ``is_usable`` if it is recent and plausible."""

    channel: Channel
    value: float
    is_usable: bool
    station_id: str = ""


def gate(limits: Iterable[SensorLimit], measured: Sequence[Measured]) -> Gate:
    """Judge treatment by its limits; of several stations the worst value counts, silent ones count as not known.

    Args:
        measured: newest values of accepted stations.
    """
    asked = sorted((one for one in limits if one.is_treatment), key=lambda one: one.channel.order)
    if not asked:
        return Gate(GateState.OPEN, NO_LIMITS, is_asked=False)
    own = frozenset(one.channel for one in asked)
    judged = [_judge(one, measured, own) for one in asked if not _is_replaced(one, measured, own)]
    facts = tuple(fact for fact, _ in judged)
    over = [text for fact, text in judged if fact.is_ok is False]
    blind = [text for fact, text in judged if fact.is_ok is None]
    if over:
        return Gate(GateState.WAITS, over[0] + WAITS_WORD, facts)
    if blind:
        return Gate(GateState.UNKNOWN, blind[0] + WAITS_WORD, facts)
    return Gate(GateState.OPEN, "Weather is within the treatment limits.", facts)


def _judge(limit: SensorLimit, measured: Sequence[Measured], own: AbstractSet[Channel]) -> tuple[GateFact, str]:
    of_it = [one for one in measured if _is_for(limit, one.channel, own)]
    known = [one for one in of_it if one.is_usable]
    label = limit.channel.label
    if not known:
        why = "no station measures it" if not of_it else "nothing fresh is known"
        return GateFact(label, why.capitalize(), None), f"{label}: {why}"
    over = [one for one in known if limit.is_over(one.value)]
    worst = max(over or known, key=lambda one: _beyond(limit, one.value))
    text = limit.sentence(worst.value)
    return GateFact(label, text.removeprefix(f"{label} "), not over, worst.station_id), text


def _is_for(limit: SensorLimit, channel: Channel, own: AbstractSet[Channel]) -> bool:
    """Say whether a limit holds for a channel: one without a depth, for each that has no treatment limit of its own."""
    about = limit.channel
    return channel == about or (about.depth_cm is None and channel.quantity == about.quantity and channel not in own)


def _is_replaced(limit: SensorLimit, measured: Sequence[Measured], own: AbstractSet[Channel]) -> bool:
    """Say whether every depth that is measured has a treatment limit of its own beside this one."""
    of_it = [one.channel for one in measured if one.channel.quantity == limit.channel.quantity]
    return limit.channel.depth_cm is None and bool(of_it) and not any(_is_for(limit, one, own) for one in of_it)


def _beyond(limit: SensorLimit, value: float) -> float:
    """Return how far a value is beyond the limit, below zero within it."""
    above = value - limit.high if limit.high is not None else float("-inf")
    below = limit.low - value if limit.low is not None else float("-inf")
    return max(above, below)
