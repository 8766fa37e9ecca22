"""The planter's times are the published ones, and another machine plants more."""

from __future__ import annotations

from dataclasses import replace

import pytest
from typer.testing import CliRunner

from backend_clients.simulator.planter_rig import FAILS_NEVER, Tuning
from backend_clients.simulator.planter_trial import (
    PUBLISHED_S,
    PUBLISHED_TOTAL_S,
    SITES,
    Trial,
    calibration,
    mean,
    run_trial,
)
from bench.planter_times import table
from hmi.cli.simulate import app

SIX_SITES = 24


@pytest.fixture(scope="module")
def trial() -> Trial:
    """Return the published case, the mean of ten sites: two moves, five attempts."""
    return mean([calibration(seed) for seed in SITES])


@pytest.fixture(scope="module")
def usual() -> Trial:
    """Return six sites of the planter as it is, without failures."""
    return run_trial(FAILS_NEVER, attempts=SIX_SITES, is_hasty=True)


@pytest.mark.long
def test_two_moves_and_five_attempts_take_the_published_time_in_each_state(trial: Trial) -> None:
    assert (trial.moves, trial.attempts, trial.planted) == (2, 5, 5)
    off = {state: trial.times_s[state] / published_s - 1 for state, published_s in PUBLISHED_S.items()}
    assert all(abs(share) <= 0.05 for share in off.values()), off
    assert trial.total_s == pytest.approx(PUBLISHED_TOTAL_S, rel=0.02)


@pytest.mark.long
def test_working_at_the_same_time_saves_what_was_published(trial: Trial) -> None:
    assert trial.wall_share == pytest.approx(0.93, abs=0.01)


@pytest.mark.long
def test_the_crane_takes_about_seventy_percent(trial: Trial) -> None:
    crane = ("above-plant", "dock", "dock-waypoint", "photo", "on-ground", "transport")
    assert sum(trial.times_s[one] for one in crane) / trial.total_s == pytest.approx(0.73, abs=0.04)


@pytest.mark.long
def test_the_table_names_every_state_beside_the_published_time(trial: Trial) -> None:
    text = "\n".join(table(trial))
    assert all(f"{state} " in text for state in PUBLISHED_S)
    assert f"{trial.total_s:.1f}" in text


@pytest.mark.slow
def test_the_same_seed_gives_the_same_trial() -> None:
    assert calibration(3).times_s == calibration(3).times_s


@pytest.mark.parametrize(
    "better",
    [
        replace(FAILS_NEVER, crane_speed=1.5),
        replace(FAILS_NEVER, seedlings_per_head=2),
        replace(FAILS_NEVER, docks_while_driving=True),
    ],
    ids=["faster crane", "two seedlings", "docks while driving"],
)
@pytest.mark.slow
def test_a_better_machine_plants_more_trees_an_hour(better: Tuning, usual: Trial) -> None:
    changed = run_trial(better, attempts=SIX_SITES, is_hasty=True)
    assert (changed.planted, usual.planted) == (SIX_SITES, SIX_SITES)
    assert changed.trees_per_hour > usual.trees_per_hour * 1.02


@pytest.mark.slow
def test_longer_steps_give_the_same_trees_an_hour() -> None:
    exact = run_trial(FAILS_NEVER, attempts=8)
    hasty = run_trial(FAILS_NEVER, attempts=8, is_hasty=True)
    assert hasty.wall_s == pytest.approx(exact.wall_s, rel=0.01)


@pytest.mark.slow
def test_the_command_line_compares_planters_with_the_one_there_is() -> None:
    result = CliRunner().invoke(app, ["planter-what-if", "--hours", "0.2", "--crane-speed", "2"])
    assert result.exit_code == 0, result.output
    lines = result.output.splitlines()
    assert [line.split("  ")[0] for line in lines] == [
        "as it is",
        "crane 2 times as fast",
        "2 seedlings per head",
        "takes a seedling while driving",
        "all three",
    ]
    assert "+0%" in lines[0]
    assert all("trees/h" in line and "times real time" in line for line in lines)
