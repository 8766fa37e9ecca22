"""Checks of the guided diagnosis that look at a field station."""

from __future__ import annotations

from hmi.domain.sensors.freshness import State
from hmi.domain.sensors.station import LOW_BATTERY
from hmi.presenters.scene import Look, Scene, unknown
from hmi.presenters.units import age_text, percent


def heard(scene: Scene) -> Look:
    """Is it heard?"""
    text, one = "Is the station heard?", scene.station
    if one is None:
        return unknown(text)
    if one.age_s is None:
        return Look(text, "Nothing was ever measured.", False, _SILENT)
    return Look(text, f"Last {age_text(one.age_s)} ago.", one.state in (State.FRESH, State.LATE), _SILENT)


def others(scene: Scene) -> Look:
    """Are others heard?"""
    text, one = "Are other stations heard?", scene.station
    if one is None or not one.others:
        return unknown(text)
    means = "No station is heard: look at the mast, the router and the broker, not at this station."
    return Look(text, f"{one.others_heard} of {one.others} are heard.", one.others_heard > 0, means)


def battery(scene: Scene) -> Look:
    """How full is its battery?"""
    text, one = "How full was its battery?", scene.station
    if one is None or one.battery is None:
        return unknown(text)
    means = "The battery is nearly empty: that alone may be why. Clean the solar panel, charge or change it."
    return Look(text, f"{percent(one.battery)} %.", one.battery > LOW_BATTERY, means)


def clock(scene: Scene) -> Look:
    """Is its clock right?"""
    text, one = "By how much does its clock differ?", scene.station
    if one is None:
        return unknown(text)
    way = "ahead" if one.skew_s > 0 else "behind, or it sends late"
    means = "Set the station's clock, or its time service."
    return Look(text, f"{age_text(abs(one.skew_s))} {way}.", not one.is_clock_wrong, means)


def values(scene: Scene) -> Look:
    """Can its values be true?"""
    text, one = "Can its values be true?", scene.station
    if one is None:
        return unknown(text)
    found = "; ".join(one.implausible) if one.implausible else "Yes, all."
    return Look(text, found, not one.implausible, "A sensor is broken, dirty or wrongly calibrated. Look at it.")


_SILENT = "The station itself is silent: look at its power and its radio."
