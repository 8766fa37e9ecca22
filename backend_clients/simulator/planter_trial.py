"""A planter alone on a straight row, without network: how long each state takes, and what other machines would do."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from statistics import fmean

from backend_clients.edge import messages_down as down
from backend_clients.edge.messages_up import Datum
from backend_clients.simulator.config import RobotConfig
from backend_clients.simulator.crane import pose_for
from backend_clients.simulator.planter_rig import FAILS_NEVER, PlanterRig, Tuning
from backend_clients.simulator.planting_stops import BEHIND_M
from backend_clients.simulator.world import MAX_STEP_S, SimRobot
from hmi.clock import FakeClock

STEP_S, LONG_STEP_S = 0.05, 0.5
PING_S = 5.0
OVER_THE_LAST_SITE = (-7.0, 0.5, 1.7)
PUBLISHED_S = {
    "above-plant": 110.9,
    "dock": 54.7,
    "dock-waypoint": 43.7,
    "photo": 45.1,
    "on-ground": 32.7,
    "transport": 9.7,
    "map-site": 1.2,
    "drive": 22.1,
    "plant": 40.5,
    "transfer": 25.5,
    "drop": 15.5,
}
"""Seconds in each state of the published simulation: two machine moves, five attempts at planting."""
PUBLISHED_TOTAL_S = 403.5
PUBLISHED_WALL_SHARE = 419.0 / 450.5
"""Wall clock by the sum of the states' times, of the published experiment."""
ATTEMPTS = 5
SITES = range(1, 11)
"""Seeds of the sites over which the simulated times are averaged: one site alone says little of a state seen twice."""


@dataclass(slots=True)
class Trial:
    """What came out. ``times_s`` holds the published states only; ``wall_s`` is from the first move to the last."""

    times_s: dict[str, float] = field(default_factory=dict)
    wall_s: float = 0.0
    attempts: int = 0
    planted: int = 0
    moves: int = 0

    @property
    def total_s(self) -> float:
        """Sum of the times of all states."""
        return sum(self.times_s.values())

    @property
    def wall_share(self) -> float:
        """Wall clock by that sum; below 1 because some states run at the same time."""
        return self.wall_s / self.total_s if self.total_s else math.nan

    @property
    def trees_per_hour(self) -> float:
        """Trees planted in an hour."""
        return 3600 * self.planted / self.wall_s if self.wall_s else 0.0


def calibration(seed: int) -> Trial:
    """Return the published case on one site: two moves of the machine and five attempts, none of which fails."""
    return run_trial(FAILS_NEVER, seed=seed, attempts=ATTEMPTS)


def mean(trials: Sequence[Trial]) -> Trial:
    """Return the average of trials of the same case.

    Raises:
        ValueError: they have different numbers of moves or attempts.
    """
    first = trials[0]
    if any((one.moves, one.attempts) != (first.moves, first.attempts) for one in trials):
        raise ValueError("trials of different cases have no mean")
    return Trial(
        {state: fmean(one.times_s[state] for one in trials) for state in first.times_s},
        fmean(one.wall_s for one in trials),
        first.attempts,
        first.planted,
        first.moves,
    )


def run_trial(
    tuning: Tuning, *, seed: int = 1, attempts: int | None = None, hours: float = 24.0, is_hasty: bool = False
) -> Trial:
    """Let a planter work along a row until ``attempts`` are over or ``hours`` are.

    Its trays never end: somebody loads them in time. ``is_hasty`` takes longer steps while the machine stands; actions
    still end where they end inside a step.
    """
    clock = FakeClock()
    robot = SimRobot(_config(), clock, seed=seed)
    rig = PlanterRig(f"trial/{seed}", tuning)
    rig.crane.pose = pose_for(OVER_THE_LAST_SITE)
    robot.machine.rig = rig
    robot.boot = robot.power_up()
    _put_to_work(robot, row_m=200.0 if attempts is not None else 40.0 * hours + 200.0)
    trial, begun_s, end_s, next_ping_s = Trial(), math.inf, clock.mono_s() + hours * 3600, 0.0
    inside, spent = dict[str, int](), Counter[str]()
    while clock.mono_s() < end_s and robot.boot.brain.is_auto:
        if clock.mono_s() >= next_ping_s:
            robot.receive(down.Ping(robot=robot.config.id, nonce="console-t"))
            next_ping_s = clock.mono_s() + PING_S
            robot.machine.seedlings, robot.machine.soc = 67, 1.0
        span_s = _span_s(is_at_site=robot.boot.brain.work.is_at_site) if is_hasty else STEP_S
        clock.advance(span_s)
        robot.step(span_s)
        for event in robot.take_events():
            state = str(event.data.get("state", ""))
            if event.kind == "state_entered":
                inside[state] = event.mono_ms
                trial.moves += state == "drive"
                begun_s = min(begun_s, event.mono_ms / 1000) if state in PUBLISHED_S else begun_s
            elif event.kind == "state_left" and state in PUBLISHED_S:
                spent[state] += event.data["duration_ms"]
                trial.wall_s = event.mono_ms / 1000 - begun_s
            elif event.data.get("target"):
                trial.attempts += 1
                trial.planted += event.data["outcome"] == "done"
        if attempts is not None and trial.attempts >= attempts:
            break
    trial.times_s = {state: spent[state] / 1000 for state in PUBLISHED_S}
    return trial


def _span_s(*, is_at_site: bool) -> float:
    return LONG_STEP_S if is_at_site else MAX_STEP_S


def _config() -> RobotConfig:
    return RobotConfig("planter-01", "Planter", "unused", theta_rad=0.0, family="planter", soc=1.0)


def _put_to_work(robot: SimRobot, row_m: float) -> None:
    """Let it stand four metres before its first stop in a row that runs east."""
    assert robot.boot is not None
    brain, config = robot.boot.brain, robot.config
    mission = down.Mission(
        robot=config.id,
        mission_id="trial",
        revision=1,
        name="Trial",
        field_name="Trial",
        datum=Datum(lat_deg=config.datum_lat_deg, lon_deg=config.datum_lon_deg),
        width_m=4.0,
        area_m2=row_m * 4.0,
        parcel=[[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 0.0)]],
        segments=[down.Segment(kind="row", points=[(0.0, 0.0), (row_m, 0.0)], speed_mps=1.0, tool_on=True, row=1)],
    )
    brain.load(mission)
    assert brain.run is not None
    at_m = BEHIND_M
    robot.machine.base.put(at_m, 0.0, 0.0)
    brain.run.driven_m = at_m
    brain.run.stand_at(at_m, brain.place)
    brain.resume(is_supervised=False)
