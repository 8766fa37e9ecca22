"""What the stays in states add up to: by subsystem, by state, against the usual time; pure."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime

from hmi.domain.state_chart import Chart, ChartState
from hmi.domain.state_times import Interval

DRIFT = 0.25  # a mean this share beside the usual time is flagged
DRIFT_LEAST = 3  # stays; fewer say nothing


@dataclass(frozen=True, slots=True)
class Share:
    """Time of one subsystem, and its share of the states' time."""

    subsystem: str
    seconds: float
    share: float


@dataclass(frozen=True, slots=True)
class StateTime:
    """Stays in one state that ended; ``drift`` is how far the mean is from the usual time (0.1: a tenth longer)."""

    state: str
    label: str
    subsystem: str
    count: int
    total_s: float
    mean_s: float | None
    longest_s: float | None
    normal_s: float | None
    drift: float | None

    @property
    def is_drifting(self) -> bool:
        """Whether it takes clearly longer or shorter than usual."""
        return self.drift is not None and self.count >= DRIFT_LEAST and abs(self.drift) > DRIFT


@dataclass(frozen=True, slots=True)
class Sums:
    """What a span was spent on. ``total_s`` is the sum of states; regions run at once, so it may exceed ``wall_s``."""

    shares: tuple[Share, ...]
    states: tuple[StateTime, ...]
    total_s: float
    wall_s: float


def resting(chart: Chart | None) -> frozenset[str]:
    """Return the states in which a region only waits for its turn: its initial one, where that has no usual time."""
    if chart is None:
        return frozenset()
    kinds = {one.id: one.kind for one in chart.states}
    return frozenset(
        one.id
        for one in chart.states
        if one.is_initial and one.normal_s is None and one.parent is not None and kinds.get(one.parent) == "region"
    )


def add_up(stays: Iterable[Interval], chart: Chart | None, start: datetime, end: datetime) -> Sums:
    """Return sums of the innermost states in a span; where a region rests, its time counts for no subsystem."""
    leaves = [one for one in stays if one.is_leaf and one.seconds(start, end) > 0]
    rests = resting(chart)
    known = {one.id: one for one in chart.states} if chart else {}
    by_subsystem: dict[str, float] = defaultdict(float)
    for one in leaves:
        if one.state not in rests:
            by_subsystem[one.subsystem] += one.seconds(start, end)
    total_s = sum(by_subsystem.values())
    shares = [Share(name, s, s / total_s) for name, s in by_subsystem.items()]
    by_state: dict[str, list[Interval]] = defaultdict(list)
    for one in leaves:
        by_state[one.state].append(one)
    states = [_state_time(same, known.get(state), start, end) for state, same in by_state.items()]
    return Sums(
        tuple(sorted(shares, key=lambda one: -one.seconds)),
        tuple(sorted(states, key=lambda one: -one.total_s)),
        total_s,
        max(0.0, (end - start).total_seconds()),
    )


def _state_time(same: Sequence[Interval], known: ChartState | None, start: datetime, end: datetime) -> StateTime:
    # a guessed stay has no length of its own
    lengths = [(one.end - one.start).total_seconds() for one in same if one.end is not None and not one.is_guessed]
    mean_s = sum(lengths) / len(lengths) if lengths else None
    normal_s = known.normal_s if known else None
    return StateTime(
        same[0].state,
        same[0].label,
        same[0].subsystem,
        len(lengths),
        sum(one.seconds(start, end) for one in same),
        mean_s,
        max(lengths, default=None),
        normal_s,
        mean_s / normal_s - 1 if mean_s is not None and normal_s else None,
    )
