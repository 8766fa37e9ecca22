"""Daylight, rain, wind, battery and position fix: which of an entry's conditions does not hold, worst first."""

from __future__ import annotations

from datetime import timedelta

from hmi.domain.forecast import Expected
from hmi.domain.queue.daylight import daylight
from hmi.domain.queue.entry import Entry
from hmi.domain.queue.facts import VALUE_FRESH_S, WEATHER_FRESH_S, Facts
from hmi.domain.queue.outlook import outlook_of
from hmi.domain.queue.reason import Waiting, Who, clock_text
from hmi.domain.sensors.gate import GateState

EXPECTED = {"rain": Expected.RAIN_RATE, "wind": Expected.WIND_SPEED}


def unmet(entry: Entry, facts: Facts) -> Waiting | None:
    """Return the first condition that does not hold or cannot be checked; ``None`` if all hold."""
    weather = _weather(entry, facts) or _treatment(entry, facts)
    return _dark(entry, facts) or weather or _battery(entry, facts) or _fix(entry, facts)


def _dark(entry: Entry, facts: Facts) -> Waiting | None:
    rule = entry.conditions
    if not rule.needs_daylight:
        return None
    if entry.place is None:
        text = "The field's place is not known, so daylight cannot be checked. Start it yourself or take the rule off."
        return Waiting("daylight_unknown", text, "Take the daylight rule off.", Who.PLANNER)
    lon_deg, lat_deg = entry.place
    after, before = timedelta(seconds=rule.after_sunrise_s), timedelta(seconds=rule.before_sunset_s)
    is_day, begins = daylight(facts.now, lat_deg, lon_deg, after_rise=after, before_set=before)
    if is_day:
        return None
    if begins is None:
        text = "There is no daylight here within a year with these limits. Take the daylight rule off."
        return Waiting("no_daylight", text, "Take the daylight rule off.", Who.PLANNER)
    text = f"Waits for daylight: from {clock_text(begins, facts.now, facts.zone)}."
    return Waiting("daylight", text, "", Who.ITSELF, begins)


def _weather(entry: Entry, facts: Facts) -> Waiting | None:
    rule, weather = entry.conditions, facts.weather
    asked = [
        ("rain", "mm/h", rule.rain_below_mm_h, weather.rain_mm_h if weather else None),
        ("wind", "m/s", rule.wind_below_mps, weather.wind_mps if weather else None),
    ]
    for what, unit, limit, value in asked:
        if limit is None:
            continue
        if weather is None or value is None or not _is_fresh(facts):
            return _no_weather(what, facts)
        if value >= limit:
            text = f"Waits: {what} {value:.1f} {unit}, limit {limit:.1f}."
            outlook = outlook_of(facts.forecast, entry.place, EXPECTED[what], limit, facts.now, facts.zone)
            return Waiting(what, text, f"Less {what}, or another limit.", Who.ITSELF, outlook=outlook)
    return None


def _is_fresh(facts: Facts) -> bool:
    assert facts.weather is not None
    age_s = (facts.now - facts.weather.at).total_seconds()
    return -60 <= age_s <= WEATHER_FRESH_S


def _no_weather(what: str, facts: Facts) -> Waiting:
    since = "" if facts.weather is None else f" since {clock_text(facts.weather.at, facts.now, facts.zone)}"
    text = f"No weather data{since}; {what} cannot be checked. Start it yourself or take the {what} rule off."
    return Waiting("no_weather", text, f"Weather data come, or the {what} rule goes.", Who.PLANNER)


def _treatment(entry: Entry, facts: Facts) -> Waiting | None:
    """The farm's treatment limits; a limit that nothing measures is never kept."""
    if not entry.conditions.needs_treatment_weather:
        return None
    gate = facts.treatment
    if gate is None:
        text = "What the field sensors say is not known yet, so the treatment limits cannot be checked."
        return Waiting("treatment_unknown", text, "The sensors are read, soon after the start.", Who.ITSELF)
    if not gate.is_asked:
        text = "No treatment limits are set, so the weather cannot be checked. Set them under Sensors."
        return Waiting("treatment_unknown", text, "Set the limits, or take the rule off.", Who.PLANNER)
    if gate.state is GateState.UNKNOWN:
        text = f"{gate.reason}. The treatment limits cannot be checked."
        return Waiting("treatment_unknown", text, "The station is heard, or the rule goes.", Who.PLANNER)
    if gate.state is GateState.WAITS:
        return Waiting("treatment", f"Waits: {_lower(gate.reason)}.", "Within the treatment limits.", Who.ITSELF)
    return None


def _lower(text: str) -> str:
    return text[:1].lower() + text[1:]


def _battery(entry: Entry, facts: Facts) -> Waiting | None:
    rule, robot, mission = entry.conditions, facts.robot, facts.mission
    assert robot is not None
    assert mission is not None
    if rule.battery_min is None and rule.battery_reserve is None:
        return None
    if robot.soc is None or robot.value_age_s is None or robot.value_age_s > VALUE_FRESH_S:
        text = f"The battery of {robot.name} is not known right now."
        return Waiting("battery_unknown", text, "Look at the machine.", Who.SITE)
    if rule.battery_min is not None and robot.soc < rule.battery_min:
        return _low(robot.soc, rule.battery_min, f"at least {rule.battery_min:.0%} is asked for")
    if rule.battery_reserve is None:
        return None
    if mission.battery_share is None:
        text = "What the mission needs is not known, so the battery cannot be checked. Ask for a fixed charge instead."
        return Waiting("energy_unknown", text, "Set a fixed charge.", Who.PLANNER)
    needed = mission.battery_share + rule.battery_reserve
    if needed > 1.0:  # on one charge the reserve cannot be kept, however full it is
        text = (
            f"One charge does not last: the mission needs {mission.battery_share:.0%} "
            f"and {rule.battery_reserve:.0%} should stay."
        )
        cure = "Plan it in parts, or ask for a fixed charge: it pauses to be charged then."
        return Waiting("battery_never", text, cure, Who.PLANNER)
    why = f"the mission needs {mission.battery_share:.0%} and {rule.battery_reserve:.0%} stay as reserve"
    return _low(robot.soc, needed, why) if robot.soc < needed else None


def _low(soc: float, needed: float, why: str) -> Waiting:
    text = f"Waits for the battery: {soc:.0%}, needs {needed:.0%} ({why})."
    return Waiting("battery", text, "Charge it.", Who.SITE)


def _fix(entry: Entry, facts: Facts) -> Waiting | None:
    robot = facts.robot
    assert robot is not None
    if not entry.conditions.needs_rtk:
        return None
    if robot.fix is None or robot.value_age_s is None or robot.value_age_s > VALUE_FRESH_S:
        return Waiting("fix_unknown", f"The position fix of {robot.name} is not known.", "Wait.", Who.ITSELF)
    if robot.fix != "fixed":
        text = f"Waits for RTK on {robot.name}: the fix is {robot.fix}."
        return Waiting("fix", text, "Correction data come.", Who.ITSELF)
    return None
