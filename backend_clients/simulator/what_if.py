"""What another planter would plant in an hour: the same simulator with one thing changed at a time."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

from backend_clients.simulator.planter_rig import Tuning
from backend_clients.simulator.planter_trial import run_trial


@dataclass(frozen=True, slots=True)
class WhatIf:
    """One run: what was changed, trees an hour, and how much faster than real time it ran."""

    name: str
    tuning: Tuning
    trees_per_hour: float
    planted: int
    attempts: int
    times_faster: float


def variants(base: Tuning, crane_speed: float, seedlings_per_head: int) -> list[tuple[str, Tuning]]:
    """Return the machine as it is, each change alone, and all of them together."""
    everything = replace(base, crane_speed=crane_speed, seedlings_per_head=seedlings_per_head, docks_while_driving=True)
    return [
        ("as it is", base),
        (f"crane {crane_speed:g} times as fast", replace(base, crane_speed=crane_speed)),
        (f"{seedlings_per_head} seedlings per head", replace(base, seedlings_per_head=seedlings_per_head)),
        ("takes a seedling while driving", replace(base, docks_while_driving=True)),
        ("all three", everything),
    ]


def compare(
    *, crane_speed: float = 1.5, seedlings_per_head: int = 2, hours: float = 8.0, seed: int = 1
) -> Iterator[WhatIf]:
    """Run each variant for ``hours`` of its own time on the same sites."""
    for name, tuning in variants(Tuning(), crane_speed, seedlings_per_head):
        begun_s = time.perf_counter()
        trial = run_trial(tuning, seed=seed, hours=hours, is_hasty=True)
        took_s = max(time.perf_counter() - begun_s, 1e-6)
        yield WhatIf(name, tuning, trial.trees_per_hour, trial.planted, trial.attempts, hours * 3600 / took_s)
