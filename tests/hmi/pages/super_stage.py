"""The Supervisor screen on stage: a planter that goes round its crane, told by the real routes from played events."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

from fastapi import APIRouter, Request

from hmi.api.state_chart import StateRoutes, state_chart_routes
from hmi.clock import Clock
from hmi.domain import robot as domain
from hmi.domain.event import RobotEvent
from hmi.domain.state_chart import ActiveState, Chart, ChartState, ChartTransition, LastTransition
from hmi.security.authorization import Authorize
from hmi.store.fleet import FleetStore
from hmi.store.state_times import Span

ROBOT = "planter-02"
DECLARED = json.loads((Path(__file__).parents[2] / "charts" / "planter.json").read_text("utf-8"))
CHART = Chart(
    tuple(
        ChartState(**{**one, "entry": tuple(one["entry"]), "exit": tuple(one["exit"])}) for one in DECLARED["states"]
    ),
    tuple(ChartTransition(**one) for one in DECLARED["transitions"]),
)
BY_ID = {one.id: one for one in CHART.states}
LAP = (
    ("crane-idle", 6.0), ("dock", 7.5), ("dock-waypoint", 4.0), ("transport", 7.0), ("above-plant", 6.0),
    ("on-ground", 9.5), ("photo", 4.0), ("retract", 8.0),
)  # fmt: skip
BASE = (("hold", 40.0), ("drive", 8.0), ("settle", 4.0))
TOOL = (("tool-idle", 41.0), ("transfer", 3.0), ("drop", 2.0), ("plant", 6.0))
NOW: list[list[Any]] = [
    ["mission", 6720.0], ["plant-site", 185.0], ["base", 185.0], ["hold", 158.0], ["crane", 185.0],
    ["on-ground", 134.0], ["tool", 185.0], ["tool-idle", 51.0], ["guard", 185.0], ["area-clear", 378.0],
]  # fmt: skip


def path_of(state: str) -> list[str]:
    """Return labels, outermost first."""
    one = BY_ID[state]
    return [*(path_of(one.parent) if one.parent else []), one.label]


@dataclass
class SuperStage:
    """What the planter says now, and what is on record of it."""

    clock: Clock
    has_chart: bool = True
    is_silent: bool = False
    active: list[list[Any]] = field(default_factory=lambda: [list(one) for one in NOW])
    last: list[str] = field(default_factory=lambda: ["above-plant", "on-ground", "lowered", ""])
    set_s: float = 0.0
    events: list[RobotEvent] = field(default_factory=list)

    def reset(self) -> None:
        """Begin anew: ten minutes of laps are on record."""
        self.has_chart, self.is_silent = True, False
        self.active, self.last = [list(one) for one in NOW], ["above-plant", "on-ground", "lowered", ""]
        self.set_s = self.clock.mono_s()
        now = self.clock.utc()
        self.events = []
        for lap, ends in ((LAP, 134.0), (BASE, 158.0), (TOOL, 51.0)):
            self._laps(lap, now, ends)
        self._stay("area-clear", now - timedelta(seconds=640), now - timedelta(seconds=402))
        self._stay("person-near", now - timedelta(seconds=402), now - timedelta(seconds=378))

    def _laps(self, lap: tuple[tuple[str, float], ...], now: datetime, ends: float) -> None:
        back, at = ends, len(lap) - 1
        while back < 640:
            state, length = lap[at % len(lap)]
            self._stay(state, now - timedelta(seconds=back + length), now - timedelta(seconds=back))
            back, at = back + length, at - 1

    def _stay(self, state: str, start: datetime, end: datetime) -> None:
        one = BY_ID[state]
        data = {"state": state, "path": path_of(state), "subsystem": one.subsystem, "is_leaf": True}
        key = f"{state}-{start.timestamp():.3f}"
        length_ms = round((end - start).total_seconds() * 1000)
        left = {**data, "duration_ms": length_ms, "result": "OK" if state == "on-ground" else ""}
        self.events.append(
            RobotEvent(ROBOT, f"e{key}", "state_entered", one.label, "", data, at_utc=start, mission_id="m-0410")
        )
        self.events.append(
            RobotEvent(ROBOT, f"l{key}", "state_left", one.label, "", left, at_utc=end, mission_id="m-0410")
        )

    def speak(self, fleet: FleetStore, sheet: Callable[[str], domain.Factsheet]) -> None:
        """One beat."""
        robot = fleet.robot(ROBOT)
        chart = CHART if self.has_chart else None
        if robot is None or robot.factsheet is None or robot.factsheet.chart is not chart:
            fleet.put_factsheet(ROBOT, replace(sheet("Planter 02"), family=domain.Family.PLANTER, chart=chart))
        if self.is_silent:
            return
        now = self.clock.mono_s()
        fleet.put_heartbeat(ROBOT, boot="p" * 8, challenge="c" * 8, heard_s=now - 0.04)
        source, target, event, result = self.last
        active = tuple(ActiveState(i, self.set_s - age) for i, age in self.active)
        since = next((one.since_s for one in active if one.id == target), self.set_s)
        order = domain.Order(
            "m-0410", 1, "ab" * 32, domain.OrderStatus.RUNNING, 3, 9, 4, 1.0, 4000.0, 900.0, 80.0, None, True
        )
        fleet.put_state(
            ROBOT,
            domain.RobotState(
                domain.Mode.AUTO, ("Mission", "Plant tree 147 of 380", "Lower"), since, 1, None, order, (), None,
                domain.Stamp(now - 0.05, now), active if self.has_chart else (),
                LastTransition(source, target, event, result, since) if self.has_chart else None,
            ),
        )  # fmt: skip


class Records:
    """Played events in place of the database."""

    def __init__(self, stage: SuperStage) -> None:
        self._stage = stage

    def events(self, robot_id: str, start: datetime, end: datetime) -> list[RobotEvent]:
        """See ``StateRecords``."""
        return sorted((e for e in self._stage.events if e.robot_id == robot_id), key=lambda e: e.at_utc)

    def mission_span(self, robot_id: str, mission_id: str) -> Span | None:
        """See ``StateRecords``."""
        times = [e.at_utc for e in self._stage.events if e.mission_id == mission_id]
        return Span(min(times), max(times)) if times else None


class Desk:
    """Runs what blocks at once."""

    async def run(self, call: Callable[..., Any], *args: Any) -> Any:
        """See ``Database``."""
        return call(*args)


def router(stage: SuperStage, fleet: FleetStore, authorize: Authorize) -> APIRouter:
    """Return the real routes on played records, and the way to set the stage."""
    api = APIRouter()
    parts = StateRoutes(fleet.robot, Records(stage), Desk(), stage.clock, authorize)  # type: ignore[arg-type]
    api.include_router(state_chart_routes(parts), prefix="/api/v1")

    @api.post("/stage-super")
    async def adjust(request: Request) -> dict[str, Any]:
        wish = await request.json()
        if wish.pop("anew", False):
            stage.reset()
        if "active" in wish:
            stage.set_s = stage.clock.mono_s()
        for key, value in wish.items():
            setattr(stage, key, value)
        return {}

    return api
