"""What the robot tells about itself: supervisor states, active faults, and why it waits.

A robot with a chart tells each state of it; a lean robot has none and tells the path in words only.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from backend_clients.edge import messages_up as up
from backend_clients.simulator.activity import Activity, Change
from backend_clients.simulator.holds import fault, hold
from backend_clients.simulator.mission_run import MOVED_LIMIT_M
from backend_clients.simulator.supervisor import supervisor_of

if TYPE_CHECKING:
    from backend_clients.simulator.brain import Brain

TRAY_LOW = 15
RESERVE_NEAR = 0.05
FIND_ROW_M = 1.0  # so far before a row its cameras look for the plants
_WAIT_WORDS = {
    "person_ahead": "Person ahead",
    "robot_ahead": "Robot ahead",
    "way_blocked": "Way blocked",
    "rtk_float": "Waiting for RTK",
    "tool_interlock": "Cover open",
    "weed_unsure": "Weed unsure",
    "crane_limit": "Crane at limit",
    "tray_empty": "Tray empty",
    "start_horn": "Horn",
    "climbing": "Climbing",
    "person_inside": "Person inside",
    "ask_person": "Help wanted",
}


class Watch:
    """Notices changes of state and faults and writes them into the journal."""

    def __init__(self, brain: Brain) -> None:
        self._brain = brain
        self.path: tuple[str, ...] = ("Boot",)
        self.since_ms = 0
        self.faults: tuple[str, ...] = ()
        self._supervisor = None if brain.config.is_lean else supervisor_of(brain)
        self.activity: Activity | None = None
        if self._supervisor is not None:
            self.activity = Activity(self._supervisor.tree, ("start-up",), 0)
        self.look()

    def look(self) -> None:
        """Compare with the last look."""
        self._look_at_states()
        path, codes = self._words(), fault_codes(self._brain)
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

    def _look_at_states(self) -> None:
        if self._supervisor is None or self.activity is None:
            return
        states, steps = self._supervisor.look(self._brain)
        if not steps and states == self.activity.states:
            return
        for change in self.activity.become(states, self._brain.mono_ms(), steps):
            self._tell(change)

    def _tell(self, change: Change) -> None:
        assert self.activity is not None
        tree = self.activity.tree
        state, path = tree.states[change.state], tree.labels(change.state)
        facts: dict[str, Any] = {
            "state": state.id,
            "path": path,
            "subsystem": state.subsystem,
            "is_leaf": tree.is_leaf(state.id),
        }
        if self._brain.run is not None:
            facts["mission_id"] = self._brain.run.mission.mission_id
        if change.is_entered:
            self._brain.note("state_entered", state.label, **facts)
        else:
            facts |= {"duration_ms": change.duration_ms, "result": change.result}
            self._brain.note("state_left", state.label, **facts)

    def _words(self) -> tuple[str, ...]:
        if self.activity is not None and self._brain.profile.work == "plant":
            return planter_words(self._brain, self.activity)
        return supervisor_path(self._brain)

    def _changed(self, path: tuple[str, ...]) -> None:
        now_ms = self._brain.mono_ms()
        if self.activity is None:
            left, entered = " > ".join(self.path), " > ".join(path)
            self._brain.note("state_left", left[:80], duration_ms=now_ms - self.since_ms, path=list(self.path))
            self._brain.note("state_entered", entered[:80], path=list(path))
        self.path, self.since_ms = path, now_ms


_QUIET = ("crane-idle", "tool-idle", "transfer", "hold", "area-clear", "person-near")


def planter_words(brain: Brain, activity: Activity) -> tuple[str, ...]:
    """Return the states of a planter worth a word, outer first: one leaf of those that are active together."""
    tree, states = activity.tree, activity.states
    leaves = [one for one in states if tree.is_leaf(one)]
    leaf = next((one for one in reversed(leaves) if one not in _QUIET), leaves[0])
    words = [label for label in tree.labels(leaf) if label not in ("Base", "Crane", "Planting tool", "Guard")]
    rig = brain.machine.rig
    target = rig.site.current if rig is not None and rig.site is not None else None
    if target is not None and "plant-site" in states:
        words[1] = f"Plant tree {target.id.removeprefix('tree-')}"
    if brain.hold_code and brain.hold_code in _WAIT_WORDS and "mission" in states:
        words.append(_WAIT_WORDS[brain.hold_code])
    return tuple(words)


def supervisor_path(brain: Brain) -> tuple[str, ...]:
    """Return the active supervisor states, outer first."""
    if brain.is_stopped:
        return ("Stopped",)
    if brain.drive is not None:
        return ("Manual drive",)
    if brain.home_run is not None:
        word = {"return-home": "Return home", "go-to": "Go to a place"}[brain.errand_name]
        return (word, _WAIT_WORDS.get(brain.hold_code, "Forward"))
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
    if machine.rig is not None and not machine.is_way_blocked():
        code = brain.work.waits_for()
        if code in ("person_inside", "ask_person"):
            found.append(code.replace("_", "-"))
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
        neighbour = brain.machine.neighbour
        is_met = brain.hold_code == "robot_ahead" and neighbour is not None
        detail = f"{neighbour.name} stands in its way." if is_met and neighbour is not None else ""
        return hold(brain.hold_code, brain.profile.words, detail=detail)
    run = brain.run
    if brain.drive is None and brain.home_run is None and run is not None and run.status == "paused":
        moved_m = run.moved_m(brain.place)
        if moved_m > MOVED_LIMIT_M and run.pause_code not in ("return_home", "low_charge"):
            return hold("moved_while_paused", detail=f"It was moved {moved_m:.1f} m since the pause.")
        if run.pause_code == "function_off":
            return _function_off(brain)
        return hold(run.pause_code or "paused")
    return None


def _function_off(brain: Brain) -> up.Hold:
    profile = brain.profile
    why = brain.nodes.why_off(profile.work_function)
    if not why:
        return hold("function_off")
    label = next(one.label for one in profile.functions if one.name == profile.work_function)
    text = f"{label} is off: {why} does not run."
    return up.Hold(code="function_off", text=text, clears=f"Restart {why}, then resume the mission.", who="admin")
