"""A planter on the stage of the screens: nodes, functions, joints and a site that a test sets by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from fastapi import APIRouter, Request
from starlette.responses import JSONResponse, Response

from hmi.domain import machine
from hmi.domain import robot as domain
from hmi.store.fleet import FleetStore

ID, NAME = "planter-09", "Planter 09"
NODES = (
    ("mission-supervisor", "Mission supervisor", 10.0, 4.0, "Supervisor", ("base", "crane")),
    ("base", "Base controller", 50.0, 11.0, "Drive", ()),
    ("crane", "Crane controller", 100.0, 18.0, "Crane", ()),
    ("rtk", "RTK receiver", 20.0, 6.0, "Localise", ()),
    ("tree-planner", "Tree planner", 2.0, 9.0, "Planter", ("stereo", "rtk")),
    ("stereo", "Stereo camera", 5.0, 38.0, "Perception", ()),
    ("person-guard", "Person guard", 10.0, 34.0, "Guard", ("stereo",)),
    ("tray-feeder", "Tray feeder", 10.0, 1.0, "Planter", ()),
    ("camera-rear", "Rear camera", 15.0, 12.0, "Perception", ()),
)
FUNCTIONS = (
    ("plant", "Plant trees", ("follow-path", "see-people", "plan-trees", "move-crane", "feed"), ()),
    ("follow-path", "Follow a path", ("localise", "base", "mission-supervisor"), ()),
    ("localise", "Locate itself", ("rtk",), ()),
    ("see-people", "Guard people", ("person-guard",), ("camera-rear",)),
    ("plan-trees", "Find planting points", ("stereo", "tree-planner"), ()),
    ("move-crane", "Move the crane", ("crane", "oil"), ()),
    ("feed", "Feed seedlings", ("tray-feeder",), ()),
    ("manual-drive", "Drive by hand", ("base",), ("camera-rear",)),
    ("manual-crane", "Crane by hand", ("move-crane",), ()),
    ("back-up", "Reverse over 0.3 m/s", ("camera-rear",), ()),
)
JOINTS = (
    machine.JointInfo("slew", "Slew", "rad", -1.9, 1.9, 0.5, -1.75, 1.75),
    machine.JointInfo("boom", "Boom", "rad", -0.4, 1.3, 0.3, -0.3, 1.2),
    machine.JointInfo("extension", "Telescope", "m", 0.0, 4.0, 0.6, None, 3.8),
)
OIL = machine.GaugeInfo("oil", "Oil", "°C", 0.0, 100.0, None, 75.0, "limit 75 °C")
TILT = machine.GaugeInfo("tilt", "Tilt", "°", 0.0, 20.0, None, 12.0, "stops at 12°")
LOG = [f"{100 + i}.000 {name} {said}" for i, (name, said) in enumerate(
    [("base", "pulse"), ("crane", "soft limit near"), ("camera-rear", "no picture: timeout"), ("base", "pulse")] * 40
)]  # fmt: skip


class MachineStage:
    """Speaks ten times a second once it was set; ``nodes`` changes nodes by name, ``oil`` what it measures."""

    def __init__(self, fleet: FleetStore, now_s: Callable[[], float], registry: Callable[[bool], None]) -> None:
        self._fleet, self._now_s, self._registry = fleet, now_s, registry
        self.wish: dict[str, Any] | None = None
        self._since_s = 0.0

    def set(self, wish: dict[str, Any]) -> None:
        """Show a machine with these changes; ``{"off": true}`` takes it away."""
        if wish.get("off"):
            self.wish = None
            self._registry(False)
            self._fleet._left.clear()  # the next is another robot, of which nothing stands at the broker
            return
        if self.wish is None:
            self._registry(True)
            self._since_s = self._now_s() - 6720
        self.wish = wish
        self._fleet.put_factsheet(ID, sheet(has_functions=not wish.get("is_mute")))

    def speak(self) -> None:
        """One beat of everything; nothing while silent."""
        wish = self.wish
        if wish is None or wish.get("is_silent"):
            return
        now = self._now_s()
        stamp = domain.Stamp(now - 0.05, now)
        fleet = self._fleet
        fleet.put_heartbeat(ID, boot="p" * 8, challenge="c" * 8, heard_s=now - 0.04)
        fleet.put_round_trip(ID, 0.104)
        fleet.put_state(ID, state(wish, self._since_s, stamp))
        is_latched = bool(wish.get("is_latched"))
        presses = (domain.Press("e" * 32, "Martha Keller", "Tablet 3", now - 5, False),) if is_latched else ()
        fleet.put_safety(ID, domain.SafetyState(False, is_latched, True, 0.0, True, presses, None, stamp))
        fleet.put_telemetry(ID, telemetry(stamp))
        gauges = {"oil": wish.get("oil", 61.0), "tilt": wish.get("tilt", 4.2)}
        joints = {"slew": 0.4, "boom": wish.get("boom", 0.7), "extension": 1.2}
        fleet.put_body(ID, machine.Body(joints, {}, gauges, None, True, wish.get("stock", 41), (), stamp))
        fleet.put_worksite(ID, site(stamp))
        if not wish.get("is_mute"):
            for node in nodes(wish.get("nodes", {}), now):
                fleet.put_node(ID, node)

    def router(self, stage_orders: list[dict[str, Any]]) -> APIRouter:
        """Return the routes that tests set it by, and its log."""
        router = APIRouter()

        @router.post("/stage-machine")
        async def set_machine(request: Request) -> dict[str, Any]:
            self.set(await request.json())
            stage_orders.clear()
            return {}

        @router.get(f"/api/v1/robots/{ID}/logs")
        async def logs(q: str = "", node: str = "", lines: int = 200) -> Response:
            if self.wish and self.wish.get("log_error"):
                return JSONResponse({"code": "no_answer", "text": self.wish["log_error"]}, 504)
            found = [one for one in LOG if q.lower() in one.lower() and (not node or f" {node} " in one)]
            return JSONResponse({"lines": found[-lines:], "found": len(found), "read": len(LOG)})

        return router


def nodes(changes: dict[str, dict[str, Any]], now_s: float) -> list[domain.Node]:
    """Return all nodes; ``age_s`` makes one old, ``since_s`` says how long it is in its state."""
    made = []
    for name, _label, rate_hz, cpu, _subsystem, _after in NODES:
        change = dict(changes.get(name, {}))
        heard_s, since_s = now_s - change.pop("age_s", 0.2), now_s - change.pop("since_s", 6000.0)
        usual = domain.Node(
            name, "started", rate_hz, cpu, 0, "", domain.Stamp(heard_s, heard_s), "main", since_s, 0.001
        )
        made.append(replace(usual, **change))
    return made


def sheet(*, has_functions: bool) -> domain.Factsheet:
    """Return what the planter says it is."""
    return domain.Factsheet(
        domain.Family.PLANTER, NAME, "TP-1", "0.9", 51.75, 5.75, 6.4, 2.6, 3.2, 4.0, 2.1, 1.2, 0.5, 0.8, 0.4, 3.0,
        True, False, "planter", "Crane", 2.0, 0.5, 3.5, 10.0, 3.0, 20.0, "Drive and crane stop, hydraulics hold",
        functions=tuple(machine.FunctionInfo(*one) for one in FUNCTIONS) if has_functions else (),
        nodes=tuple(machine.NodeInfo(name, label, group, hz, after) for name, label, hz, _, group, after in NODES)
        if has_functions else (),
        joints=JOINTS, gauges=(OIL, TILT),
    )  # fmt: skip


def state(wish: dict[str, Any], since_s: float, stamp: domain.Stamp) -> domain.RobotState:
    """Return the operating state."""
    mode = domain.Mode.STOPPED if wish.get("is_latched") else domain.Mode(wish.get("mode", "auto"))
    order = domain.Order(
        "m-0410", 1, "ab" * 32, domain.OrderStatus.RUNNING, 147, 380, 0, 0.0, 4000.0, 1500.0, 0.0, None, True
    )
    return domain.RobotState(mode, ("Mission", "Plant tree 147"), since_s, 1, None, order, (), None, stamp)


def telemetry(stamp: domain.Stamp) -> domain.Telemetry:
    """Return fast values at rest."""
    return domain.Telemetry(
        domain.Pose(51.75, 5.75, 0, 0, 0.0, 0.0, 0.0, stamp), domain.Gnss("fixed", 0.014, 27, 0.8),
        domain.Battery(0.71, 20000, False), domain.ToolState("on", True, None, None), None, None,
    )  # fmt: skip


def site(stamp: domain.Stamp) -> machine.Worksite:
    """Return where it works."""
    targets = [
        machine.Target(f"tree-{n}", n - 147.0, 2.0, "current" if n == 147 else "planned", "") for n in (147, 148)
    ]
    return machine.Worksite(3, ((-4, -4), (4, -4), (4, 4)), (), tuple(targets), stamp)
