"""A console in miniature: sends a simulated robot well-made orders and lets fake time pass."""

from __future__ import annotations

import math
import uuid
from pathlib import Path
from typing import Any

import msgspec

from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import mission_hash
from backend_clients.edge.messages_up import Datum
from backend_clients.simulator.config import RobotConfig
from backend_clients.simulator.world import Boot, SimRobot
from hmi.clock import FakeClock

LAT, LON = 52.0, 5.0
STEP_S = 0.05
AT_START = {"datum_lat_deg": LAT, "datum_lon_deg": LON, "y_m": -2.0, "theta_rad": math.pi / 2}


def arc(cx: float, cy: float, radius: float, start: float, end: float) -> list[tuple[float, float]]:
    """Return points on a circle, angles in radians."""
    return [
        (cx + radius * math.cos(start + (end - start) * i / 24), cy + radius * math.sin(start + (end - start) * i / 24))
        for i in range(25)
    ]


def small_mission(robot: str = "weeder-01", *, rows: int = 3, length_m: float = 12.0, **more: Any) -> down.Mission:
    """Return a mission of parallel rows 3 m apart with half-circle turns; it begins at (0, -2)."""
    segments = [down.Segment(kind="approach", points=[(0.0, -2.0), (0.0, 0.0)], speed_mps=1.0)]
    for i in range(rows):
        x, is_up = 3.0 * i, i % 2 == 0
        ends = [(x, 0.0), (x, length_m)] if is_up else [(x, length_m), (x, 0.0)]
        segments.append(down.Segment(kind="row", points=ends, speed_mps=1.5, tool_on=True, row=i + 1))
        if i < rows - 1:
            turn = arc(x + 1.5, length_m if is_up else 0.0, 1.5, math.pi, 0.0 if is_up else 2 * math.pi)
            segments.append(down.Segment(kind="turn", points=turn, speed_mps=0.9))
    fields: dict[str, Any] = {
        "mission_id": "mission-1",
        "revision": 1,
        "name": "Three rows",
        "field_name": "Test field",
        "datum": Datum(lat_deg=LAT, lon_deg=LON),
        "width_m": 3.0,
        "area_m2": rows * length_m * 3.0,
        "parcel": [[(LON, LAT), (LON + 1e-3, LAT), (LON + 1e-3, LAT + 1e-3), (LON, LAT)]],
        "segments": segments,
    }
    return down.Mission(robot=robot, **{**fields, **more})


class Rig:
    """One robot, a fake clock, and somebody who holds the lease.

    Args:
        folder: the robot's disk; memory only without it.
    """

    def __init__(self, folder: Path | None = None, **config: Any) -> None:
        self.clock = FakeClock()
        self.config = RobotConfig("weeder-01", "Weeder 01", "secret", **{**AT_START, **config})
        self.folder = folder
        self.robot = SimRobot(self.config, self.clock, state_dir=folder)
        self.token, self.seq = 1, 0
        self.has_page = True
        self.events: list[Any] = []
        self._pulse_due_s = 0.0

    @property
    def boot(self) -> Boot:
        """The software now running."""
        assert self.robot.boot is not None
        return self.robot.boot

    def restart_process(self) -> None:
        """Begin again from what is on disk, as after a power cut."""
        self.robot = SimRobot(self.config, self.clock, state_dir=self.folder)

    def run(self, seconds: float, *, speed: float = 1.0) -> None:
        """Let time pass; the operator's page pulses once a second while it is open."""
        for _ in range(round(seconds / STEP_S)):
            if self.has_page and self.clock.mono_s() >= self._pulse_due_s and self.robot.boot is not None:
                self.pulse()
                self._pulse_due_s = self.clock.mono_s() + 1.0
            self.clock.advance(STEP_S)
            self.robot.step(STEP_S, speed)
            self.events += self.robot.take_events()

    def challenge(self) -> str:
        """Return the challenge of a heartbeat sent now."""
        return self.boot.reporter.heartbeat().challenge

    def next_seq(self) -> int:
        """Return the next number of this lease."""
        self.seq += 1
        return self.seq

    def pulse(self) -> None:
        """Send one operator heartbeat."""
        self.robot.receive(
            down.OperatorHeartbeat(
                robot="weeder-01", lease_token=self.token, lease_seq=self.next_seq(), challenge=self.challenge()
            )
        )

    def order(self, action: str, **more: Any) -> down.Command:
        """Return a fresh command."""
        fields: dict[str, Any] = {
            "robot": "weeder-01",
            "command_id": uuid.uuid4().hex,
            "action": action,
            "by": "Martha",
            "lease_token": self.token,
            "lease_seq": self.next_seq(),
            "challenge": self.challenge(),
        }
        return down.Command(**{**fields, **more})

    def do(self, action: str, **more: Any) -> up.Ack:
        """Send a fresh command and return the answer; a resume names the mission on the robot, as consoles do."""
        if action == "resume" and (held := self.state.order) is not None:
            more = {"mission_id": held.mission_id, "mission_sha256": held.sha256, **more}
        ack = self.robot.receive(self.order(action, **more))
        assert ack is not None
        return ack

    def proof(self, **more: Any) -> down.Proof:
        """Return the proof of whoever has control, made now."""
        fields = {"lease_token": self.token, "lease_seq": self.next_seq(), "challenge": self.challenge()}
        return down.Proof(**{**fields, **more})

    def load(self, mission: down.Mission) -> up.Ack:
        """Send a mission; an update as whoever has control does."""
        if mission.continues is not msgspec.UNSET:
            mission = msgspec.structs.replace(mission, proof=self.proof())
        ack = self.robot.receive(mission)
        assert ack is not None
        return ack

    def start(self, mission: down.Mission | None = None, **more: Any) -> up.Ack:
        """Send a mission and start it."""
        mission = mission or small_mission()
        self.load(mission)
        return self.do("start", mission_id=mission.mission_id, mission_sha256=mission_hash(mission), **more)

    def stop(self, stop_id: str = "stop-000001") -> up.Ack:
        """Press STOP."""
        ack = self.robot.receive(down.Stop(robot="weeder-01", stop_id=stop_id, by="Martha", device="Tablet 3"))
        assert ack is not None
        return ack

    def reset(self, *stop_ids: str, **more: Any) -> up.Ack:
        """Reset presses with a fresh lease."""
        self.token += 1
        fields: dict[str, Any] = {
            "robot": "weeder-01",
            "reset_id": uuid.uuid4().hex,
            "stop_ids": list(stop_ids) or ["stop-000001"],
            "by": "Martha",
            "reason": "Test",
            "lease_token": self.token,
            "lease_seq": self.next_seq(),
            "challenge": self.challenge(),
        }
        ack = self.robot.receive(down.StopReset(**{**fields, **more}))
        assert ack is not None
        return ack

    def drive(self, v_mps: float, yaw_rate_radps: float = 0.0) -> up.Ack | None:
        """Send one setpoint."""
        return self.robot.receive(
            down.Drive(
                robot="weeder-01",
                lease_token=self.token,
                lease_seq=self.next_seq(),
                challenge=self.challenge(),
                v_mps=v_mps,
                yaw_rate_radps=yaw_rate_radps,
            )
        )

    def drive_for(self, seconds: float, v_mps: float, yaw_rate_radps: float = 0.0) -> None:
        """Hold the stick."""
        for _ in range(round(seconds * 10)):
            self.drive(v_mps, yaw_rate_radps)
            self.run(0.1)

    def jog(self, **rates: float) -> up.Ack | None:
        """Send one setpoint for the joints."""
        return self.robot.receive(
            down.Jog(
                robot="weeder-01",
                lease_token=self.token,
                lease_seq=self.next_seq(),
                challenge=self.challenge(),
                rates=rates,
            )
        )

    def jog_for(self, seconds: float, **rates: float) -> None:
        """Hold the joints' stick."""
        for _ in range(round(seconds * 10)):
            self.jog(**rates)
            self.run(0.1)

    @property
    def state(self) -> up.State:
        """The state message now."""
        return self.boot.reporter.state()

    @property
    def safety(self) -> up.Safety:
        """The safety message now."""
        return self.boot.reporter.safety()

    @property
    def telemetry(self) -> up.Telemetry:
        """The telemetry message now."""
        return self.boot.reporter.telemetry()

    @property
    def speed(self) -> float:
        """The true speed."""
        return self.robot.machine.base.speed_mps
