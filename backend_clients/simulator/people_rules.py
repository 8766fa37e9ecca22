"""The rules that protect people: lost operator, lost link, an unused drive, the button, functions that went off."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from backend_clients.simulator.mission_run import AT_HOME_M

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
    if brain.machine.is_airborne and not brain.is_stopped:
        _look_after_flight(brain, now)
    if not brain.is_auto:
        return
    if brain.nodes.why_off(_function_in_use(brain)):
        brain.pause("function_off")
        return
    if brain.machine.is_airborne and brain.errand == "return-home":
        return  # it lands there, with or without anybody
    is_supervised = brain.errand_is_supervised
    if brain.run is not None and not brain.errand:
        is_supervised = brain.run.is_supervised
    if is_supervised and now - brain.operator_heard_s > OPERATOR_LOST_S:
        brain.pause("operator_lost")
    elif not is_supervised and _is_link_lost(brain, now):
        if not brain.machine.is_airborne:
            brain.pause("link_lost")
    elif not brain.errand and brain.machine.soc < brain.profile.home_below:
        brain.go_home(by="low_charge")
    elif brain.machine.soc < BATTERY_VERY_LOW and not brain.errand:
        brain.pause("battery_low")


def _look_after_flight(brain: Brain, now: float) -> None:
    """Send a UAV home that would hover until its battery is empty: without the console, or at its reserve.

    Without the console it first flies its search line to the end, which is the minimum of its mission. Whoever looks
    on while it hovers or flies it by hand decides until the battery is very low. STOP holds it wherever it is.
    """
    if brain.errand == "return-home" or brain.nodes.why_off(brain.profile.drive_function):
        return
    is_looked_on = now - brain.operator_heard_s <= OPERATOR_LOST_S
    reserve = BATTERY_VERY_LOW if is_looked_on and not brain.is_auto else brain.profile.home_below
    if brain.machine.soc < reserve:
        reason = "low_charge"
    elif brain.is_farm_known and _is_link_lost(brain, now) and not _is_on_line(brain):
        reason = "link_lost"
    else:
        return
    if brain.drive is not None:
        brain.close_drive()
    if math.dist(brain.place, brain.home) < AT_HOME_M:
        brain.pause(reason)
    else:
        brain.go_home(by=reason)


def _is_link_lost(brain: Brain, now: float) -> bool:
    return now - brain.link_heard_s > brain.config.link_lost_pause_s


def _is_on_line(brain: Brain) -> bool:
    run = brain.run
    is_at_work = run is not None and run.status == "running" and not brain.errand and not brain.is_on_lead
    return is_at_work and run is not None and run.leg.kind == "row"


def _function_in_use(brain: Brain) -> str:
    if brain.crane_task is not None:
        return "move-crane"
    return brain.profile.drive_function if brain.home_run is not None else brain.profile.work_function
