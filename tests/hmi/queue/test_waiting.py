"""What an entry waits for: one true sentence, and never a start while anything is missing."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Any
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.forecast import Forecast, Hour
from hmi.domain.mission import MissionStatus
from hmi.domain.queue.blackout import Blackout
from hmi.domain.queue.entry import Conditions, Entry
from hmi.domain.queue.facts import Facts, MissionFacts, RobotFacts, Weather
from hmi.domain.queue.waiting import Step, why_waiting
from hmi.domain.robot import Mode, OrderStatus

NOW = datetime(2026, 6, 15, 10, 0, tzinfo=UTC)  # 12:00 in Amsterdam
ZONE = ZoneInfo("Europe/Amsterdam")
PLACE = (4.26, 51.78)
ALL = Conditions(
    rain_below_mm_h=0.5, wind_below_mps=5.0, needs_daylight=True, battery_reserve=0.15, battery_min=0.4, needs_rtk=True
)
ENTRY = Entry(
    "q-1", "farm", "weeder-03", "wheat-1", 10, "Pieter Bos", NOW, is_unattended=True, conditions=ALL, place=PLACE
)
ROBOT = RobotFacts(
    "Weeder 03", True, 0.4, 0.1, "", Mode.IDLE, OrderStatus.LOADED, "wheat-1", "a" * 64, "Wheat 1",
    state_age_s=0.4, value_age_s=0.1, soc=0.9, fix="fixed",
)  # fmt: skip
MISSION = MissionFacts("Wheat 1", MissionStatus.ACCEPTED, "a" * 64, is_supervised=False, battery_share=0.3)
GOOD = Facts(
    now=NOW,
    zone=ZONE,
    robot=ROBOT,
    mission=MISSION,
    armed_until=NOW + timedelta(hours=2),
    weather=Weather(NOW - timedelta(minutes=3), 0.0, 2.1, "Yard"),
)


def says(entry: Entry = ENTRY, **changes: Any) -> str:
    """Return the sentence when facts are changed; fields of robot and mission go by name."""
    robot = {k: changes.pop(k) for k in list(changes) if k in RobotFacts.__dataclass_fields__}
    facts = replace(GOOD, **changes)
    if facts.robot is not None and robot:
        facts = replace(facts, robot=replace(facts.robot, **robot))
    return why_waiting(entry, facts).waiting.text


def test_everything_good_is_started() -> None:
    assert why_waiting(ENTRY, GOOD).step is Step.START


def test_nothing_starts_while_a_function_that_the_work_needs_is_off() -> None:
    off = "Weed is off: guidance failed. Restart guidance on Supervisor."
    verdict = why_waiting(ENTRY, replace(GOOD, robot=replace(ROBOT, cannot=off)))
    assert (verdict.step, verdict.waiting.code) == (Step.WAIT, "function_off")
    assert verdict.waiting.text == f"Weeder 03: {off}"


def test_a_forecast_says_when_a_rule_is_expected_to_clear_and_decides_nothing() -> None:
    begin, weather = NOW.replace(minute=0), GOOD.weather
    assert weather is not None
    hours = tuple(Hour(begin + timedelta(hours=k), wind_speed=6.4 if k < 4 else 4.1) for k in range(24))
    forecast = Forecast(NOW - timedelta(minutes=30), hours, PLACE)
    windy = replace(GOOD, weather=replace(weather, wind_mps=6.1), forecast=forecast)

    def outlook(facts: Facts, entry: Entry = ENTRY) -> str:
        return why_waiting(entry, facts).waiting.outlook

    waiting = why_waiting(ENTRY, windy).waiting
    assert (waiting.text, waiting.clears_at) == ("Waits: wind 6.1 m/s, limit 5.0.", None)
    assert waiting.outlook == "Forecast: below 5.0 from about 16:00."
    old = replace(forecast, made_at=NOW - timedelta(hours=4))
    assert outlook(replace(windy, forecast=old)) == "Forecast made 4 h ago: below 5.0 from about 16:00."
    storm = replace(forecast, hours=hours[:3])
    assert outlook(replace(windy, forecast=storm)) == "Forecast: not below 5.0 before 15:00."
    assert outlook(replace(windy, forecast=replace(forecast, made_at=NOW - timedelta(hours=25)))) == ""
    assert outlook(windy, replace(ENTRY, place=(-3.9, 40.4))) == ""
    # calm by the forecast is not calm: without a measurement, and over the limit, it still waits
    calm = replace(forecast, hours=tuple(replace(one, wind_speed=0.1, rain_rate=0.0) for one in hours))
    assert why_waiting(ENTRY, replace(windy, forecast=calm)).step is Step.WAIT
    assert why_waiting(ENTRY, replace(GOOD, weather=None, forecast=calm)).waiting.code == "no_weather"
    # and a storm by the forecast holds nothing up that may go by what is measured
    assert why_waiting(ENTRY, replace(GOOD, forecast=forecast)).step is Step.START


def test_the_sentence_says_what_is_missing_and_what_clears_it() -> None:
    night = datetime(2026, 6, 15, 1, 0, tzinfo=UTC)
    weather = GOOD.weather
    assert weather is not None
    old = replace(weather, at=NOW - timedelta(minutes=50))
    assert says(now=night, armed_until=night + timedelta(hours=9), weather=replace(weather, at=night)) == (
        "Waits for daylight: from 05:23."
    )
    assert says(weather=replace(weather, wind_mps=6.1)) == "Waits: wind 6.1 m/s, limit 5.0."
    assert says(weather=replace(weather, rain_mm_h=0.5)) == "Waits: rain 0.5 mm/h, limit 0.5."
    assert says(weather=old) == (
        "No weather data since 11:10; rain cannot be checked. Start it yourself or take the rain rule off."
    )
    assert says(weather=None).startswith("No weather data; rain cannot be checked.")
    assert says(order=OrderStatus.RUNNING, held_id="x", held_name="Wheat 2", mode=Mode.AUTO) == (
        "Waits for Weeder 03: it is running Wheat 2."
    )
    assert says(soc=0.42) == "Waits for the battery: 42%, needs 45% (the mission needs 30% and 15% stay as reserve)."
    assert says(mission=replace(MISSION, battery_share=3.63), soc=1.0) == (
        "One charge does not last: the mission needs 363% and 15% should stay."
    )
    assert says(fix="float") == "Waits for RTK on Weeder 03: the fix is float."
    assert says(link_age_s=12.0) == "No link to Weeder 03 for 12 s."
    assert says(owner="Jonas Weber") == "Jonas Weber has control of Weeder 03."
    assert says(replace(ENTRY, earliest=NOW + timedelta(hours=20))) == "Waits until Tue 16 Jun 08:00."
    assert says(replace(ENTRY, earliest=NOW + timedelta(days=365))) == "Waits until Tue 15 Jun 2027 12:00."
    night_off = Blackout("b", "farm", "Lunch", frozenset({0}), 11 * 60, 13 * 60)
    assert says(blackouts=[night_off]) == "Waits for the end of Lunch: 13:00."


def test_a_robot_that_is_heard_but_has_not_said_for_long_what_it_does_is_not_started() -> None:
    assert why_waiting(ENTRY, replace(GOOD, robot=replace(ROBOT, state_age_s=2.0))).step is Step.START
    assert says(state_age_s=2.1) == "What Weeder 03 is doing is not known right now."
    assert says(state_age_s=None) == "What Weeder 03 is doing is not known right now."


def test_what_needs_a_person_comes_before_what_passes_by_itself() -> None:
    weather = Weather(NOW, 9.0, 20.0)
    assert says(weather=weather, armed_until=None).startswith("Not armed")
    assert says(weather=weather, frozen="Frozen since STOP ALL.") == "Frozen since STOP ALL."
    assert says(weather=weather, stop="Vera Lang pressed STOP. Reset it first.").startswith("Weeder 03: Vera Lang")


BREAKS: list[dict[str, Any]] = [
    {"frozen": "Frozen."}, {"ahead": "Wheat 0"}, {"armed_until": None}, {"owner": "Jonas Weber"}, {"robot": None},
    {"mission": None}, {"weather": None}, {"is_unattended_allowed": False}, {"link_age_s": None}, {"link_age_s": 2.1},
    {"safety_age_s": None}, {"safety_age_s": 2.1}, {"stop": "STOP was pressed."}, {"mode": Mode.MANUAL},
    {"state_age_s": None}, {"state_age_s": 2.1},
    {"mode": Mode.AUTO}, {"mode": Mode.FAULT}, {"mode": Mode.UNKNOWN}, {"mode": Mode.STOPPED},
    {"order": OrderStatus.RUNNING}, {"order": OrderStatus.PAUSED}, {"order": OrderStatus.NONE}, {"held_id": "other"},
    {"held_sha256": "b" * 64}, {"trouble": "Laser too hot."}, {"value_age_s": None}, {"value_age_s": 11.0},
    {"soc": None}, {"soc": 0.39}, {"fix": None}, {"fix": "float"},
]  # fmt: skip


@given(st.lists(st.sampled_from(BREAKS), min_size=1, max_size=4))
def test_one_thing_that_is_wrong_or_not_known_is_enough_not_to_start(wrong: list[dict[str, Any]]) -> None:
    facts, robot = GOOD, ROBOT
    for change in wrong:
        for name, value in change.items():
            if name in RobotFacts.__dataclass_fields__:
                robot = replace(robot, **{name: value})
            else:
                facts = replace(facts, **{name: value})
    if facts.robot is not None:
        facts = replace(facts, robot=robot)
    verdict = why_waiting(ENTRY, facts)
    assert verdict.step is not Step.START
    assert verdict.waiting.text.endswith(".")


@pytest.mark.parametrize("entry", [replace(ENTRY, is_unattended=False), replace(ENTRY, place=None)])
def test_an_entry_that_is_not_to_start_by_itself_or_has_no_place_is_not_started(entry: Entry) -> None:
    assert why_waiting(entry, GOOD).step is Step.WAIT


@given(st.sampled_from(list(MissionStatus)), st.sampled_from(list(OrderStatus)), st.sampled_from(list(Mode)))
def test_only_a_loaded_mission_on_an_idle_robot_is_started(
    status: MissionStatus, order: OrderStatus, mode: Mode
) -> None:
    facts = replace(GOOD, mission=replace(MISSION, status=status), robot=replace(ROBOT, order=order, mode=mode))
    if why_waiting(ENTRY, facts).step is Step.START:
        assert order is OrderStatus.LOADED
        assert mode in (Mode.IDLE, Mode.PAUSED)


@given(st.floats(0, 40000))
def test_a_late_start_is_never_made(late_s: float) -> None:
    entry = replace(ENTRY, earliest=NOW - timedelta(seconds=late_s), window_s=900)
    verdict = why_waiting(entry, GOOD)
    assert (verdict.step is Step.START) == (late_s <= 900)


def test_a_mission_without_known_energy_is_not_started_on_a_reserve_rule() -> None:
    facts = replace(GOOD, mission=replace(MISSION, battery_share=None))
    assert why_waiting(ENTRY, facts).waiting.code == "energy_unknown"


def test_a_person_who_starts_it_is_told_which_condition_does_not_hold_and_is_held_up_by_none() -> None:
    entry = replace(ENTRY, is_unattended=False)
    ready = "Ready on Weeder 03. The person on site starts it with a slide."
    assert says(entry) == ready
    windy = Weather(NOW, 0.0, 6.1, "Yard")
    assert says(entry, weather=windy) == (
        "Ready on Weeder 03, but its conditions do not hold. Waits: wind 6.1 m/s, limit 5.0. "
        "The person on site decides."
    )
    verdict = why_waiting(entry, replace(GOOD, weather=windy))
    assert (verdict.step, verdict.waiting.code) == (Step.WAIT, "ready")
    assert says(replace(entry, conditions=Conditions(needs_rtk=False)), weather=windy) == ready
