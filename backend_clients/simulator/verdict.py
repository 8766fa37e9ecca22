"""Answers of the robot: every one has a code, and a sentence for the person who asked."""

from __future__ import annotations

from dataclasses import dataclass

REFUSALS: dict[str, str] = {
    # freshness, lease, order
    "retained": "The order was stored on the network and not sent now. It was ignored.",
    "stale_challenge": "The order came too late and was not carried out. Try again.",
    "expired": "The order was older than it may be and was not carried out. Try again.",
    "no_lease": "Nobody has taken control of this robot. Take control first.",
    "old_lease": "Somebody else has control of this robot now.",
    "lease_revoked": "A STOP has ended your control. Take control again.",
    "out_of_order": "A newer order was already carried out. Try again.",
    "busy": "The robot gets more orders than it can check. Wait a moment and try again.",
    # safety
    "stop_latched": "A STOP is still active. Reset it first.",
    "hardware_stop": "The red button on the machine is pressed. Release it there first.",
    "not_standing": "The robot does not stand still yet. Wait until it does.",
    "unknown_stop": "The robot does not know this STOP. Look at the list of presses again.",
    # mission
    "no_mission": "There is no mission on the robot. Send one first.",
    "wrong_mission": "The robot has another mission, or another version of it. Send it again.",
    "bad_mission": "The path of this mission cannot be driven. Plan it again.",
    "mission_too_far": "The mission starts too far from the robot. Drive it to the field first.",
    "mission_active": "Another mission is not finished. Abort it first.",
    "already_running": "The mission is running already.",
    "mission_paused": "The mission is paused. Resume it, or abort it before a new start.",
    "not_paused": "There is no paused mission to resume.",
    "nothing_to_pause": "Nothing is running that could be paused.",
    "nothing_to_abort": "There is no running or paused mission to abort.",
    "moved_while_paused": "It was moved since the pause. Drive it back to where it stopped, "
    "or plan the way back with Resume later.",
    "not_an_update": "This does not go on with the mission on the robot. Look at the mission again, then repeat.",
    "update_too_late": "The robot is past the place where the new path begins. Look at the rest again, then repeat.",
    "not_where_planned": "It does not stand where the way back begins. Plan the way back again.",
    "not_whole": "This mission was cut where it was interrupted. Send the whole mission to start fresh.",
    "manual_open": "It is being driven by hand. End driving by hand first.",
    "not_in_manual": "Driving by hand is not open. Open it first.",
    "already_home": "It is at home already.",
    # machine
    "battery_low": "The battery is too low to start. Charge it first.",
    "gnss_not_fixed": "The position is not exact enough to work. Wait for RTK fixed.",
    "tool_interlock": "The cover of the tool is open. Close it on the machine.",
    "person_ahead": "Somebody or something stands in front of the robot. Look at it before you start.",
    "weed_unsure": "It cannot tell crop and weed apart here. Look at the row before you start.",
    "crane_limit": "The crane is outside its limit. Retract it, or move it by hand.",
    "person_inside": "Somebody is within reach of the crane. Clear the area before you start.",
    "ask_person": "It could not take a seedling. Look at the tray, then retract the crane or skip the tree.",
    "function_off": "A function it needs is off. Look at its nodes.",
    "tray_empty": "The seedling tray is empty. Load a tray at the machine.",
    "mission_running": "It works on its mission. Pause it first.",
    "already_moving": "It carries out another order already. Wait, or pause it first.",
    "no_place": "The order names no place.",
    "out_of_reach": "The crane cannot reach that place from here.",
    "unknown_joint": "The machine has no such joint.",
    "no_target": "There is no tree to skip now.",
    "other_target": "It works at another tree now. Look at it and skip again.",
    "too_late": "The head plants already. Wait until it is done.",
    "unknown_node": "The robot has no such node. Look at the list again.",
    "starts_after": "Another node has to be started first.",
    "not_supported": "This machine cannot do that.",
    "simulated_reject": "The robot cannot do that now (a fault switched on in the simulator).",
}
"""Every refusal the robot can give."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What the robot decided about one order."""

    is_accepted: bool
    code: str = "ok"
    text: str = ""


OK = Verdict(True)


def accepted(code: str, text: str) -> Verdict:
    """Return an acceptance that needs a word, e.g. ``already_reset``."""
    return Verdict(True, code, text)


def refused(code: str, text: str = "") -> Verdict:
    """Return a refusal; ``text`` replaces the usual sentence of ``code``."""
    return Verdict(False, code, text or REFUSALS[code])
