"""Makes the robot's messages from its present state."""

from __future__ import annotations

from collections import deque
from typing import TypedDict

from msgspec.structs import replace

from backend_clients.edge import messages_up as up
from backend_clients.edge.machine import Body, Detections, Scan, Worksite
from backend_clients.simulator.brain import Brain
from backend_clients.simulator.cameras.sight import Sight
from backend_clients.simulator.datasheet import factsheet_fields
from backend_clients.simulator.holds import fault
from backend_clients.simulator.inside import body_fields, worksite_fields
from backend_clients.simulator.journal import Happening
from backend_clients.simulator.latch import PressRecord
from backend_clients.simulator.mission_run import MissionRun
from backend_clients.simulator.scan import scan_fields
from backend_clients.simulator.watch import waiting_reason
from backend_clients.simulator.work import Sites

MAX_PENDING_PINGS = 4
MAX_PRESSES_SHOWN = 64


class HeaderFields(TypedDict):
    """Keyword arguments of ``messages_up.Header``."""

    robot: str
    boot: str
    seq: int
    mono_ms: int
    wall_ms: int


class Reporter:
    """Numbers and stamps everything one boot of a robot says."""

    def __init__(self, brain: Brain) -> None:
        self._brain = brain
        self._seq = 0
        self._pings: deque[tuple[float, str]] = deque(maxlen=MAX_PENDING_PINGS)

    def header(self, mono_ms: int | None = None) -> HeaderFields:
        """Return the next header; ``mono_ms`` is given for what happened earlier."""
        self._seq += 1
        now_ms = self._brain.mono_ms()
        wall_s = self._brain.clock.utc().timestamp() + self._brain.faults.wall_offset_s
        at_ms = now_ms if mono_ms is None else mono_ms
        return {
            "robot": self._brain.config.id,
            "boot": self._brain.boot,
            "seq": self._seq,
            "mono_ms": at_ms,
            "wall_ms": int(wall_s * 1000) - (now_ms - at_ms),
        }

    def ping(self, nonce: str) -> None:
        """Note a nonce that the next heartbeat has to echo."""
        self._pings.append((self._brain.clock.mono_s(), nonce))

    @property
    def is_ping_waiting(self) -> bool:
        """Whether more nonces wait than one heartbeat can echo."""
        return len(self._pings) > 1

    def presence(self) -> up.Presence:
        """Return "I am here"."""
        return up.Presence(**self.header(), online=True)

    def goodbye(self, reason: str) -> up.Presence:
        """Return what is said at shutdown, or by the broker when the robot vanishes."""
        return up.Presence(**self.header(), online=False, reason="lost" if reason == "lost" else "shutdown")

    def heartbeat(self) -> up.Heartbeat:
        """Return a heartbeat with a fresh challenge and the oldest ping not yet echoed."""
        now = self._brain.clock.mono_s()
        challenge = self._brain.guard.issue(now)
        if not self._pings:
            return up.Heartbeat(**self.header(), challenge=challenge)
        heard_s, nonce = self._pings.popleft()
        held_ms = max((now - heard_s) * 1000, 0.0)
        return up.Heartbeat(**self.header(), challenge=challenge, echo_nonce=nonce, echo_held_ms=round(held_ms, 3))

    def telemetry(self) -> up.Telemetry:
        """Return pose and fast values as the robot's own sensors see them."""
        brain, machine = self._brain, self._brain.machine
        x_m, y_m, theta_rad = machine.measured_pose()
        lat_deg, lon_deg = brain.frame.to_wgs84(x_m, y_m)
        cross, obstacle = brain.cross_track_m, machine.obstacle_m()
        return up.Telemetry(
            **self.header(),
            lat_deg=round(lat_deg, 9),
            lon_deg=round(lon_deg, 9),
            x_m=round(x_m, 4),
            y_m=round(y_m, 4),
            theta_rad=round(theta_rad, 5),
            speed_mps=round(machine.base.speed_mps, 3),
            yaw_rate_radps=round(machine.base.yaw_rate_radps, 4),
            gnss=machine.gnss(),
            battery=machine.battery(),
            tool=self._tool(),
            cross_track_m=None if cross is None else round(cross, 4),
            obstacle_m=None if obstacle is None else round(obstacle, 2),
        )

    def state(self) -> up.State:
        """Return mode, supervisor path, mission, faults and why it waits."""
        brain = self._brain
        run = brain.run
        is_following = brain.is_auto and run is not None
        return up.State(
            **self.header(),
            mode=brain.mode,
            path=list(brain.watch.path),
            path_since_ms=brain.watch.since_ms,
            lease_token=brain.guard.active_lease,
            set_speed_mps=run.leg.speed_mps if is_following and run is not None else None,
            order=self._order(run) if run is not None else None,
            actions=brain.actions.list(),
            faults=[fault(code, brain.profile.words) for code in brain.watch.faults],
            hold=waiting_reason(brain),
            active=brain.watch.activity.active() if brain.watch.activity is not None else [],
            last_transition=brain.watch.activity.last if brain.watch.activity is not None else None,
        )

    def safety(self) -> up.Safety:
        """Return what the safety controller knows."""
        brain, machine = self._brain, self._brain.machine
        speed = abs(machine.base.speed_mps)
        return up.Safety(
            **self.header(),
            hardware_stop=machine.is_hardware_stop,
            latched=brain.latch.is_set,
            standstill=machine.is_standing,
            speed_mps=round(speed, 3),
            tool_off=not machine.tool_on,
            presses=[self._press(press) for press in list(brain.latch.presses)[-MAX_PRESSES_SHOWN:]],
            stopping_distance_m=self._stopping_distance_m(),
        )

    def _stopping_distance_m(self) -> float | None:
        """Return how far it went from the press until it stood; not known before it stands."""
        brain, machine = self._brain, self._brain.machine
        if not brain.latch.is_set or not machine.is_standing or brain.braked_from_m is None:
            return None
        return round(machine.base.distance_m - brain.braked_from_m, 3)

    def factsheet(self) -> up.Factsheet:
        """Return who the robot is and what it can do."""
        return up.Factsheet(**self.header(), **factsheet_fields(self._brain.config))

    def body(self) -> Body:
        """Return joints, gauges and who is near."""
        return Body(**self.header(), **body_fields(self._brain.machine, self._brain.home))

    def worksite(self) -> Worksite | None:
        """Return where it works now, ``None`` before the first site and for machines without one."""
        rig = self._brain.machine.rig
        fields = worksite_fields(rig) if rig is not None else None
        return None if fields is None else Worksite(**self.header(), **fields)

    def scan(self) -> Scan:
        """Return what it sees of the ground around it."""
        return Scan(**self.header(), **scan_fields(self._brain.machine))

    def detections(self, sight: Sight) -> Detections:
        """Return what was found in a picture, with the time it was taken."""
        return Detections(**self.header(self._brain.mono_ms_of(sight.taken_s)), **sight.fields())

    def nodes(self, period_ms: int = 5000) -> list[up.Node]:
        """Return the life cycle of each software node, reported at least each ``period_ms``."""
        return [up.Node(**self.header(), period_ms=period_ms, **fields) for fields in self._brain.nodes.fields()]

    def event(self, happening: Happening) -> up.Event:
        """Return the message of one event."""
        return up.Event(
            **self.header(happening.mono_ms),
            event_id=happening.event_id,
            kind=happening.kind,
            name=happening.name,
            text=happening.text,
            data=happening.data,
        )

    def _order(self, run: MissionRun) -> up.OrderState:
        order, work = run.order_state(), self._brain.work
        if self._brain.machine.rig is None:
            return order  # asking whether its work has sites is a tenth of what a lean robot costs
        if not isinstance(work, Sites) or order.remaining_s is None or order.status == "done":
            return order
        return replace(order, remaining_s=round(order.remaining_s + work.work_left_s(run), 1))

    def _tool(self) -> up.ToolState:
        machine, brain = self._brain.machine, self._brain
        is_armed = brain.run is not None and brain.run.status == "running"
        state = "fault" if machine.is_cover_open else "on" if machine.tool_on else "armed" if is_armed else "off"
        return up.ToolState(
            state=state,  # type: ignore[arg-type]
            interlock_ok=not machine.is_cover_open,
            rate_per_min=None if machine.rate_per_min is None else round(machine.rate_per_min, 1),
            temperature_c=None if machine.profile.hot_c is None else round(machine.tool_temperature_c, 1),
        )

    def _press(self, press: PressRecord) -> up.Press:
        return up.Press(
            stop_id=press.stop_id,
            by=press.by[:80],
            device=press.device[:80],
            mono_ms=self._brain.mono_ms_of(press.pressed_s),
            is_reset=press.is_reset,
        )
