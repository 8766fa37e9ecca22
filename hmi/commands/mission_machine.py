"""Whether a mission may go to another robot than the one it was planned for."""

from __future__ import annotations

from hmi.commands.ports import FleetReader
from hmi.domain.planned_machine import MACHINE, PlannedMachine
from hmi.store.missions import Mission


def planned_machine(mission: Mission, fleet: FleetReader) -> PlannedMachine | None:
    """Return the machine a mission was planned for; one that says nothing was planned for the robot it is for."""
    kept = PlannedMachine.from_json(mission.statistics.get(MACHINE))
    if kept is not None or mission.robot_id is None:
        return kept
    robot = fleet.robot(mission.robot_id)
    sheet = None if robot is None else robot.factsheet
    return None if sheet is None else PlannedMachine.of(mission.robot_id, sheet)


def misfit(mission: Mission, robot_id: str, fleet: FleetReader) -> str:
    """Say why a robot cannot drive what was planned for another one, and what to do; empty if it can.

    A robot that has not said yet what it is, is asked again when the mission is sent.
    """
    planned, robot = planned_machine(mission, fleet), fleet.robot(robot_id)
    if planned is None or planned.robot_id == robot_id or robot is None or robot.factsheet is None:
        return ""
    what = planned.ahead_of(robot.factsheet)
    if not what:
        return ""
    before = fleet.robot(planned.robot_id)
    name = planned.robot_id if before is None else before.name
    machine = f"{name}, which" if planned.family is not None else "a machine that"  # it was assumed then
    return f"It was planned for {machine} {what}. Plan the mission for {robot.name}."
