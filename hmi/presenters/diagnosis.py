"""The guided check of an alarm: looks at live values one after the other and says what it found and what follows.

A check that cannot tell says so; it never guesses.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from hmi.presenters import node_checks, robot_checks, station_checks
from hmi.presenters.scene import Look, Scene, unknown
from hmi.presenters.units import age_text, number, percent

SLOW_LINK_S = 0.3  # driving by hand ends above it


def diagnose(names: Sequence[str], scene: Scene) -> dict[str, Any]:
    """Return the checks of a type in their order, and the conclusion: what the first bad one means.

    Where it matters that the robot stands, nothing else is concluded as long as it is not known to stand.
    """
    looks = [CHECKS[name](scene) for name in names]
    moving = [one for name, one in zip(names, looks, strict=True) if name == "standing" and not one.is_ok]
    bad = [one for one in looks if one.is_ok is False and one.means]
    blind = [one for one in looks if one.is_ok is None]
    if moving:
        conclusion = moving[0].means
    elif bad:
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
    text = "Is the console connected to the broker?"
    return Look(text, _yes(scene.is_broker_up, "Yes.", "No."), scene.is_broker_up, _BROKER_LOST)


def _others(scene: Scene) -> Look:
    text = "Are other robots heard?"
    heard = sum(1 for one in scene.others if one.link.is_online)
    if not scene.others:
        return Look(text, "There are no others.", None)
    is_ok = heard > 0
    return Look(text, f"{heard} of {len(scene.others)} are heard.", is_ok, _ALL_SILENT)


def _heard(scene: Scene) -> Look:
    text = "Is the robot heard?"
    if scene.robot is None:
        return unknown(text)
    link = scene.robot.link
    if link.heard_s is None:
        return Look(text, "Not since Headland was started.", False, _silent(scene))
    age_s = scene.now_s - link.heard_s
    return Look(text, f"Last {age_text(age_s)} ago.", link.is_online, _silent(scene))


def _silent(scene: Scene) -> str:
    if not scene.is_broker_up:
        return _BROKER_LOST
    if not scene.others:
        return _SILENT.format(who="This robot")
    return _SILENT.format(who="Only this robot") if any(one.link.is_online for one in scene.others) else _ALL_SILENT


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


def _delay(scene: Scene) -> Look:
    text = "How long is the way to it and back?"
    if scene.robot is None or scene.robot.link.rtt_s is None:
        return unknown(text)
    worst = scene.robot.link.rtt_max_s or scene.robot.link.rtt_s
    means = "The link was slow before: weak radio or mobile signal at that place."
    return Look(text, f"{worst * 1000:.0f} ms at worst in the last minute heard.", worst <= SLOW_LINK_S, means)


def _others_fix(scene: Scene) -> Look:
    text = "Do other robots have an exact position?"
    fixes = [one.telemetry.gnss.fix for one in scene.others
             if one.link.is_online and one.telemetry is not None and one.telemetry.gnss is not None]  # fmt: skip
    if not fixes:
        return unknown(text)
    good = sum(1 for fix in fixes if fix == "fixed")
    means = "No robot has an exact position: it is the base station."
    return Look(text, f"{good} of {len(fixes)}.", good > 0, means)


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


_BROKER_LOST = "The console has lost the broker: look at the server and the network, not at the robots."
_ALL_SILENT = "No robot is heard: look at the mast, the router and the broker, not at this robot."
_SILENT = "{who} is silent: look at its power and its radio. Look before you walk up to it."
CHECKS: dict[str, Callable[[Scene], Look]] = {
    "broker": _broker,
    "others": _others,
    "heard": _heard,
    "said-goodbye": _goodbye,
    "gateway": _gateway,
    "battery": robot_checks.battery,
    "charging": robot_checks.charging,
    "delay": _delay,
    "position-age": robot_checks.position_age,
    "nodes": node_checks.alive,
    "nodes-heard": node_checks.heard,
    "nodes-rate": node_checks.rate,
    "nodes-load": node_checks.load,
    "nodes-clock": node_checks.clocks,
    "nodes-order": node_checks.order,
    "node-restarts": node_checks.restarts,
    "functions": node_checks.functions,
    "latched": robot_checks.latched,
    "button": robot_checks.button,
    "standing": robot_checks.standing,
    "presses": robot_checks.presses,
    "speed": robot_checks.speed,
    "fix": robot_checks.fix,
    "corrections": robot_checks.corrections,
    "satellites": robot_checks.satellites,
    "others-fix": _others_fix,
    "cross-track": robot_checks.cross_track,
    "waits-for": robot_checks.waits,
    "mode": robot_checks.mode,
    "mission": robot_checks.mission,
    "obstacle": robot_checks.obstacle,
    "cover": robot_checks.cover,
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
