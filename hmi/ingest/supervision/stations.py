"""What is wrong with field stations, and with working in the weather they measure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hmi.domain.alarm.finding import Finding, Findings, detail_of
from hmi.domain.sensors.condition import StationCondition
from hmi.domain.sensors.freshness import State
from hmi.domain.sensors.gate import Gate
from hmi.domain.sensors.station import LOW_BATTERY
from hmi.store.sensor_board import SensorBoard, StationNow, is_recent

PREFIX = "station-"
SOIL = "soil_moisture"
MOST_NAMES = 4


@dataclass(frozen=True, slots=True)
class AtWork:
    """A robot that works on a parcel now; ``name`` is what people call it."""

    robot_id: str
    parcel: str
    name: str = ""


def source_of(station_id: str) -> str:
    """Return the source of a station's alarms; no robot is called so by accident."""
    return f"{PREFIX}{station_id}"


def station_findings(board: SensorBoard, now_s: float, refused: Mapping[str, str]) -> dict[str, Findings]:
    """Return what is wrong with each accepted station, by source.

    Args:
        refused: what is wrong with the notice of a station, by station.
    """
    found = {}
    for known in board.accepted():
        trouble = refused.get(known.station.id)
        notice = () if trouble is None else (Finding("notice-unconfirmed", trouble),)
        findings = (*_station(known, now_s), *notice)
        if findings:
            found[source_of(known.station.id)] = findings
    return found


def condition_of(board: SensorBoard, source: str, now_s: float) -> StationCondition | None:
    """Return how the station behind a source does, ``None`` if it is none."""
    known = board.get(source.removeprefix(PREFIX)) if source.startswith(PREFIX) else None
    if known is None:
        return None
    others = [one for one in board.accepted() if one is not known]
    heard = [one for one in others if one.state(now_s) in (State.FRESH, State.LATE)]
    wrong = [f"{one.channel.label} {one.channel.about().text(one.value)}" for one in known.ordered()
             if not one.is_plausible and is_recent(known, one, now_s)]  # fmt: skip
    return StationCondition(
        known.station.name, known.state(now_s), known.age_s(now_s), known.station.battery, known.receipt.skew_s,
        known.receipt.is_clock_wrong, tuple(wrong), len(others), len(heard),
    )  # fmt: skip


def work_findings(board: SensorBoard, gate: Gate, at_work: Sequence[AtWork], now_s: float) -> dict[str, Findings]:
    """Return what is wrong with working now, by the station that measured it: one alarm, not one for each robot."""
    found: dict[str, Findings] = {}
    who = _who(at_work)
    for fact in gate.facts:
        if fact.is_ok is False:
            finding = Finding("weather-over-limit", f"{fact.label} {fact.text}. At work: {who}.", detail_of(fact.label))
            source = source_of(fact.station_id)
            found[source] = (*found.get(source, ()), finding)
    for known in board.accepted():
        here = [one for one in at_work if one.parcel == known.station.parcel]
        if here and known.state(now_s) is not State.SILENT:
            source = source_of(known.station.id)
            found[source] = (*found.get(source, ()), *_soil(board, known, _who(here), now_s))
    return {source: findings for source, findings in found.items() if findings}


def _station(known: StationNow, now_s: float) -> list[Finding]:
    station, state, age_s = known.station, known.state(now_s), known.age_s(now_s)
    found = []
    if state is State.SILENT and age_s is not None:
        last = "" if station.battery is None else f" Battery {station.battery:.0%} when last heard."
        found.append(Finding("station-silent", f"Nothing for {_minutes(age_s)}.{last}"))
        return found  # the rest is as old
    if station.battery is not None and station.battery <= LOW_BATTERY:
        found.append(Finding("station-battery", f"{station.battery:.0%} left."))
    if known.receipt.is_clock_wrong:
        skew_s = known.receipt.skew_s
        which = f"{_minutes(skew_s)} ahead" if skew_s > 0 else f"{_minutes(-skew_s)} behind, or its values come late"
        found.append(Finding("station-clock", f"{which.capitalize()}."))
    for one in known.ordered():
        if not one.is_plausible and is_recent(known, one, now_s):
            text = f"{one.channel.label}: {one.channel.about().text(one.value)}."
            found.append(Finding("value-implausible", text, detail_of(one.channel.label)))
    return found


def _soil(board: SensorBoard, known: StationNow, who: str, now_s: float) -> list[Finding]:
    """Only where a limit is set, at its depth, and while the value is recent."""
    found = []
    for one in known.ordered():
        limit = board.limit(one.channel)
        if one.channel.quantity != SOIL or limit is None or limit.high is None or not one.is_plausible:
            continue
        if one.value > limit.high and is_recent(known, one, now_s):
            text = f"{limit.sentence(one.value, one.channel.label)}. At work: {who}."
            found.append(Finding("soil-too-wet", text, detail_of(one.channel.key)))
    return found


def _who(at_work: Sequence[AtWork]) -> str:
    names = sorted({one.name or one.robot_id for one in at_work})
    return ", ".join(names[:MOST_NAMES]) + (f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else "")


def _minutes(seconds: float) -> str:
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 120 else f"{minutes // 60} h"
