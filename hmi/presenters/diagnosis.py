"""The guided check of an alarm: looks at live values one after the other and says what it found and what follows.

A check that cannot tell says so; it never guesses.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from hmi.domain.freshness import STALE_S
from hmi.domain.robot import Mode
from hmi.presenters import node_checks, station_checks
from hmi.presenters.scene import Look, Scene, unknown
from hmi.presenters.units import age_text, number, percent

SLOW_LINK_S = 0.3  # driving by hand ends above it
OLD_CORRECTIONS_S = 10.0
FEW_SATELLITES = 8
BACKWARDS_MPS = 0.02  # below it a standing machine only seems to creep


def diagnose(names: Sequence[str], scene: Scene) -> dict[str, Any]:
    """Return the checks of a type in their order, and the conclusion: what the first bad one means."""
    looks = [CHECKS[name](scene) for name in names]
    bad = [one for one in looks if one.is_ok is False and one.means]
    blind = [one for one in looks if one.is_ok is None]
    if bad:
        conclusion = bad[0].means
    elif blind and len(blind) == len(looks):
        conclusion = "Nothing could be checked from here. Look at the machine."
    else:
        conclusion = "Nothing else is wrong that can be seen from here. Follow the steps of the alarm."
    return {
        "steps": [{"text": one.text, "found": one.found, "ok": one.is_ok} for one in looks],
        "conclusion": conclusion,
    }


def _broker(scene: Scene) -> Look:
    means = "The console has lost the broker: look at the server and the network, not at the robots."
    return Look(
        "Is the console connected to the broker?", _yes(scene.is_broker_up, "Yes.", "No."), scene.is_broker_up, means
    )


def _others(scene: Scene) -> Look:
    text = "Are other robots heard?"
    heard = sum(1 for one in scene.others if one.link.is_online)
    if not scene.others:
        return Look(text, "There are no others.", None)
    is_ok = heard > 0
    means = "No robot is heard: look at the mast, the router and the broker, not at this robot."
    return Look(text, f"{heard} of {len(scene.others)} are heard.", is_ok, means)


def _heard(scene: Scene) -> Look:
    text = "Is the robot heard?"
    if scene.robot is None:
        return unknown(text)
    link = scene.robot.link
    if link.heard_s is None:
        return Look(text, "Not since Headland was started.", False, _SILENT)
    age_s = scene.now_s - link.heard_s
    return Look(text, f"Last {age_text(age_s)} ago.", link.is_online, _SILENT)


def _goodbye(scene: Scene) -> Look:
    text = "How did it fall silent?"
    if scene.robot is None or scene.robot.link.heard_s is None:
        return unknown(text)
    if scene.robot.link.is_online:
        return Look(text, "It is heard now.", True)
    state = scene.robot.state
    doing = "nothing is known of what it did" if state is None else f"it was {state.mode.value}"
    how = "It said that it was shut down" if scene.robot.link.said_goodbye else "Without a word"
    return Look(text, f"{how}; {doing}.", None)


def _gateway(scene: Scene) -> Look:
    text = "Does the STOP service run?"
    part = scene.parts.get("stop")
    if part is None:
        return unknown(text)
    is_ok = part.get("state") == "ok"
    means = "The STOP service is down. Keep somebody at the red buttons."
    return Look(text, _yes(is_ok, "Yes.", f"It is {part.get('state')}."), is_ok, means)


def _battery(scene: Scene) -> Look:
    text = "How full was the battery?"
    battery = scene.telemetry.battery if scene.telemetry is not None else None
    if battery is None:
        return unknown(text)
    is_ok = battery.soc >= 0.1
    means = "The battery is nearly empty: that alone may be why. Bring a charger."
    return Look(text, f"{percent(battery.soc)} %.", is_ok, means)


def _charging(scene: Scene) -> Look:
    text = "Does it charge?"
    battery = scene.telemetry.battery if scene.telemetry is not None else None
    if battery is None:
        return unknown(text)
    means = "It does not charge. Send it to the charger."
    return Look(text, _yes(battery.is_charging, "Yes.", "No."), battery.is_charging, means)


def _delay(scene: Scene) -> Look:
    text = "How long is the way to it and back?"
    if scene.robot is None or scene.robot.link.rtt_s is None:
        return unknown(text)
    worst = scene.robot.link.rtt_max_s or scene.robot.link.rtt_s
    means = "The link was slow before: weak radio or mobile signal at that place."
    return Look(text, f"{worst * 1000:.0f} ms at worst in the last minute heard.", worst <= SLOW_LINK_S, means)


def _position_age(scene: Scene) -> Look:
    text = "How old is its position?"
    if scene.telemetry is None:
        return unknown(text)
    age_s = scene.now_s - scene.telemetry.pose.stamp.source_s
    return Look(text, f"{age_text(age_s)}.", age_s < STALE_S, "Its computer is busy or its localisation stands still.")


def _latched(scene: Scene) -> Look:
    text = "Does it say that it is stopped?"
    safety = scene.robot.safety if scene.robot is not None else None
    if safety is None:
        return unknown(text)
    return Look(text, _yes(safety.latched, "Yes, latched.", "No."), None)


def _button(scene: Scene) -> Look:
    text = "Is the red button pressed?"
    safety = scene.robot.safety if scene.robot is not None else None
    if safety is None:
        return unknown(text)
    means = "Somebody pressed it. Ask why, then release it at the machine."
    return Look(text, _yes(safety.hardware_stop, "Yes.", "No."), not safety.hardware_stop, means)


def _standing(scene: Scene) -> Look:
    text = "Does it measure that it stands, with its tool off?"
    safety = scene.robot.safety if scene.robot is not None else None
    if safety is None:
        return unknown(text)
    is_fresh = scene.now_s - safety.stamp.source_s < STALE_S
    is_ok = safety.standstill and safety.tool_off
    found = _yes(is_ok, "Yes", "No") + ("." if is_fresh else f", {age_text(scene.now_s - safety.stamp.source_s)} ago.")
    means = "It may move. Use the red button and keep everyone away."
    return Look(text, found, is_ok if is_fresh or not is_ok else None, means)


def _presses(scene: Scene) -> Look:
    text = "Who pressed STOP?"
    safety = scene.robot.safety if scene.robot is not None else None
    if safety is None:
        return unknown(text)
    names = sorted({one.by for one in safety.presses if not one.is_reset})
    return Look(text, f"{', '.join(names)}." if names else "The robot knows of no press.", None)


def _speed(scene: Scene) -> Look:
    text = "How fast is it?"
    if scene.telemetry is None:
        return unknown(text)
    speed = scene.telemetry.pose.speed_mps
    way = " backwards" if speed < -BACKWARDS_MPS else ""
    return Look(text, f"{number(abs(speed), 2)} m/s{way}.", None)


def _fix(scene: Scene) -> Look:
    text = "How good is its fix?"
    gnss = scene.telemetry.gnss if scene.telemetry is not None else None
    if gnss is None:
        return unknown(text)
    means = "Its position is not exact: wait for RTK, or look at corrections and sky."
    return Look(text, f"{gnss.fix}, {number(gnss.accuracy_m * 100, 1)} cm.", gnss.fix == "fixed", means)


def _corrections(scene: Scene) -> Look:
    text = "Do corrections arrive?"
    gnss = scene.telemetry.gnss if scene.telemetry is not None else None
    if gnss is None or gnss.correction_age_s is None:
        return unknown(text)
    is_ok = gnss.correction_age_s <= OLD_CORRECTIONS_S
    means = "Corrections are missing: look at the base station and its radio."
    return Look(text, f"The newest is {age_text(gnss.correction_age_s)} old.", is_ok, means)


def _satellites(scene: Scene) -> Look:
    text = "How many satellites does it see?"
    gnss = scene.telemetry.gnss if scene.telemetry is not None else None
    if gnss is None:
        return unknown(text)
    means = "Few satellites: trees, roofs or a bad antenna."
    return Look(text, f"{gnss.satellites}.", gnss.satellites >= FEW_SATELLITES, means)


def _others_fix(scene: Scene) -> Look:
    text = "Do other robots have an exact position?"
    fixes = [one.telemetry.gnss.fix for one in scene.others
             if one.link.is_online and one.telemetry is not None and one.telemetry.gnss is not None]  # fmt: skip
    if not fixes:
        return unknown(text)
    good = sum(1 for fix in fixes if fix == "fixed")
    means = "No robot has an exact position: it is the base station."
    return Look(text, f"{good} of {len(fixes)}.", good > 0, means)


def _cross_track(scene: Scene) -> Look:
    text = "How far is it from its line?"
    error = scene.telemetry.cross_track_m if scene.telemetry is not None else None
    return unknown(text) if error is None else Look(text, f"{number(abs(error), 2)} m.", None)


def _waits(scene: Scene) -> Look:
    text = "What does it wait for?"
    state = scene.robot.state if scene.robot is not None else None
    if state is None:
        return unknown(text)
    if state.hold is None:
        return Look(text, "It names nothing.", None)
    return Look(text, state.hold.text, False, f"{state.hold.text} {state.hold.clears}".strip())


def _mode(scene: Scene) -> Look:
    text = "What does it say it does?"
    state = scene.robot.state if scene.robot is not None else None
    if state is None:
        return unknown(text)
    path = f": {' > '.join(state.path)}" if state.path else ""
    is_bad = state.mode is Mode.FAULT
    means = "It reports a fault. Read its other alarms."
    return Look(text, f"{state.mode.value.capitalize()}{path}.", False if is_bad else None, means)


def _mission(scene: Scene) -> Look:
    text = "How far is its mission?"
    order = scene.robot.state.order if scene.robot is not None and scene.robot.state is not None else None
    if order is None or order.area_m2 <= 0:
        return unknown(text)
    done = percent(min(1.0, order.area_done_m2 / order.area_m2))
    return Look(text, f"{done} % of the area, {order.status.value}.", None)


def _obstacle(scene: Scene) -> Look:
    text = "Is something in front of it?"
    if scene.telemetry is None:
        return unknown(text)
    distance = scene.telemetry.obstacle_m
    if distance is None:
        return Look(text, "It sees nothing.", True)
    means = "Something stands in its way. Look at the camera, clear the way."
    return Look(text, f"{number(distance, 1)} m ahead.", False, means)


def _cover(scene: Scene) -> Look:
    text = "Are the covers of its tool closed?"
    tool = scene.telemetry.tool if scene.telemetry is not None else None
    if tool is None:
        return unknown(text)
    means = "A cover is open. Close it at the machine."
    return Look(text, _yes(tool.is_interlock_ok, f"Yes; the tool is {tool.state}.", "No."), tool.is_interlock_ok, means)


def _clock(scene: Scene) -> Look:
    text = "By how much do the clocks differ?"
    offset = scene.robot.link.wall_offset_s if scene.robot is not None else None
    if offset is None:
        return unknown(text)
    return Look(text, f"{number(offset, 1)} s.", abs(offset) < 1, "Set up the time service on the robot's computer.")


def _disk(scene: Scene) -> Look:
    text = "How much room is left?"
    if scene.disk is None:
        return unknown(text)
    free, share = scene.disk
    return Look(text, f"{free / 1e9:.1f} GB, {percent(share)} %.", share >= 0.05, "The disk is full: free some room.")


def _database(scene: Scene) -> Look:
    means = "The database does not answer: look at its disk or its server."
    found = _yes(scene.is_database_up, "Yes.", "No.")
    return Look("Does the database answer?", found, scene.is_database_up, means)


def _writers(scene: Scene) -> Look:
    bad = [f"{name}: {text}" for name, text in scene.writers.items() if text]
    found = "; ".join(bad) if bad else "All do."
    return Look("Do the records get written?", found, not bad, "Records are not written: look at disk and database.")


def _yes(is_so: bool, yes: str, no: str) -> str:
    return yes if is_so else no


_SILENT = "Only this robot is silent: look at its power and its radio. Look before you walk up to it."
CHECKS: dict[str, Callable[[Scene], Look]] = {
    "broker": _broker,
    "others": _others,
    "heard": _heard,
    "said-goodbye": _goodbye,
    "gateway": _gateway,
    "battery": _battery,
    "charging": _charging,
    "delay": _delay,
    "position-age": _position_age,
    "nodes": node_checks.alive,
    "nodes-heard": node_checks.heard,
    "nodes-rate": node_checks.rate,
    "nodes-load": node_checks.load,
    "nodes-clock": node_checks.clocks,
    "nodes-order": node_checks.order,
    "node-restarts": node_checks.restarts,
    "functions": node_checks.functions,
    "latched": _latched,
    "button": _button,
    "standing": _standing,
    "presses": _presses,
    "speed": _speed,
    "fix": _fix,
    "corrections": _corrections,
    "satellites": _satellites,
    "others-fix": _others_fix,
    "cross-track": _cross_track,
    "waits-for": _waits,
    "mode": _mode,
    "mission": _mission,
    "obstacle": _obstacle,
    "cover": _cover,
    "clock": _clock,
    "disk": _disk,
    "database": _database,
    "writers": _writers,
    "station-heard": station_checks.heard,
    "stations-others": station_checks.others,
    "station-battery": station_checks.battery,
    "station-clock": station_checks.clock,
    "station-values": station_checks.values,
}
