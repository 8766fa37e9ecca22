"""Guided checks of what a robot says of itself; a value that is no longer fresh has its age and proves nothing."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps

from hmi.domain.freshness import STALE_S
from hmi.domain.robot import Mode
from hmi.presenters.scene import Look, Scene, unknown
from hmi.presenters.units import age_text, number, percent

OLD_CORRECTIONS_S = 10.0
FEW_SATELLITES = 8
BACKWARDS_MPS = 0.02  # below it a standing machine only seems to creep
MAY_MOVE = "It may move. Use the red button and keep everyone away."
Check = Callable[[Scene], Look]


def _telemetry_s(scene: Scene) -> float | None:
    return scene.telemetry.pose.stamp.source_s if scene.telemetry is not None else None


def _state_s(scene: Scene) -> float | None:
    state = scene.robot.state if scene.robot is not None else None
    return state.stamp.source_s if state is not None else None


def _safety_s(scene: Scene) -> float | None:
    safety = scene.robot.safety if scene.robot is not None else None
    return safety.stamp.source_s if safety is not None else None


def _aged(true_at: Callable[[Scene], float | None], *, keeps_bad: bool = False) -> Callable[[Check], Check]:
    """Say of an old value how old it is and judge it no more; ``keeps_bad``: bad news stays bad until it is denied."""

    def around(check: Check) -> Check:
        @wraps(check)
        def look(scene: Scene) -> Look:
            one, at_s = check(scene), true_at(scene)
            if at_s is None or scene.now_s - at_s < STALE_S:
                return one
            is_ok = False if keeps_bad and one.is_ok is False else None
            return one._replace(found=f"{one.found.rstrip('.')}, {age_text(scene.now_s - at_s)} ago.", is_ok=is_ok)

        return look

    return around


@_aged(_telemetry_s, keeps_bad=True)
def battery(scene: Scene) -> Look:
    """Look how full it was: also an old low value may be why it is silent."""
    text = "How full was the battery?"
    battery = scene.telemetry.battery if scene.telemetry is not None else None
    if battery is None:
        return unknown(text)
    is_ok = battery.soc >= 0.1
    means = "The battery is nearly empty: that alone may be why. Bring a charger."
    return Look(text, f"{percent(battery.soc)} %.", is_ok, means)


@_aged(_telemetry_s)
def charging(scene: Scene) -> Look:
    """Look whether it charges."""
    text = "Does it charge?"
    battery = scene.telemetry.battery if scene.telemetry is not None else None
    if battery is None:
        return unknown(text)
    means = "It does not charge. Send it to the charger."
    return Look(text, "Yes." if battery.is_charging else "No.", battery.is_charging, means)


def position_age(scene: Scene) -> Look:
    """Look how old its position is."""
    text = "How old is its position?"
    if scene.telemetry is None:
        return unknown(text)
    age_s = scene.now_s - scene.telemetry.pose.stamp.source_s
    return Look(text, f"{age_text(age_s)}.", age_s < STALE_S, "Its computer is busy or its localisation stands still.")


@_aged(_safety_s)
def latched(scene: Scene) -> Look:
    """Look whether it says that it is stopped."""
    text = "Does it say that it is stopped?"
    safety = scene.robot.safety if scene.robot is not None else None
    if safety is None:
        return unknown(text)
    return Look(text, "Yes, latched." if safety.latched else "No.", None)


@_aged(_safety_s)
def button(scene: Scene) -> Look:
    """Look at its red button."""
    text = "Is the red button pressed?"
    safety = scene.robot.safety if scene.robot is not None else None
    if safety is None:
        return unknown(text)
    means = "Somebody pressed it. Ask why, then release it at the machine."
    return Look(text, "Yes." if safety.hardware_stop else "No.", not safety.hardware_stop, means)


@_aged(_safety_s, keeps_bad=True)
def standing(scene: Scene) -> Look:
    """Look whether it stands with its tool off; only a fresh yes is one."""
    text = "Does it measure that it stands, with its tool off?"
    safety = scene.robot.safety if scene.robot is not None else None
    if safety is None:
        return Look(text, "Not known.", None, MAY_MOVE)
    is_ok = safety.standstill and safety.tool_off
    return Look(text, "Yes." if is_ok else "No.", is_ok, MAY_MOVE)


@_aged(_safety_s)
def presses(scene: Scene) -> Look:
    """Look who pressed STOP."""
    text = "Who pressed STOP?"
    safety = scene.robot.safety if scene.robot is not None else None
    if safety is None:
        return unknown(text)
    names = sorted({one.by for one in safety.presses if not one.is_reset})
    return Look(text, f"{', '.join(names)}." if names else "The robot knows of no press.", None)


@_aged(_telemetry_s)
def speed(scene: Scene) -> Look:
    """Look how fast it is."""
    text = "How fast is it?"
    if scene.telemetry is None:
        return unknown(text)
    speed = scene.telemetry.pose.speed_mps
    way = " backwards" if speed < -BACKWARDS_MPS else ""
    return Look(text, f"{number(abs(speed), 2)} m/s{way}.", None)


@_aged(_telemetry_s)
def fix(scene: Scene) -> Look:
    """Look how good its fix is."""
    text = "How good is its fix?"
    gnss = scene.telemetry.gnss if scene.telemetry is not None else None
    if gnss is None:
        return unknown(text)
    means = "Its position is not exact: wait for RTK, or look at corrections and sky."
    return Look(text, f"{gnss.fix}, {number(gnss.accuracy_m * 100, 1)} cm.", gnss.fix == "fixed", means)


@_aged(_telemetry_s)
def corrections(scene: Scene) -> Look:
    """Look whether corrections arrive."""
    text = "Do corrections arrive?"
    gnss = scene.telemetry.gnss if scene.telemetry is not None else None
    if gnss is None or gnss.correction_age_s is None:
        return unknown(text)
    is_ok = gnss.correction_age_s <= OLD_CORRECTIONS_S
    means = "Corrections are missing: look at the base station and its radio."
    return Look(text, f"The newest is {age_text(gnss.correction_age_s)} old.", is_ok, means)


@_aged(_telemetry_s)
def satellites(scene: Scene) -> Look:
    """Look how many satellites it sees."""
    text = "How many satellites does it see?"
    gnss = scene.telemetry.gnss if scene.telemetry is not None else None
    if gnss is None:
        return unknown(text)
    means = "Few satellites: trees, roofs or a bad antenna."
    return Look(text, f"{gnss.satellites}.", gnss.satellites >= FEW_SATELLITES, means)


@_aged(_telemetry_s)
def cross_track(scene: Scene) -> Look:
    """Look how far it is from its line."""
    text = "How far is it from its line?"
    error = scene.telemetry.cross_track_m if scene.telemetry is not None else None
    return unknown(text) if error is None else Look(text, f"{number(abs(error), 2)} m.", None)


@_aged(_state_s)
def waits(scene: Scene) -> Look:
    """Look what it waits for."""
    text = "What does it wait for?"
    state = scene.robot.state if scene.robot is not None else None
    if state is None:
        return unknown(text)
    if state.hold is None:
        return Look(text, "It names nothing.", None)
    return Look(text, state.hold.text, False, f"{state.hold.text} {state.hold.clears}".strip())


@_aged(_state_s)
def mode(scene: Scene) -> Look:
    """Look what it says it does."""
    text = "What does it say it does?"
    state = scene.robot.state if scene.robot is not None else None
    if state is None:
        return unknown(text)
    path = f": {' > '.join(state.path)}" if state.path else ""
    is_bad = state.mode is Mode.FAULT
    means = "It reports a fault. Read its other alarms."
    return Look(text, f"{state.mode.value.capitalize()}{path}.", False if is_bad else None, means)


@_aged(_state_s)
def mission(scene: Scene) -> Look:
    """Look how far its mission is."""
    text = "How far is its mission?"
    order = scene.robot.state.order if scene.robot is not None and scene.robot.state is not None else None
    if order is None or order.area_m2 <= 0:
        return unknown(text)
    done = percent(min(1.0, order.area_done_m2 / order.area_m2))
    return Look(text, f"{done} % of the area, {order.status.value}.", None)


@_aged(_telemetry_s)
def obstacle(scene: Scene) -> Look:
    """Look whether something is in front of it."""
    text = "Is something in front of it?"
    if scene.telemetry is None:
        return unknown(text)
    distance = scene.telemetry.obstacle_m
    if distance is None:
        return Look(text, "It sees nothing.", True)
    means = "Something stands in its way. Look at the camera, clear the way."
    return Look(text, f"{number(distance, 1)} m ahead.", False, means)


@_aged(_telemetry_s)
def cover(scene: Scene) -> Look:
    """Look at the covers of its tool."""
    text = "Are the covers of its tool closed?"
    tool = scene.telemetry.tool if scene.telemetry is not None else None
    if tool is None:
        return unknown(text)
    means = "A cover is open. Close it at the machine."
    found = f"Yes; the tool is {tool.state}." if tool.is_interlock_ok else "No."
    return Look(text, found, tool.is_interlock_ok, means)
