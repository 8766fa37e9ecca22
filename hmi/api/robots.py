"""The registry and the newest values of robots."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, Protocol

from fastapi import APIRouter
from pydantic import AfterValidator, Field

from hmi.api.access import RobotManager, Watcher
from hmi.api.body import Body, Id, Name, Secret
from hmi.api.errors import ApiError, not_found
from hmi.api.orders import RobotId
from hmi.clock import Clock
from hmi.commands.audit_line import audit_line
from hmi.commands.lease_service import LeaseService
from hmi.commands.lease_words import asked_of, owner_of
from hmi.commands.ports import AuditSink
from hmi.domain.robot import Family, Robot
from hmi.domain.robot_address import usable_address, usable_token
from hmi.domain.role import Permission, may
from hmi.presenters import fleet as fleet_rows
from hmi.presenters.operate import Context, IsSupervised, MissionTitle, present
from hmi.presenters.start_checks import MissionFacts
from hmi.security.session_info import SessionInfo
from hmi.store.database import Database
from hmi.store.robots import RegisteredRobot, Robots

Address = Annotated[str, Field(max_length=300), AfterValidator(usable_address)]
Limit = Annotated[float, Field(gt=0, le=60)]
OPTIONAL = ("http_url", "http_token", "contact_name", "contact_phone")
Phone = Annotated[str, Field(max_length=40, pattern=r"^[0-9+ ()/.-]*\z")]


class RobotChange(Body):
    """What can be changed of a registered robot; what is left out stays as it is."""

    name: Name | None = None
    family: Literal["weeder", "planter", "uav", "other"] | None = None
    http_url: Address | None = None
    http_token: Annotated[Secret, Field(max_length=200), AfterValidator(usable_token)] | None = None
    contact_name: Name | None = None
    contact_phone: Phone | None = None
    ack_limit_s: Limit | None = None
    standstill_limit_s: Limit | None = None
    decel_mps2: Annotated[float, Field(gt=0, le=100)] | None = None
    keep_out_m: Annotated[float, Field(gt=0, le=1000)] | None = None
    is_unattended_allowed: bool | None = None


class NewRobot(RobotChange):
    """A robot to be accepted; its address and token are typed here, never taken from the wire."""

    id: Id
    name: Name
    family: Literal["weeder", "planter", "uav", "other"] = "other"


class FleetView(Protocol):
    """The newest known state of every robot."""

    def robot(self, robot_id: str) -> Robot | None:
        """Return all that is known of one."""
        ...

    def robots(self) -> list[Robot]:
        """Return every robot, registered or only heard."""
        ...


@dataclass(frozen=True, slots=True)
class RobotRoutes:
    """What the routes of robots need.

    Args:
        on_registry: called on the loop after each change, e.g. to bring the fleet store up to date.
        title_of: mission id to its name and field.
        facts_of: mission id to what the start checks need.
        is_supervised: whether somebody has to look on while a robot carries out what it has.
        is_stop_open: whether STOP holds a press at a robot that is not reset.
    """

    fleet: FleetView
    registry: Robots
    database: Database
    leases: LeaseService
    audit: AuditSink
    clock: Clock
    on_registry: Callable[[], None]
    title_of: Callable[[str], MissionTitle | None] = lambda _mission_id: None
    facts_of: Callable[[str], MissionFacts | None] = lambda _mission_id: None
    is_supervised: IsSupervised = lambda _robot, _order: True
    is_stop_open: Callable[[str], Awaitable[bool]] | None = None


def robot_routes(parts: RobotRoutes) -> APIRouter:
    """Return the routes of robots."""
    router = APIRouter(prefix="/robots", tags=["robots"])
    _add_lists(router, parts)
    _add_one(router, parts)
    _add_registry(router, parts)
    return router


def _add_lists(router: APIRouter, parts: RobotRoutes) -> None:
    @router.get("", summary="Robots of the farm with their newest values")
    async def robots(session: Watcher) -> dict[str, Any]:
        known = [r for r in parts.fleet.robots() if r.is_registered and r.farm_id == session.farm_id]
        return {"now_ms": _now_ms(parts), "robots": [_row(parts, r, session) for r in known]}

    @router.get("/new", summary="Robots heard but not registered")
    async def new(session: Watcher) -> dict[str, Any]:
        strangers = [r for r in parts.fleet.robots() if not r.is_registered]
        rows = [{"id": r.id, "model": _model(r), **fleet_rows.entry(r)} for r in strangers]
        return {"now_ms": _now_ms(parts), "robots": rows}


def _add_one(router: APIRouter, parts: RobotRoutes) -> None:
    @router.get("/{robot_id}", summary="One robot: all groups of its live topic, and its registry entry")
    async def one(robot_id: RobotId, session: Watcher) -> dict[str, Any]:
        robot = parts.fleet.robot(robot_id)
        if robot is None or robot.farm_id != session.farm_id:
            raise not_found(f"There is no robot {robot_id}.")
        entry = parts.registry.get(robot_id)
        contact = (entry.contact_name or "", entry.contact_phone or "") if entry is not None else ("", "")
        lease = parts.leases.of(robot_id)
        keep_out_m = None if entry is None else entry.keep_out_m
        context = Context(*contact, parts.title_of, parts.facts_of, parts.is_supervised, keep_out_m)
        return {
            "now_ms": _now_ms(parts),
            **present(robot, context),
            "lease": {"owner": owner_of(lease), "asked": asked_of(lease)},
            "registry": _registered(entry, session) if entry is not None else None,
        }


def _add_registry(router: APIRouter, parts: RobotRoutes) -> None:
    @router.post("", status_code=201, summary="Accept a robot")
    async def accept(body: NewRobot, session: RobotManager) -> dict[str, Any]:
        robot = _new_robot(body, session, parts.clock)
        stored = await _changing(parts, session, "accepted", robot.id, lambda: parts.registry.add(robot))
        return _registered(stored, session)

    @router.patch("/{robot_id}", summary="Change a robot's registry entry")
    async def change(robot_id: RobotId, body: RobotChange, session: RobotManager) -> dict[str, Any]:
        before = parts.registry.get(robot_id)
        if before is None:
            raise not_found(f"There is no robot {robot_id}.")
        changes = _changes(body)
        after = replace(before, **changes)
        stored = await _changing(parts, session, "changed", robot_id, lambda: parts.registry.change(after), changes)
        return _registered(stored, session)

    @router.delete("/{robot_id}", status_code=204, summary="Take a robot out of the registry; its records stay")
    async def remove(robot_id: RobotId, session: RobotManager) -> None:
        await _refuse_while_stopped(parts, robot_id)
        await _changing(parts, session, "removed", robot_id, lambda: parts.registry.remove(robot_id))
        parts.leases.robot_removed(robot_id)


async def _refuse_while_stopped(parts: RobotRoutes, robot_id: str) -> None:
    """A robot that was told to stop and did not confirm may still drive: nobody may lose sight of it."""
    robot = parts.fleet.robot(robot_id)
    safety = robot.safety if robot is not None else None
    is_latched = safety is not None and (safety.latched or any(not press.is_reset for press in safety.presses))
    if is_latched or (parts.is_stop_open is not None and await parts.is_stop_open(robot_id)):
        name = robot.name if robot is not None else robot_id
        text = f"A STOP at {name} is not reset. Reset it, then remove the robot. It stays listed until it answers."
        raise ApiError(409, "stop_open", text)


def _new_robot(body: NewRobot, session: SessionInfo, clock: Clock) -> RegisteredRobot:
    given = {k: v for k, v in body.model_dump().items() if v is not None and k != "family"}
    return RegisteredRobot(
        farm_id=session.farm_id, added_by=session.user_id, added_at=clock.utc(), family=Family(body.family), **given
    )


def _changes(body: RobotChange) -> dict[str, Any]:
    """Return what a body changes; null takes away what may be missing and leaves the rest as it is."""
    given = {k: getattr(body, k) for k in body.model_fields_set}
    if given.get("family") is not None:
        given["family"] = Family(given["family"])
    return {k: v for k, v in given.items() if v is not None or k in OPTIONAL}


async def _changing(
    parts: RobotRoutes,
    session: SessionInfo,
    outcome: str,
    robot_id: str,
    work: Callable[[], Any],
    data: dict[str, Any] | None = None,
) -> Any:
    """Change the registry in a thread, tell the fleet store, write the audit; also when STOP could not be told."""
    try:
        return await parts.database.run(work)
    finally:
        parts.on_registry()
        told = {k: "***" if k == "http_token" else v for k, v in (data or {}).items()}
        parts.audit.append(
            audit_line(session, "robot", outcome, f"{robot_id} {outcome}", ref=robot_id, robot_id=robot_id, data=told)
        )


def _row(parts: RobotRoutes, robot: Robot, session: SessionInfo) -> dict[str, Any]:
    sheet = robot.factsheet
    tool_width_m = sheet.tool_width_m if sheet is not None and sheet.tool_width_m > 0 else None
    row = {"id": robot.id, **fleet_rows.entry(robot), "tool_width_m": tool_width_m}
    entry = parts.registry.get(robot.id)
    if entry is None:
        return row
    told = _registered(entry, session)
    return {**told, **row, "family": told["family"], "name": told["name"]}


def _registered(robot: RegisteredRobot, session: SessionInfo) -> dict[str, Any]:
    told = {
        "id": robot.id,
        "name": robot.name,
        "family": robot.family.value,
        "contact_name": robot.contact_name,
        "contact_phone": robot.contact_phone,
        "ack_limit_s": robot.ack_limit_s,
        "standstill_limit_s": robot.standstill_limit_s,
        "decel_mps2": robot.decel_mps2,
        "keep_out_m": robot.keep_out_m,
        "is_unattended_allowed": robot.is_unattended_allowed,
        "added_by": robot.added_by,
        "added_utc": robot.added_at.isoformat(timespec="milliseconds"),
    }
    if not may(session.role, Permission.MANAGE_ROBOTS):  # where a robot listens is nobody else's business
        return told
    return {**told, "http_url": robot.http_url, "has_http_token": bool(robot.http_token)}


def _model(robot: Robot) -> str:
    return robot.factsheet.model if robot.factsheet is not None else ""


def _now_ms(parts: RobotRoutes) -> float:
    return round(parts.clock.mono_s() * 1000, 1)
