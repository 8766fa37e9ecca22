"""What an entry waits for: one sentence, the most important reason first, with what clears it and who can.

The order of the questions is the order of importance: what stands still until a person acts comes before what
passes by itself. A fact that is missing is a reason to wait, never a condition that holds.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from hmi.domain.mission import UNDER_WAY, MissionStatus
from hmi.domain.queue.blackout import blocked_until
from hmi.domain.queue.conditions import unmet
from hmi.domain.queue.entry import Entry
from hmi.domain.queue.facts import FRESH_S, Facts, MissionFacts, RobotFacts
from hmi.domain.queue.reason import Waiting, Who, clock_text
from hmi.domain.robot import Mode, OrderStatus

_LOADED_HERE = frozenset({MissionStatus.SENT, MissionStatus.ACCEPTED})


class Step(StrEnum):
    """What the queue does next with an entry."""

    WAIT = "wait"
    SEND = "send"
    START = "start"
    FOLLOW = "follow"


@dataclass(frozen=True, slots=True)
class Verdict:
    """The next step and the one reason that is shown."""

    step: Step
    waiting: Waiting


def why_waiting(entry: Entry, facts: Facts) -> Verdict:
    """Judge one entry. ``SEND`` moves nothing; ``START`` is said only when every question has a good answer."""
    mission = facts.mission
    if mission is None:
        return _wait("mission_gone", "Its mission is not stored any more.", "Take it out of the queue.", Who.PLANNER)
    if mission.status in UNDER_WAY:
        return Verdict(Step.FOLLOW, _under_way(mission, facts))
    reason = _not_its_turn(entry, facts) or _robot_cannot(entry, facts, mission)
    if reason is not None:
        return Verdict(Step.WAIT, reason)
    robot = facts.robot
    assert robot is not None
    if robot.held_id != entry.mission_id or robot.order is not OrderStatus.LOADED:
        return _to_send(entry, facts, robot, mission)
    if robot.held_sha256 != mission.sha256:
        text = f"{robot.name} holds another version of {mission.name}."
        return Verdict(Step.SEND, Waiting("other_version", text, "It is sent again.", Who.ITSELF))
    if not entry.is_unattended:
        return Verdict(Step.WAIT, _ready(entry, facts, robot))
    blocked = _may_not_start(entry, facts, robot, mission)
    if blocked is not None:
        return Verdict(Step.WAIT, blocked)
    return Verdict(Step.START, Waiting("starting", f"Starts on {robot.name} now.", "", Who.ITSELF))


def _ready(entry: Entry, facts: Facts, robot: RobotFacts) -> Waiting:
    """A person decides; what somebody set as a condition is said, and holds nobody up who stands beside the robot."""
    text, blocked = f"Ready on {robot.name}. The person on site starts it with a slide.", unmet(entry, facts)
    if blocked is not None:
        text = f"Ready on {robot.name}, but its conditions do not hold. {blocked.text} The person on site decides."
    return Waiting("ready", text, "Slide to start on Operate.", Who.OPERATOR)


def _wait(code: str, text: str, clears: str, who: Who, at: datetime | None = None) -> Verdict:
    return Verdict(Step.WAIT, Waiting(code, text, clears, who, at))


def _under_way(mission: MissionFacts, facts: Facts) -> Waiting:
    name = facts.robot.name if facts.robot is not None else "The robot"
    if mission.status is MissionStatus.RUNNING:
        return Waiting("running", f"{name} drives it.", "", Who.ITSELF)
    why = facts.robot.hold if facts.robot is not None else ""
    text = f"Paused on {name}. {why or 'A person resumes it on Operate.'}"
    return Waiting("paused", text, "The queue never resumes by itself.", Who.OPERATOR)


def _not_its_turn(entry: Entry, facts: Facts) -> Waiting | None:
    if facts.frozen:
        return Waiting("frozen", facts.frozen, "A person releases the queue.", Who.OPERATOR)
    if entry.earliest is not None and not entry.is_due(facts.now):
        text = f"Waits until {clock_text(entry.earliest, facts.now, facts.zone)}."
        return Waiting("not_due", text, "", Who.ITSELF, entry.earliest)
    if facts.ahead:
        running = f"{facts.ahead}, which runs" if facts.is_ahead_running else f"{facts.ahead}, before it in the queue"
        return Waiting("not_first", f"Waits for {running}.", "Move it up to change the order.", Who.ITSELF)
    if facts.pause is not None and facts.now < facts.pause[1]:
        why, until = facts.pause
        text = f"{why} Tries again at {clock_text(until, facts.now, facts.zone, seconds=True)}."
        return Waiting("not_sent", text, "", Who.ITSELF, until)
    return None


def _robot_cannot(entry: Entry, facts: Facts, mission: MissionFacts) -> Waiting | None:
    robot = facts.robot
    if robot is None:
        text = f"{entry.robot_id} is not in the list of robots."
        return Waiting("no_robot", text, "Choose another robot.", Who.PLANNER)
    if robot.link_age_s is None or robot.link_age_s > FRESH_S:
        since = "" if robot.link_age_s is None else f" for {_age(robot.link_age_s)}"
        return Waiting("no_link", f"No link to {robot.name}{since}.", "Look at its power and radio.", Who.SITE)
    if robot.stop:
        return Waiting("stopped", f"{robot.name}: {robot.stop}", "Reset the stop on Operate.", Who.OPERATOR)
    if robot.safety_age_s is None or robot.safety_age_s > FRESH_S:
        text = f"The safety state of {robot.name} is not known right now."
        return Waiting("safety_unknown", text, "Look at the machine.", Who.SITE)
    if robot.state_age_s is None or robot.state_age_s > FRESH_S:
        text = f"What {robot.name} is doing is not known right now."
        return Waiting("state_unknown", text, "Look at the machine.", Who.SITE)
    return _robot_busy(entry, facts, robot)


def _robot_busy(entry: Entry, facts: Facts, robot: RobotFacts) -> Waiting | None:
    held = robot.held_name or robot.held_id or "another mission"
    if robot.mode is Mode.MANUAL:
        return Waiting("manual", f"Waits for {robot.name}: a person drives it by hand.", "End manual.", Who.OPERATOR)
    if robot.order is OrderStatus.RUNNING:
        return Waiting("busy", f"Waits for {robot.name}: it is running {held}.", "It ends.", Who.ITSELF)
    if robot.order is OrderStatus.PAUSED:
        text = f"Waits for {robot.name}: {held} is paused on it."
        return Waiting("paused_other", text, "Resume or abort it on Operate.", Who.OPERATOR)
    if robot.mode is Mode.FAULT or robot.trouble:
        text = f"{robot.name}: {robot.trouble or 'it reports a fault.'}"
        return Waiting("fault", text, "Look at its alarms.", Who.OPERATOR)
    if robot.mode is not Mode.IDLE and robot.mode is not Mode.PAUSED:
        known = {Mode.UNKNOWN: "its state is not known", Mode.STOPPED: "it is stopped"}
        words = known.get(robot.mode, "it is moving")
        return Waiting("busy", f"Waits for {robot.name}: {words}.", "It stands idle.", Who.ITSELF)
    is_other = robot.order is OrderStatus.LOADED and robot.held_id != entry.mission_id
    if is_other and not facts.may_replace:
        text = f"{robot.name} holds {held}, which nobody started. Start it there, or take it off."
        return Waiting("holds_other", text, "Start that one, or take it off the robot.", Who.OPERATOR)
    return None


def _to_send(entry: Entry, facts: Facts, robot: RobotFacts, mission: MissionFacts) -> Verdict:
    if entry.is_unattended and entry.is_missed(facts.now):
        return Verdict(Step.WAIT, _missed(entry, facts))
    if mission.status in _LOADED_HERE and robot.held_id == entry.mission_id:
        # it was sent again and the robot still tells of the last life
        text = f"Sent to {robot.name}; waits until it is read back."
        return _wait("reading_back", text, "", Who.ITSELF)
    text = f"Is sent to {robot.name} now. Sending does not move it."
    return Verdict(Step.SEND, Waiting("sending", text, "", Who.ITSELF))


def _may_not_start(entry: Entry, facts: Facts, robot: RobotFacts, mission: MissionFacts) -> Waiting | None:
    if not robot.is_unattended_allowed:
        text = f"{robot.name} may not run without a person. An admin can allow it, or start it yourself."
        return Waiting("robot_attended", text, "An admin allows it under Robots.", Who.ADMIN)
    if mission.is_supervised:
        text = f"{mission.name} is a supervised mission: a person starts it."
        return Waiting("mission_supervised", text, "Start it yourself, or mark it unattended.", Who.OPERATOR)
    if entry.is_missed(facts.now):
        return _missed(entry, facts)
    if facts.owner:
        text = f"{facts.owner} has control of {robot.name}."
        return Waiting("controlled", text, "They give control up; then arm the queue again.", Who.OPERATOR)
    if facts.armed_until is None:
        why = f"{facts.disarmed} " if facts.disarmed else ""
        text = f"{why}Not armed: nothing starts by itself until a person slides to arm {robot.name}."
        return Waiting("not_armed", text, "Slide to arm the queue.", Who.OPERATOR)
    if entry.started_at is not None:
        return Waiting("was_started", "It was started already. Start it yourself.", "Slide to start.", Who.OPERATOR)
    if robot.cannot:
        return Waiting("function_off", f"{robot.name}: {robot.cannot}", "Turn it on under Supervisor.", Who.ADMIN)
    window = blocked_until(facts.blackouts, entry.robot_id, facts.now, facts.zone)
    if window is not None:
        name, free = window[0].name, window[1]
        text = f"Waits for the end of {name}: {clock_text(free, facts.now, facts.zone)}."
        return Waiting("blackout", text, "", Who.ITSELF, free)
    return unmet(entry, facts)


def _missed(entry: Entry, facts: Facts) -> Waiting:
    assert entry.earliest is not None
    at = clock_text(entry.earliest, facts.now, facts.zone)
    text = f"Missed its start at {at} by more than {_age(entry.window_s)}. Set a new time, or start it yourself."
    return Waiting("missed", text, "Set a new time.", Who.PLANNER)


def _age(seconds: float) -> str:
    if seconds < 60:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.0f} h"


__all__ = ["Step", "Verdict", "Waiting", "Who", "why_waiting"]
