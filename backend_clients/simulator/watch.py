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
    from backend_clients.simulator.brain import Brain

TRAY_LOW = 15
RESERVE_NEAR = 0.05
FIND_ROW_M = 1.0  # so far before a row its cameras look for the plants
_WAIT_WORDS = {
    "person_ahead": "Person ahead",
    "rtk_float": "Waiting for RTK",
    "tool_interlock": "Cover open",
    "weed_unsure": "Weed unsure",
    "crane_limit": "Crane at limit",
    "tray_empty": "Tray empty",
    "start_horn": "Horn",
}


class Watch:
    """Notices changes of state and faults and writes them into the journal."""

    def __init__(self, brain: Brain) -> None:
        self._brain = brain
        self.path: tuple[str, ...] = ("Boot",)
        self.since_ms = 0
        self.faults: tuple[str, ...] = ()
        self.look()

    def look(self) -> None:
        """Compare with the last look."""
        path, codes = supervisor_path(self._brain), fault_codes(self._brain)
        if path != self.path:
            self._changed(path)
        if codes != self.faults:
            for code in self.faults:
                if code not in codes:
                    self._brain.note("alarm_cleared", code, self._text(code), code=code, level=fault(code).level)
            for code in codes:
                if code not in self.faults:
                    self._brain.note("alarm_raised", code, self._text(code), code=code, level=fault(code).level)
            self.faults = codes

    def _text(self, code: str) -> str:
        return fault(code, self._brain.profile.words).text

    def _changed(self, path: tuple[str, ...]) -> None:
        now_ms = self._brain.mono_ms()
        left, entered = " > ".join(self.path), " > ".join(path)
        self._brain.note("state_left", left[:80], duration_ms=now_ms - self.since_ms, path=list(self.path))
        self._brain.note("state_entered", entered[:80], path=list(path))
        self.path, self.since_ms = path, now_ms


def supervisor_path(brain: Brain) -> tuple[str, ...]:
    """Return the active supervisor states, outer first."""
    if brain.is_stopped:
        return ("Stopped",)
    if brain.drive is not None:
        return ("Manual drive",)
    if brain.home_run is not None:
        return ("Return home", _WAIT_WORDS.get(brain.hold_code, "Forward"))
    run = brain.run
    if run is None:
        return ("Idle",)
    if run.status == "running":
        return ("Mission", *_mission_states(brain))
    words = {"loaded": "Loaded", "paused": "Paused", "done": "End", "aborted": "Aborted", "failed": "Failed"}
    return ("Mission", words.get(run.status, "Idle"))


def _mission_states(brain: Brain) -> tuple[str, ...]:
    run = brain.run
    assert run is not None
    if brain.hold_code == "start_horn":
        return ("Start", "Horn")
    if brain.hold_code:
        return ("Hold", _WAIT_WORDS[brain.hold_code])
    if brain.is_on_lead:
        return ("Approach", "Forward")
    leg = run.leg
    words = brain.profile.words
    tool = words.tool_on if brain.machine.tool_on else words.tool_off
    if leg.kind == "row":
        return (words.row, tool)
    after = run.route.next_leg(leg)
    if after is not None and after.kind == "row" and leg.end_m - run.tracker.s_m < FIND_ROW_M:
        return ("Turn" if leg.kind == "turn" else "Approach", "Find row")
    if leg.kind == "headland":
        return ("Treat headland" if leg.is_tool_on else "Headland", tool)
    return {"turn": ("Turn", words.tool_off), "exit": ("Exit", "Forward")}.get(leg.kind, ("Approach", "Forward"))


def fault_codes(brain: Brain) -> tuple[str, ...]:
    """Return the codes of all active faults."""
    machine = brain.machine
    found = []
    if machine.is_hardware_stop:
        found.append("hardware-stop")
    if machine.is_way_blocked():
        found.append("person-ahead")
    if machine.is_cover_open:
        found.append("tool-interlock")
    if machine.is_rtk_float:
        found.append("rtk-float")
    if machine.is_unsure:
        found.append("weed-unsure")
    if machine.is_crane_at_limit:
        found.append("crane-limit")
    if machine.profile.tray and machine.seedlings < TRAY_LOW:
        found.append("tray-low" if machine.seedlings else "tray-empty")
    found += _battery(brain)
    return tuple(found)


def _battery(brain: Brain) -> list[str]:
    machine, reserve = brain.machine, brain.profile.home_below
    if machine.is_charging:
        return []
    if machine.soc <= 0:
        return ["battery-empty"]
    if machine.soc < 0.1:
        return ["battery-very-low"]
    if machine.soc < 0.2:
        return ["battery-low"]
    return ["reserve-near"] if reserve and machine.soc < reserve + RESERVE_NEAR else []


def waiting_reason(brain: Brain) -> up.Hold | None:
    """Return why it does not move, ``None`` if it moves or has nothing to do."""
    if brain.machine.is_hardware_stop:
        return hold("hardware_stop")
    if brain.latch.is_set:
        names = sorted({press.by for press in brain.latch.presses if not press.is_reset})
        return hold("stop_latched", detail=f"STOP was pressed by {', '.join(names)}."[:400])
    if brain.machine.soc <= 0:
        return hold("battery_empty")
    if brain.hold_code:
        return hold(brain.hold_code, brain.profile.words)
    run = brain.run
    if brain.drive is None and brain.home_run is None and run is not None and run.status == "paused":
        moved_m = run.moved_m(brain.place)
        if moved_m > MOVED_LIMIT_M and run.pause_code not in ("return_home", "low_charge"):
            return hold("moved_while_paused", detail=f"It was moved {moved_m:.1f} m since the pause.")
        return hold(run.pause_code or "paused")
    return None
