"""Why a robot is not moving, in a farmer's words: what it is, what clears it, who can."""

from __future__ import annotations

from backend_clients.edge.messages_up import Fault, Hold
from backend_clients.simulator.families import WEEDER
from backend_clients.simulator.profile import Words

_HOLDS: dict[str, tuple[str, str, str]] = {
    "stop_latched": ("A STOP was pressed.", "Check the area and reset the STOP.", "operator"),
    "hardware_stop": (
        "The red button on the machine is pressed.",
        "Release it at the machine.",
        "person at the machine",
    ),
    "battery_empty": ("The battery is empty.", "Bring a charger to the machine.", "person at the machine"),
    "paused": ("Paused by an operator.", "Resume the mission.", "operator"),
    "operator_lost": (
        "Paused by itself: no page of its operator was open.",
        "Take control and resume the mission.",
        "operator",
    ),
    "link_lost": (
        "Paused by itself: it did not hear the farm any more.",
        "Look that the link is steady and resume the mission.",
        "operator",
    ),
    "battery_low": ("Paused by itself: the battery is low.", "Charge it, then resume the mission.", "operator"),
    "after_stop": ("Paused after a STOP.", "Resume the mission.", "operator"),
    "rebooted": ("Paused: the robot was switched off or restarted.", "Resume the mission.", "operator"),
    "continued": ("Ready to go on where it was interrupted.", "Slide to resume.", "operator"),
    "manual": ("Paused for driving by hand.", "Resume the mission.", "operator"),
    "low_charge": ("Paused to charge.", "Charged, somebody on the farm starts it again.", ""),
    "return_home": ("Paused to return home.", "Plan the way back to where it stopped.", "operator"),
    "moved_while_paused": (
        "It was moved since the pause.",
        "Drive it back to where it stopped, or plan the way back with Resume later.",
        "operator",
    ),
    "person_ahead": (
        "Somebody or something stands in front of it.",
        "Clear the way; it goes on by itself after the horn.",
        "person at the machine",
    ),
    "way_blocked": (
        "Somebody or something stands in front of it, or did while you held the pad.",
        "Let go and look. It drives ahead when the way is free and you press again.",
        "operator",
    ),
    "robot_ahead": (
        "Another robot stands in its way.",
        "It goes on by itself after the horn when the other has left; else somebody of the farm leads it past.",
        "",
    ),
    "rtk_float": ("Its position is not exact enough to work.", "It goes on by itself when RTK is fixed.", ""),
    "tool_interlock": ("The {cover} is open.", "Close it at the machine.", "person at the machine"),
    "weed_unsure": (
        "It cannot tell crop and weed apart here.",
        "Look at the row. It leaves these plants and goes on by itself after some minutes.",
        "operator",
    ),
    "crane_limit": (
        "The crane is outside its limit.",
        "Retract the crane, or move it by hand.",
        "operator",
    ),
    "person_inside": (
        "Somebody is within reach of the crane.",
        "Clear the area; it goes on by itself after the horn.",
        "person at the machine",
    ),
    "ask_person": (
        "It could not take a seedling three times.",
        "Look at the tray and the arm, then retract the crane or skip the tree.",
        "operator",
    ),
    "function_off": ("Paused by itself: a part of its software did not run.", "Resume the mission.", "operator"),
    "tray_empty": ("The seedling tray is empty.", "Load a tray at the machine.", "person at the machine"),
    "start_horn": ("The horn sounds before it moves.", "It moves in a moment.", ""),
    "climbing": ("It climbs to the height of its path.", "It sets off in a moment.", ""),
}

_FAULTS: dict[str, tuple[str, str, str]] = {
    "hardware-stop": ("high", "The red button on the machine is pressed.", "Release it at the machine."),
    "person-ahead": (
        "high",
        "Somebody or something stands in front of the machine.",
        "Look at the camera; clear the way.",
    ),
    "tool-interlock": ("high", "The {cover} is open, the {tool} cannot work.", "Close the cover at the machine."),
    "weed-unsure": ("medium", "It cannot tell crop and weed apart here.", "Look at the row."),
    "crane-limit": (
        "high",
        "The crane is outside its limit: joint 3 at 97 %.",
        "Retract the crane, or move it by hand.",
    ),
    "person-inside": (
        "high",
        "Somebody is within reach of the crane.",
        "Look at the camera; clear the area.",
    ),
    "ask-person": (
        "medium",
        "It could not take a seedling three times.",
        "Look at the tray and the arm, then retract the crane or skip the tree.",
    ),
    "tray-low": ("low", "Fewer than 15 seedlings are left.", "Bring a tray."),
    "tray-empty": ("medium", "The seedling tray is empty.", "Load a tray at the machine."),
    "reserve-near": ("medium", "The battery is near its reserve; it returns by itself.", "Let it return."),
    "rtk-float": (
        "medium",
        "RTK is not fixed, the position may be wrong by 0.35 m.",
        "Wait, or check the base station.",
    ),
    "battery-low": ("medium", "The battery is below 20 %.", "Plan to charge it."),
    "battery-very-low": ("high", "The battery is below 10 %.", "Charge it now."),
    "battery-empty": ("critical", "The battery is empty.", "Bring a charger to the machine."),
}


def hold(code: str, words: Words = WEEDER.words, *, detail: str = "") -> Hold:
    """Return the reason named ``code``; ``detail`` replaces its first sentence."""
    text, clears, who = _HOLDS[code]
    return Hold(code=code, text=detail or _named(text, words), clears=clears, who=who)


def fault(code: str, words: Words = WEEDER.words) -> Fault:
    """Return the active error named ``code``."""
    level, text, hint = _FAULTS[code]
    return Fault(code=code, level=level, text=_named(text, words), hint=hint)  # type: ignore[arg-type]


def _named(text: str, words: Words) -> str:
    return text.format(cover=words.cover.lower(), tool=words.tool.lower())
