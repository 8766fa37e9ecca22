"""The simulated planter beside the published one: seconds in each state, for two moves and five attempts.

The table goes to stderr, the figure to stdout as every bench does.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

from backend_clients.simulator.planter_trial import (
    ATTEMPTS,
    PUBLISHED_S,
    PUBLISHED_TOTAL_S,
    PUBLISHED_WALL_SHARE,
    SITES,
    Trial,
    calibration,
    mean,
)


def run() -> Iterator[dict[str, Any]]:
    """Simulate the published case, print it beside the published figures, and say the total."""
    trials = [calibration(seed) for seed in SITES]
    trial, totals = mean(trials), [one.total_s for one in trials]
    print("\n".join(table(trial)), file=sys.stderr)
    yield {
        "name": "planter_total_s",
        "value": round(trial.total_s, 1),
        "unit": "s, sum of the states' times",
        "naive": PUBLISHED_TOTAL_S,
        "ratio": round(trial.total_s / PUBLISHED_TOTAL_S, 4),
        "conditions": f"{trial.moves} moves, {trial.attempts} attempts; naive is the published total; "
        f"wall clock / sum {trial.wall_share:.3f}, published {PUBLISHED_WALL_SHARE:.3f}; "
        f"mean of ten sites, {min(totals):.1f} to {max(totals):.1f} s",
    }


def table(trial: Trial) -> list[str]:
    """Return the lines of the table."""
    lines = [f"{'state':<16}{'published s':>12}{'simulated s':>12}{'difference':>12}"]
    for state, published_s in PUBLISHED_S.items():
        lines.append(_line(state, published_s, trial.times_s[state]))
    lines.append(_line("total", PUBLISHED_TOTAL_S, trial.total_s))
    lines.append(f"{'wall / sum':<16}{PUBLISHED_WALL_SHARE:>12.3f}{trial.wall_share:>12.3f}")
    lines.append(f"two moves of the machine, {ATTEMPTS} attempts; the published states sum up to 401.6 s, not 403.5 s")
    return lines


def _line(name: str, published_s: float, simulated_s: float) -> str:
    return f"{name:<16}{published_s:>12.1f}{simulated_s:>12.1f}{simulated_s / published_s - 1:>+12.1%}"


if __name__ == "__main__":
    import json

    for figure in run():
        print(json.dumps(figure))
