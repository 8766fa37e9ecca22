"""Runs a mission to its end without network, as fast as the processor allows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import mission_hash
from backend_clients.errors import Refused
from backend_clients.simulator.config import RobotConfig
from backend_clients.simulator.world import SimRobot
from hmi.clock import FakeClock

STEP_S = 0.1
PULSE_S = 1.0
MAX_DURATION_S = 72 * 3600.0


@dataclass(frozen=True, slots=True)
class Sample:
    """One moment of a simulated mission; ``t_s`` counts from the start command."""

    t_s: float
    telemetry: up.Telemetry
    state: up.State
    events: tuple[up.Event, ...]

    def __iter__(self) -> Iterator[object]:
        return iter((self.t_s, self.telemetry, self.state, self.events))


def simulate_mission(
    mission: down.Mission,
    seed: int = 1,
    *,
    robot: RobotConfig | None = None,
    clock: FakeClock | None = None,
    sample_s: float = 1.0,
    max_duration_s: float = MAX_DURATION_S,
) -> Iterator[Sample]:
    """Yield samples each ``sample_s`` until the mission is done or cannot go on.

    Events come with the sample that follows them. The last sample shows how it ended.

    Args:
        mission: its ``robot`` names the machine.
        robot: identity and start; by default it stands at the first point of the path with a full battery.
        clock: set it to the wall time at which the mission shall have begun; it is moved on.

    Raises:
        Refused: the robot did not take or start the mission.
    """
    clock = clock or FakeClock()
    machine = SimRobot(robot or _at_start(mission), clock, seed=seed)
    begin_s = clock.mono_s()
    _start(machine, mission)
    events: list[up.Event] = []
    next_sample_s = next_pulse_s = 0.0
    seq = 10
    while True:
        boot = machine.boot
        assert boot is not None
        t_s = clock.mono_s() - begin_s
        events += [boot.reporter.event(happening) for happening in machine.take_events()]
        is_over = not boot.brain.is_auto or t_s >= max_duration_s
        if t_s >= next_sample_s - 1e-9 or is_over:
            yield Sample(t_s, boot.reporter.telemetry(), boot.reporter.state(), tuple(events))
            events.clear()
            next_sample_s += sample_s
        if is_over:
            return
        if t_s >= next_pulse_s:
            seq += 1
            challenge = boot.reporter.heartbeat().challenge
            pulse = down.OperatorHeartbeat(robot=mission.robot, lease_token=1, lease_seq=seq, challenge=challenge)
            machine.receive(pulse)
            next_pulse_s += PULSE_S
        clock.advance(STEP_S)
        machine.step(STEP_S)


def _at_start(mission: down.Mission) -> RobotConfig:
    x_m, y_m = mission.home or mission.segments[0].points[0]
    return RobotConfig(
        mission.robot,
        mission.robot,
        "unused",
        datum_lat_deg=mission.datum.lat_deg,
        datum_lon_deg=mission.datum.lon_deg,
        x_m=x_m,
        y_m=y_m,
        soc=1.0,
    )


def _start(machine: SimRobot, mission: down.Mission) -> None:
    assert machine.boot is not None
    start = down.Command(
        robot=mission.robot,
        command_id="simulated-start",
        action="start",
        by="simulation",
        lease_token=1,
        lease_seq=1,
        challenge=machine.boot.reporter.heartbeat().challenge,
        mission_id=mission.mission_id,
        mission_sha256=mission_hash(mission),
    )
    for order in (mission, start):
        answer = machine.receive(order)
        if answer is None or answer.outcome != "accepted":
            raise Refused(answer.code if answer else "no_answer", answer.text if answer else "No answer.")
