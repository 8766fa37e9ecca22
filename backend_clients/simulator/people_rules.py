"""The rules that protect people: lost operator, lost link, an unused drive, the button, functions that went off."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from backend_clients.simulator.brain import Brain

OPERATOR_LOST_S = 3.5  # operator pulses come at 1 Hz; same figure as common ground stations
MANUAL_LOST_S = 10.0  # an open drive nobody uses is closed
BATTERY_VERY_LOW = 0.1


def check(brain: Brain) -> None:
    """Pause, close or send home what must not go on; on the clock, never hastened."""
    now = brain.clock.mono_s()
    brain.nodes.look(now, brain.mono_ms(), is_tool_locked=brain.machine.is_cover_open)
    if brain.machine.is_hardware_stop != brain.is_button_known:
        brain.button_changed()
    if brain.drive is not None and now - max(brain.drive.heard_s, brain.operator_heard_s) > MANUAL_LOST_S:
        brain.close_drive()
    if brain.drive is not None and brain.nodes.why_off(brain.profile.hand_function):
        brain.close_drive()
    if not brain.is_auto:
        return
    if brain.nodes.why_off(_function_in_use(brain)):
        brain.pause("function_off")
        return
    is_supervised = brain.errand_is_supervised
    if brain.run is not None and not brain.errand:
        is_supervised = brain.run.is_supervised
    if is_supervised and now - brain.operator_heard_s > OPERATOR_LOST_S:
        brain.pause("operator_lost")
    elif not is_supervised and now - brain.link_heard_s > brain.config.link_lost_pause_s:
        brain.pause("link_lost")
    elif not brain.errand and brain.machine.soc < brain.profile.home_below:
        brain.go_home(by="low_charge")
    elif brain.machine.soc < BATTERY_VERY_LOW and not brain.errand:
        brain.pause("battery_low")


def _function_in_use(brain: Brain) -> str:
    if brain.crane_task is not None:
        return "move-crane"
    return brain.profile.drive_function if brain.home_run is not None else brain.profile.work_function
