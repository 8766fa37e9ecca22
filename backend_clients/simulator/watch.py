"""What the robot tells about itself: supervisor states, active faults, and why it waits.

Words of the supervisor path follow the robot's own sequence: select and start (A0), perceive (A1),
decide (A2), command (A3), forward (A4), treat (A5), end (A6).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from backend_clients.edge import messages_up as up
from backend_clients.simulator.holds import fault, hold
from backend_clients.simulator.mission_run import MOVED_LIMIT_M

if TYPE_CHECKING:
    from backend_clients.simulator.weeder import Weeder

FIND_ROW_M = 1.0  # so far before a row its cameras look for the plants
_WAIT_WORDS = {
    "person_ahead": "Person ahead",
    "rtk_float": "Waiting for RTK",
    "tool_interlock": "Laser cover open",
    "start_horn": "Horn",
}


class Watch:
    """Notices changes of state and faults and writes them into the journal."""

    def __init__(self, weeder: Weeder) -> None:
        self._weeder = weeder
        self.path: tuple[str, ...] = ("Boot",)
        self.since_ms = 0
        self.faults: tuple[str, ...] = ()
        self.look()

    def look(self) -> None:
        """Compare with the last look."""
        path, codes = supervisor_path(self._weeder), fault_codes(self._weeder)
        if path != self.path:
            self._changed(path)
        if codes != self.faults:
            for code in self.faults:
                if code not in codes:
                    self._weeder.note("alarm_cleared", code, fault(code).text, code=code, level=fault(code).level)
            for code in codes:
                if code not in self.faults:
                    self._weeder.note("alarm_raised", code, fault(code).text, code=code, level=fault(code).level)
            self.faults = codes

    def _changed(self, path: tuple[str, ...]) -> None:
        now_ms = self._weeder.mono_ms()
        left, entered = " > ".join(self.path), " > ".join(path)
        self._weeder.note("state_left", left[:80], duration_ms=now_ms - self.since_ms, path=list(self.path))
        self._weeder.note("state_entered", entered[:80], path=list(path))
        self.path, self.since_ms = path, now_ms


def supervisor_path(weeder: Weeder) -> tuple[str, ...]:
    """Return the active supervisor states, outer first."""
    if weeder.is_stopped:
        return ("Stopped",)
    if weeder.drive is not None:
        return ("Manual drive",)
    if weeder.home_run is not None:
        return ("Return home", _WAIT_WORDS.get(weeder.hold_code, "Forward"))
    run = weeder.run
    if run is None:
        return ("Idle",)
    if run.status == "running":
        return ("Mission", *_mission_states(weeder))
    words = {"loaded": "Loaded", "paused": "Paused", "done": "End", "aborted": "Aborted", "failed": "Failed"}
    return ("Mission", words.get(run.status, "Idle"))


def _mission_states(weeder: Weeder) -> tuple[str, ...]:
    run = weeder.run
    assert run is not None
    if weeder.hold_code == "start_horn":
        return ("Start", "Horn")
    if weeder.hold_code:
        return ("Hold", _WAIT_WORDS[weeder.hold_code])
    if weeder.is_on_lead:
        return ("Approach", "Forward")
    leg = run.leg
    laser = "Laser firing" if weeder.machine.laser_on else "Laser off"
    if leg.kind == "row":
        return ("Treat row", laser)
    after = run.route.next_leg(leg)
    if after is not None and after.kind == "row" and leg.end_m - run.tracker.s_m < FIND_ROW_M:
        return ("Turn" if leg.kind == "turn" else "Approach", "Find row")
    if leg.kind == "headland":
        return ("Treat headland" if leg.is_tool_on else "Headland", laser)
    return {"turn": ("Turn", "Laser off"), "exit": ("Exit", "Forward")}.get(leg.kind, ("Approach", "Forward"))


def fault_codes(weeder: Weeder) -> tuple[str, ...]:
    """Return the codes of all active faults."""
    machine = weeder.machine
    found = []
    if machine.is_hardware_stop:
        found.append("hardware-stop")
    if machine.is_way_blocked():
        found.append("person-ahead")
    if machine.is_cover_open:
        found.append("tool-interlock")
    if machine.is_rtk_float:
        found.append("rtk-float")
    if machine.soc <= 0:
        found.append("battery-empty")
    elif machine.soc < 0.1:
        found.append("battery-very-low")
    elif machine.soc < 0.2:
        found.append("battery-low")
    return tuple(found)


def waiting_reason(weeder: Weeder) -> up.Hold | None:
    """Return why it does not move, ``None`` if it moves or has nothing to do."""
    if weeder.machine.is_hardware_stop:
        return hold("hardware_stop")
    if weeder.latch.is_set:
        names = sorted({press.by for press in weeder.latch.presses if not press.is_reset})
        return hold("stop_latched", detail=f"STOP was pressed by {', '.join(names)}."[:400])
    if weeder.machine.soc <= 0:
        return hold("battery_empty")
    if weeder.hold_code:
        return hold(weeder.hold_code)
    run = weeder.run
    if weeder.drive is None and weeder.home_run is None and run is not None and run.status == "paused":
        moved_m = run.moved_m(weeder.place)
        if moved_m > MOVED_LIMIT_M and run.pause_code != "return_home":
            return hold("moved_while_paused", detail=f"It was moved {moved_m:.1f} m since the pause.")
        return hold(run.pause_code or "paused")
    return None
