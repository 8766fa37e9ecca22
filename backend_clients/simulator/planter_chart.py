"""The planter's supervisor: a machine of nested and parallel states that runs, and the chart it is shown by.

The chart sent to the console is read from the machine that runs, so that they cannot differ. Transitions depend on what
the actions of base, crane and tool answered; what the states do is in ``planting``.
"""

from __future__ import annotations

from typing import Any

from statemachine import State, StateChart
from statemachine.transition_list import TransitionList

from backend_clients.edge.machine import Chart, ChartState, ChartTransition
from backend_clients.simulator.activity import Step
from backend_clients.simulator.top_chart import MOVES as SHARED_MOVES
from backend_clients.simulator.top_chart import top_states

_ALONE = ("idle", "paused", "mission")
MOVES = (
    *SHARED_MOVES,
    *((state, "move-crane", "retract or send the crane", "in control, standing") for state in _ALONE),
    *(("move-crane", state, "crane there", "") for state in _ALONE),
    ("move-crane", "manual", "drive by hand", "in control"),
    ("move-crane", "stopped", "STOP", ""),
    ("move-crane", "fault", "no energy", ""),
)
"""What every family has, and the crane moved alone."""
_MOVE_CRANE = ChartState(
    id="move-crane", label="Move the crane", subsystem="Crane", entry=["horn 3 s"], exit=["hold the crane"]
)
_TOPS = {one.id: one for one in (*top_states(), _MOVE_CRANE)}


def _top(state: str) -> State:
    return State(_TOPS[state].label, value=state, initial=_TOPS[state].is_initial)


def _top_events(names: dict[str, Any]) -> dict[str, TransitionList]:
    """Return an event ``to_...`` for each outermost state, from everywhere it can be entered."""
    found: dict[str, TransitionList] = {}
    for source, target, _, _ in MOVES:
        event = f"to_{_py(target)}"
        move = names[_py(source)].to(names[_py(target)])
        found[event] = found[event] | move if event in found else move
    return found


def _py(state: str) -> str:
    return state.replace("-", "_")


class PlanterMachine(StateChart[Any]):
    """The running supervisor; ``active`` holds the chart ids of its states, ``taken`` the transitions taken."""

    catch_errors_as_events = False

    start_up, idle, paused, manual = _top("start-up"), _top("idle"), _top("paused"), _top("manual")
    stopped, fault, return_home, go_to = _top("stopped"), _top("fault"), _top("return-home"), _top("go-to")
    move_crane = _top("move-crane")

    class mission(State.Compound, name="Mission"):
        begin = State("Start", value="begin", initial=True)
        transit = State("Transit", value="transit")
        map_site = State("Map the site", value="map-site")
        refill = State("Refill trays", value="refill")
        wait_person = State("Wait for a person", value="wait-person")
        wait = State("Wait", value="wait")
        end = State("End", value="end")

        class plant_site(State.Parallel, name="Plant trees"):
            class base(State.Compound, name="Base"):
                hold = State("Hold", value="hold", initial=True)
                drive = State("Drive to the next site", value="drive")
                settle = State("Settle", value="settle")
                drive_on = hold.to(drive)
                arrived = drive.to(settle)
                settled = settle.to(hold)
                brake = drive.to(hold) | settle.to(hold)

            class crane(State.Compound, name="Crane"):
                crane_idle = State("Hold still", value="crane-idle", initial=True)
                transport = State("Fold for transport", value="transport")
                dock_waypoint = State("To the dock waypoint", value="dock-waypoint")
                dock = State("Dock for a seedling", value="dock")
                above_plant = State("Above the planting point", value="above-plant")
                on_ground = State("Lower to the ground", value="on-ground")
                photo = State("To the photo position", value="photo")
                back_off = State("Back off", value="back-off")
                retract = State("Retract", value="retract")
                fetch = crane_idle.to(dock_waypoint)
                go_to_point = crane_idle.to(above_plant)
                fold = crane_idle.to(transport)
                waypoint_reached = dock_waypoint.to(dock)
                dock_failed = dock.to(retract)
                docked = dock.to(crane_idle)
                retracted = retract.to(crane_idle)
                above_point = above_plant.to(on_ground)
                crane_failed = above_plant.to(back_off) | on_ground.to(back_off)
                grounded = on_ground.to(crane_idle)
                no_ground = on_ground.to(back_off)
                planted = crane_idle.to(photo)
                scar_failed = crane_idle.to(back_off)
                backed_off = back_off.to(crane_idle)
                photo_taken = photo.to(crane_idle)
                folded = transport.to(crane_idle)

            class tool(State.Compound, name="Planting tool"):
                tool_idle = State("Ready", value="tool-idle", initial=True)
                transfer = State("Transfer a seedling", value="transfer")
                drop = State("Drop it into the head", value="drop")
                plant = State("Scarify, plant, compact", value="plant")
                feed = tool_idle.to(transfer)
                fed = transfer.to(tool_idle)
                docked = tool_idle.to(drop)
                dropped = drop.to(tool_idle)
                grounded = tool_idle.to(plant)
                planted = plant.to(tool_idle)
                scar_failed = plant.to(tool_idle)

            class guard(State.Compound, name="Guard"):
                area_clear = State("Area clear", value="area-clear", initial=True)
                person_near = State("Person near: slow", value="person-near")
                person_inside = State("Person inside: stop", value="person-inside")
                came_near = area_clear.to(person_near)
                came_inside = person_near.to(person_inside) | area_clear.to(person_inside)
                went_out = person_inside.to(person_near)
                went_away = person_near.to(area_clear) | person_inside.to(area_clear)

        horn_sounded = begin.to(transit)
        row_begins = transit.to(plant_site)
        site_reached = plant_site.to(map_site)
        mapped = map_site.to(plant_site)
        row_done = plant_site.to(transit)
        last_point = transit.to(end) | plant_site.to(end)
        tray_empty = plant_site.to(refill)
        person_needed = plant_site.to(wait_person) | transit.to(wait_person) | begin.to(wait_person)
        person_needed |= map_site.to(wait_person) | refill.to(wait_person) | wait.to(wait_person)
        must_wait = plant_site.to(wait) | transit.to(wait) | begin.to(wait) | map_site.to(wait)
        must_wait |= wait_person.to(wait) | refill.to(wait)
        go_on_planting = begin.to(plant_site) | refill.to(plant_site) | wait_person.to(plant_site) | wait.to(plant_site)
        go_on_driving = wait_person.to(transit) | wait.to(transit) | refill.to(transit) | plant_site.to(transit)
        go_on_driving |= map_site.to(transit)

    locals().update(_top_events(locals()))

    def __init__(self) -> None:
        self.taken: list[Step] = []
        super().__init__()
        self.active = {_id_of_value(value) for value in self.configuration_values}

    def on_transition(self, event: str, source: State, target: State, result: str = "") -> None:
        """Note what was taken; entering a composite calls this for its parts too, which is no transition."""
        if (source.value, target.value) in _BETWEEN and (not self.taken or self.taken[-1].target != target.value):
            self.taken.append(Step(_id(source), _id(target), _words(event, _id(source), _id(target)), result))

    def fire(self, event: str, result: str = "") -> None:
        """Tell it what happened, with the result code of the action that ended."""
        self.send(event, result=result)
        self.active = {_id_of_value(value) for value in self.configuration_values}


_SUBSYSTEMS = {
    "begin": "Operator", "transit": "Drive", "map-site": "Perception", "refill": "Waiting", "wait-person": "Waiting",
    "wait": "Waiting", "end": "Operator", "hold": "Drive", "drive": "Drive", "settle": "Drive",
    "tool-idle": "Planter", "transfer": "Planter", "drop": "Planter", "plant": "Planter",
    "area-clear": "Guard", "person-near": "Guard", "person-inside": "Guard",
}  # fmt: skip
_NORMAL_S = {
    "begin": 3.0, "map-site": 0.6, "drive": 11.05, "settle": 0.2, "transport": 4.85, "dock-waypoint": 8.74,
    "dock": 10.94, "above-plant": 22.18, "on-ground": 6.54, "photo": 9.02, "transfer": 5.1, "drop": 3.1, "plant": 8.1,
}  # fmt: skip
"""Published times of the simulated machine, per visit."""
_ENTRY: dict[str, list[str]] = {
    "begin": ["horn 3 s"],
    "map-site": ["planner PHOTO_WORKAREA", "planner ADD_OBSTACLES", "new_site = false"],
    "drive": ["drive NEXT_POS", "new_site = true"],
    "transport": ["crane TRANSPORT"],
    "dock-waypoint": ["crane DOCK_WAYPOINT"],
    "dock": ["crane DOCK"],
    "above-plant": ["planner GET_POSITION", "crane POSITION_ABOVE_PLANT"],
    "on-ground": ["crane POSITION_ON_GROUND"],
    "photo": ["crane PHOTO_PLANT", "photo TAKE_PHOTO"],
    "back-off": ["crane POSITION_ABOVE_PLANT", "planner SAVE_FAIL"],
    "retract": ["crane DOCK_WAYPOINT"],
    "transfer": ["planter TRANSFER"],
    "drop": ["planter DROP", "has_seedling = true"],
    "plant": ["planter PLANT"],
    "person-near": ["crane and drive slow"],
    "person-inside": ["crane and drive stop"],
    "wait-person": ["crane and drive stop"],
    "wait": ["crane and drive stop"],
    "refill": ["ask for a tray"],
}
_EXIT: dict[str, list[str]] = {"plant": ["has_seedling = false"], "photo": ["planner SAVE_SUCCESS"]}
_GUARDS: dict[str, str] = {
    "fetch": "not has_seedling, a point is left",
    "go_to_point": "has_seedling, a point is left",
    "fold": "no point is left",
    "feed": "no seedling in the arm, one in the tray",
    "docked": "a seedling in the arm",
    "dock_failed": "FAIL_DOCK",
    "no_ground": "FAIL_GROUND",
    "scar_failed": "FAIL_SCAR",
    "crane_failed": "FAIL_CRANE",
    "planted": "OK",
    "drive_on": "crane folded, new site wanted",
    "site_reached": "new_site",
    "tray_empty": "not has_seedling, tray empty",
}
_TOP_EVENTS = {(source, target): (event, guard) for source, target, event, guard in MOVES}
_BETWEEN = {
    (move.source.value, target.value)
    for state in PlanterMachine.states_map.values()
    for move in state.transitions
    if not move.initial
    for target in move.targets
}


def chart() -> Chart:
    """Return the machine as data, in the order it is written."""
    states, moves = [], []
    for state in PlanterMachine.states_map.values():
        states.append(_described(state))
        for move in state.transitions:
            if not move.initial:
                moves += [_moved(move, target) for target in move.targets]
    return Chart(states=states, transitions=moves)


def _described(state: State) -> ChartState:
    at = _id(state)
    if at in _TOPS and at != "mission":
        return _TOPS[at]
    parent = state.parent
    kind = "composite" if state.states else "simple"
    if state.parallel:
        kind = "parallel"
    elif parent is not None and parent.parallel:
        kind = "region"
    usual = "Crane" if parent is not None and _id(parent) == "crane" else ""
    return ChartState(
        id=at,
        label=state.name,
        parent=_id(parent) if parent is not None else None,
        kind=kind,  # type: ignore[arg-type]
        is_initial=state.initial and kind != "region",
        subsystem=_SUBSYSTEMS.get(at, usual),
        normal_s=_NORMAL_S.get(at),
        entry=_ENTRY.get(at, list(_TOPS["mission"].entry) if at == "mission" else []),
        exit=_EXIT.get(at, list(_TOPS["mission"].exit) if at == "mission" else []),
    )


def _moved(move: Any, target: State) -> ChartTransition:
    source, goal, event = _id(move.source), _id(target), str(move.event)
    guard = _TOP_EVENTS[source, goal][1] if (source, goal) in _TOP_EVENTS else _GUARDS.get(event, "")
    return ChartTransition(source=source, target=goal, event=_words(event, source, goal), guard=guard)


def _words(event: str, source: str, target: str) -> str:
    if (source, target) in _TOP_EVENTS:
        return _TOP_EVENTS[source, target][0]
    return event.replace("_", " ")


def _id(state: State) -> str:
    return _id_of_value(state.value)


def _id_of_value(value: Any) -> str:
    return str(value).replace("_", "-")
