"""Why a robot is not moving, in a farmer's words: what it is, what clears it, who can."""

from __future__ import annotations

from backend_clients.edge.messages_up import Fault, Hold

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
    "rtk_float": ("Its position is not exact enough to weed.", "It goes on by itself when RTK is fixed.", ""),
    "tool_interlock": ("The laser cover is open.", "Close the cover at the machine.", "person at the machine"),
    "start_horn": ("The horn sounds before it moves.", "It moves in a moment.", ""),
}

_FAULTS: dict[str, tuple[str, str, str]] = {
    "hardware-stop": ("high", "The red button on the machine is pressed.", "Release it at the machine."),
    "person-ahead": (
        "high",
        "Somebody or something stands in front of the machine.",
        "Look at the camera; clear the way.",
    ),
    "tool-interlock": ("high", "The laser cover is open, the laser cannot fire.", "Close the cover at the machine."),
    "rtk-float": (
        "medium",
        "RTK is not fixed, the position may be wrong by 0.35 m.",
        "Wait, or check the base station.",
    ),
    "battery-low": ("medium", "The battery is below 20 %.", "Plan to charge it."),
    "battery-very-low": ("high", "The battery is below 10 %.", "Charge it now."),
    "battery-empty": ("critical", "The battery is empty.", "Bring a charger to the machine."),
}


def hold(code: str, *, detail: str = "") -> Hold:
    """Return the reason named ``code``; ``detail`` replaces its first sentence."""
    text, clears, who = _HOLDS[code]
    return Hold(code=code, text=detail or text, clears=clears, who=who)


def fault(code: str) -> Fault:
    """Return the active error named ``code``."""
    level, text, hint = _FAULTS[code]
    return Fault(code=code, level=level, text=text, hint=hint)  # type: ignore[arg-type]
