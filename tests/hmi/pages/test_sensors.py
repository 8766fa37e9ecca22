"""Sensors: what stations say and how old it is, whether treatment may go on, and what people change about them."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.hmi.pages.conftest import TABLETS, Theatre
from tests.hmi.pages.test_shell import is_stop_on_top

pytestmark = pytest.mark.browser
Look = Callable[..., Page]
NOTICE = {"state": "unconfirmed", "text": "Treatment on Polder 17, weeder-01", "since_utc": "2026-05-20T12:00:00Z"}
ASKED_MORE = "(n) => fetch('/stage-sensors').then((one) => one.json()).then((told) => told.polls > n)"
SMALL = """[...document.querySelectorAll('.sn-screen button, .sn-screen select, .sn-screen a')]
    .filter((one) => !one.closest('.hl-map')).map((one) => [one, one.getBoundingClientRect()])
    .filter(([, box]) => box.width && (box.width < %d || box.height < %d)).map(([one]) => one.dataset.testid)"""


@pytest.fixture
def stations(theatre: Theatre) -> Callable[..., None]:
    """Set what stations do; begins with one silent and one new."""
    theatre.play("running")
    theatre.sensors(anew=True)
    return theatre.sensors


def opened(page: Page) -> Page:
    """Return the page once it shows stations and a chart."""
    expect(page.get_by_test_id("sensor-weather-01")).to_have_attribute("data-state", "fresh")
    expect(page.locator(".sn-chart")).to_have_attribute("data-points", re.compile("[1-9]"))
    return page


def texts(page: Page, selector: str) -> Any:
    """Return the words of all elements of a selector."""
    return page.evaluate("(s) => [...document.querySelectorAll(s)].map((one) => one.textContent)", selector)


def test_values_say_their_age_silent_ones_look_old_and_the_gate_says_why_it_waits(
    look: Look, stations: Callable[..., None]
) -> None:
    stations(gate="waits", stations={"soil-01": {"notice": NOTICE}})
    page = opened(look("/sensors"))
    gate = page.get_by_test_id("sensors-gate")
    expect(gate).to_have_attribute("data-state", "waits")
    expect(gate).to_contain_text("Treatment: waits")
    expect(gate).to_contain_text("Wind 6.1 m/s, limit 5.0")
    wind = page.get_by_test_id("sensor-value-wind-speed")
    expect(wind).to_have_attribute("data-level", "3")
    before = float(wind.get_attribute("data-age-ms") or "nan")
    page.wait_for_function(
        "(ms) => Number(document.querySelector('[data-testid=sensor-value-wind-speed]').dataset.ageMs) > ms", arg=before
    )
    quiet = page.get_by_test_id("sensor-soil-03")
    expect(quiet).to_have_attribute("data-state", "silent")
    expect(quiet).to_contain_text("Soil 3 silent for 6 h. Battery 9 % when last heard.")
    expect(page.get_by_test_id("sensor-soil-01")).to_contain_text("Not confirmed, it may not know")
    expect(page.get_by_test_id("sensor-value-soil-moisture-0-10")).to_have_attribute("data-state", "fresh")
    quiet.click()
    value = page.get_by_test_id("sensor-value-soil-moisture-0-30")
    expect(value).to_have_attribute("data-state", "silent")
    expect(value).to_have_class(re.compile("stale"))
    expect(page.get_by_test_id("sensor-chart")).to_have_attribute("aria-label", re.compile("^Soil .*Soil 3: "))
    assert is_stop_on_top(page)


@pytest.mark.long
@pytest.mark.parametrize("size", TABLETS)
def test_the_screen_fits_every_size_and_theme_and_gloves_hit_its_buttons(
    look: Look, stations: Callable[..., None], size: str
) -> None:
    stations(gate="waits", forecast="fresh", hole_h=3)
    page = opened(look("/sensors", size=size, role="planner"))
    for theme in ("day", "night", "sunlight"):
        page.evaluate(f"HL.preferences.set('theme', '{theme}')")
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        assert is_stop_on_top(page)
    least = 48 if size == "desk" else 56
    assert page.evaluate(SMALL % (least - 1, least - 1)) == []
    page.get_by_test_id("sensor-soil-03").click()
    expect(page.get_by_test_id("sensor-edit-open")).to_be_enabled()
    assert page.evaluate(SMALL % (least - 1, least - 1)) == []
    page.get_by_test_id("sensors-limits").click()
    expect(page.get_by_test_id("limits-0-high")).to_be_visible()
    assert is_stop_on_top(page)


@pytest.mark.long
def test_the_map_shows_each_station_by_its_state_and_a_tap_chooses_it(
    look: Look, stations: Callable[..., None]
) -> None:
    page = opened(look("/sensors"))
    page.wait_for_function("window.headlandMap?.state()?.stations?.length === 7 && headlandMap.state().frame > 2")
    shown = {one["id"]: one["state"] for one in page.evaluate("headlandMap.state().stations")}
    assert (shown["weather-01"], shown["soil-03"]) == ("fresh", "silent")
    page.wait_for_function("headlandMap.state().texts.includes('Soil 3')")
    spot = page.evaluate("headlandMap.project(5.7492, 51.7490)")
    page.mouse.click(*spot)
    expect(page.get_by_test_id("sensor-soil-03")).to_have_attribute("aria-pressed", "true")
    page.get_by_test_id("sensors-all").click()
    expect(page.get_by_test_id("sensor-soil-03")).to_have_attribute("aria-pressed", "false")
    page.keyboard.press("g")
    page.keyboard.press("f")
    expect(page.get_by_test_id("fleet")).to_be_visible()
    page.keyboard.press("g")
    page.keyboard.press("n")
    opened(page)
    expect(page.get_by_test_id("nav-sensors")).to_have_attribute("aria-current", "page")


IN_PAIRS = {
    "multispec-01": (51.7511, 5.7511), "weather-01": (51.7510, 5.7509), "respiration-01": (51.7487, 5.7519),
    "soil-01": (51.7513, 5.7489), "soil-02": (51.7485, 5.7488), "soil-03": (51.7486, 5.7517),
    "soil-09": (51.7484, 5.7487),
}  # fmt: skip
HIDDEN_SIGNS = """() => {
  const host = document.querySelector('.sn-map .hl-map'), edge = host.getBoundingClientRect();
  const { fleet, palette } = host.hlMap;
  const half = 17 * palette.scale;
  const over = [...host.querySelectorAll('.hl-map-button, .hl-map-north, .hl-map-scale')];
  return fleet.at.flatMap(({ x, y }, i) => over.filter((one) => {
    const box = one.getBoundingClientRect(), [cx, cy] = [edge.left + x, edge.top + y];
    return cx + half > box.left && cx - half < box.right && cy + half > box.top && cy - half < box.bottom;
  }).map((one) => `${fleet.spots[i].id} under ${one.title || one.className}`));
}"""


@pytest.mark.parametrize("size", TABLETS)
def test_no_station_lies_under_a_button_the_north_arrow_or_the_scale(
    look: Look, stations: Callable[..., None], size: str
) -> None:
    stations(stations={key: {"lat_deg": lat, "lon_deg": lon} for key, (lat, lon) in IN_PAIRS.items()})
    page = opened(look("/sensors", size=size))
    page.wait_for_function("window.headlandMap?.state()?.stations?.length === 7 && headlandMap.state().frame > 2")
    assert page.evaluate(HIDDEN_SIGNS) == []


@pytest.mark.parametrize("size", TABLETS)
def test_whose_forecast_it_is_stands_on_one_line_and_all_of_its_hours_can_be_reached(
    look: Look, stations: Callable[..., None], size: str
) -> None:
    stations(forecast="fresh")
    page = opened(look("/sensors", size=size))
    said = page.locator(".sn-forehead > span")
    expect(said).to_contain_text("Forecast by")
    lines = "node => node.getBoundingClientRect().height / parseFloat(getComputedStyle(node).fontSize)"
    assert said.evaluate(lines) < 2
    assert page.evaluate("document.querySelector('.sn-hours').scrollWidth") > 200


@pytest.mark.long
def test_a_gap_stays_a_gap_and_values_are_read_by_finger_and_by_keys(look: Look, stations: Callable[..., None]) -> None:
    stations(hole_h=3)
    page = opened(look("/sensors"))
    chart = page.get_by_test_id("sensor-chart")
    expect(chart.locator("path.mean")).to_have_count(2)
    assert texts(page, ".limitname") == ["Limit 5.0 m/s"]
    assert "Nordfeld 12, weeder-07, now" in texts(page, ".sn-plot title")
    box = chart.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] * 0.3, box["y"] + box["height"] / 2)
    said = page.get_by_test_id("sensor-readout")
    expect(said).to_have_text(re.compile(r"\d\d:\d\d: \d+\.\d m/s, lowest \d+\.\d m/s, highest \d+\.\d m/s$"))
    page.mouse.move(box["x"] + box["width"] * (1 - 7.5 / 24), box["y"] + box["height"] / 2)
    expect(said).to_have_text(re.compile("nothing was measured$"))
    chart.focus()
    page.keyboard.press("End")
    last = said.text_content()
    page.keyboard.press("ArrowLeft")
    expect(said).not_to_have_text(str(last))
    page.evaluate("HL.preferences.set('speed', 'km/h')")
    expect(page.locator(".limitname")).to_have_text("Limit 18.0 km/h")
    page.get_by_test_id("sensor-span-season").click()
    expect(page.get_by_test_id("sensor-span-season")).to_have_attribute("aria-pressed", "true")
    expect(said).to_contain_text("one value a day")
    page.get_by_test_id("sensor-table").click()
    expect(page.locator(".sn-table tbody tr").first).to_contain_text("km/h")


@pytest.mark.long
def test_what_is_wrong_is_said_where_it_is(look: Look, stations: Callable[..., None]) -> None:
    stations(none=True)
    page = look("/sensors")
    notice = page.get_by_test_id("sensors-notice")
    expect(notice).to_contain_text("No stations. Add one")
    expect(notice).to_contain_text("headland simulate sensors")
    stations(anew=True, status=503)
    page.reload()
    expect(notice).to_contain_text("Stations did not load")
    stations(anew=True, stations={"weather-01": {"heard_s_ago": 4000.0}})
    expect(page.get_by_test_id("sensors-strip")).to_have_text(
        re.compile(r"No weather since .*\d\d:\d\d. Rain stop may be late.")
    )
    expect(page.get_by_test_id("sensors-forecast")).to_contain_text("No forecast set")
    stations(status=503)
    page.evaluate("HL.sensors.load()")
    expect(page.get_by_test_id("sensors-strip")).to_contain_text("Values are from")
    stations(anew=True, forecast="old", hang=1.5)
    page.reload()
    expect(notice).to_contain_text("Loading 7 stations")
    opened(page)
    expect(page.get_by_test_id("sensors-forecast")).to_have_attribute("data-state", "old")
    expect(page.get_by_test_id("sensors-forecast")).to_contain_text("It is not renewed.")


@pytest.mark.long
def test_a_chart_is_drawn_by_the_clock_of_the_server(look: Look, stations: Callable[..., None]) -> None:
    page = opened(look("/sensors"))
    page.evaluate("() => { const now = Date.now; Date.now = () => now() + 26 * 3600000; return HL.sensors.load(); }")
    page.get_by_test_id("sensor-span-7d").click()
    page.get_by_test_id("sensor-span-24h").click()
    expect(page.get_by_test_id("sensor-chart")).to_have_attribute("aria-label", re.compile("^Wind, .* to .*last"))
    expect(page.locator(".sn-plot .mean").first).to_be_visible()


@pytest.mark.long
@pytest.mark.parametrize("size", TABLETS)
def test_a_reading_is_never_cut_off_nor_the_limit_of_a_tile(
    look: Look, stations: Callable[..., None], size: str
) -> None:
    page = opened(look("/sensors", size=size))
    page.get_by_test_id("sensor-value-soil-moisture-0-10").click()
    expect(page.locator(".sn-pick")).to_be_visible()
    tile = page.get_by_test_id("sensor-value-soil-moisture-0-10")
    expect(tile).to_contain_text(re.compile(r"limits\s14.0\sto\s38.0 · .*all\s[\d.]+–[\d.]+$"))
    under = tile.locator(".sub")
    assert under.evaluate("(one) => one.scrollWidth <= one.clientWidth && one.scrollHeight <= one.clientHeight + 1")
    said, tall = page.get_by_test_id("sensor-readout"), "() => document.querySelector('.sn-charthead').clientHeight"
    expect(said).to_contain_text("Soil 1, one value each 10 min. Touch to read.")
    page.evaluate("document.fonts.ready")
    before = page.evaluate(tall)
    page.get_by_test_id("sensor-chart").focus()
    page.keyboard.press("End")
    expect(said).to_contain_text("highest")
    assert said.evaluate("(one) => [one.scrollWidth <= one.clientWidth, getComputedStyle(one).whiteSpace]") == [
        True,
        "normal",
    ]
    assert page.evaluate(tall) == before, "nothing jumps"


@pytest.mark.long
def test_a_planner_accepts_a_new_station_and_a_refusal_loses_nothing(
    look: Look, theatre: Theatre, stations: Callable[..., None]
) -> None:
    viewer = opened(look("/sensors", role="viewer"))
    expect(viewer.get_by_test_id("sensor-accept-soil-09")).to_be_disabled()
    viewer.close()
    stations(refuse={"accept": [422, {"text": "This name is taken.", "field": "name"}]})
    page = opened(look("/sensors", role="planner", is_new=True))
    page.get_by_test_id("sensor-accept-soil-09").click()
    name = page.get_by_test_id("sensor-accept-name")
    name.fill("")
    page.get_by_test_id("sensor-accept-save").click()
    expect(name).to_have_attribute("aria-invalid", "true")
    assert theatre.heard_sensors()["asked"] == []
    name.fill("Soil 9")
    page.get_by_test_id("sensor-accept-parcel").select_option("nordfeld-12")
    page.get_by_test_id("sensor-accept-save").click()
    expect(page.get_by_test_id("sensor-accept")).to_contain_text("Not saved: This name is taken.")
    expect(name).to_have_value("Soil 9")
    stations(refuse={})
    page.get_by_test_id("sensor-accept-save").click()
    expect(page.get_by_test_id("sensor-soil-09")).to_contain_text("Nordfeld 12")
    expect(page.get_by_test_id("sensor-accept-soil-09")).to_be_hidden()
    asked = theatre.heard_sensors()["asked"][-1]
    assert (asked["path"], asked["name"], asked["parcel"]) == ("soil-09/accept", "Soil 9", "nordfeld-12")


@pytest.mark.long
def test_limits_are_changed_by_planners_and_read_by_others(
    look: Look, theatre: Theatre, stations: Callable[..., None]
) -> None:
    martha = opened(look("/sensors"))
    martha.get_by_test_id("sensors-limits").click()
    expect(martha.get_by_test_id("limits-readonly")).to_have_text(re.compile("Limits can be changed by planners."))
    expect(martha.get_by_test_id("limits")).to_contain_text("5 m/s")
    martha.close()
    page = opened(look("/sensors", role="planner", is_new=True))
    page.get_by_test_id("sensors-limits").click()
    high = page.get_by_test_id("limits-0-high")
    high.fill("6,x")
    page.get_by_test_id("limits-save").click()
    expect(page.get_by_test_id("limits")).to_contain_text('"6,x" is no number.')
    high.fill("6,5")
    stations(refuse={"sensor-limits": [409, {"text": "Somebody changed them at 14:31."}]})
    page.get_by_test_id("limits-save").click()
    expect(page.get_by_test_id("limits-error")).to_contain_text("Somebody changed them at 14:31.")
    expect(high).to_have_value("6,5")
    page.get_by_test_id("limits-1-high").fill("")
    page.get_by_test_id("limits-add").select_option("air_temperature@")
    page.get_by_test_id("limits-3-low").fill("40")
    stations(refuse={"sensor-limits": [422, {"text": "Air 40.0 °C never happens.", "field": "limits.2.low"}]})
    page.get_by_test_id("limits-save").click()
    expect(page.get_by_test_id("limits-3-low")).to_have_attribute("aria-invalid", "true")  # the third that was sent
    page.get_by_test_id("limits-3-low").fill("4")
    stations(refuse={})
    page.get_by_test_id("limits-save").click()
    expect(page.get_by_test_id("limits")).to_have_count(0)
    sent = theatre.heard_sensors()["asked"][-1]["limits"]
    assert [(one["quantity"], one["low"], one["high"]) for one in sent] == [
        ("wind_speed", None, 6.5),
        ("soil_moisture", 14.0, 38.0),
        ("air_temperature", 4, None),
    ]
    expect(page.get_by_test_id("sensor-value-wind-speed")).to_contain_text("limit 6.5")


@pytest.mark.long
def test_a_value_is_calibrated_with_a_reason_and_its_history_is_shown(
    look: Look, theatre: Theatre, stations: Callable[..., None]
) -> None:
    page = opened(look("/sensors", role="planner"))
    page.get_by_test_id("sensor-soil-01").click()
    page.get_by_test_id("sensor-calibrate").click()
    expect(page.get_by_test_id("calibration-history")).to_contain_text("never calibrated")
    page.get_by_test_id("calibration-offset").fill("-1.5")
    page.get_by_test_id("calibration-gain").fill("40")
    page.get_by_test_id("calibration-note").fill("Three cores")
    page.get_by_test_id("calibration-save").click()
    expect(page.get_by_test_id("calibration-gain")).to_have_attribute("aria-invalid", "true")
    page.get_by_test_id("calibration-gain").fill("1.04")
    page.get_by_test_id("calibration-save").click()
    expect(page.get_by_test_id("calibration")).to_have_count(0)
    asked = theatre.heard_sensors()["asked"][-1]
    assert (asked["offset"], asked["gain"], asked["quantity"], asked["depth_m"]) == (-1.5, 1.04, "soil_moisture", 0.1)
    page.get_by_test_id("sensor-calibrate").click()
    expect(page.get_by_test_id("calibration-history")).to_contain_text("Three cores")
    expect(page.get_by_test_id("calibration-offset")).to_have_value("-1.5")


@pytest.mark.long
def test_a_station_is_edited_and_removed(look: Look, theatre: Theatre, stations: Callable[..., None]) -> None:
    page = opened(look("/sensors", role="planner"))
    page.get_by_test_id("sensor-respiration-01").click()
    page.get_by_test_id("sensor-edit-open").click()
    page.get_by_test_id("sensor-edit-lat-deg").fill("95")
    page.get_by_test_id("sensor-edit-save").click()
    expect(page.get_by_test_id("sensor-edit")).to_contain_text("Latitude is between -90 and 90.")
    page.get_by_test_id("sensor-edit-lat-deg").fill("51.7511")
    page.get_by_test_id("sensor-edit-name").fill("Chamber east")
    page.get_by_test_id("sensor-edit-save").click()
    expect(page.get_by_test_id("sensor-respiration-01")).to_contain_text("Chamber east")
    asked = theatre.heard_sensors()["asked"][-1]
    assert (asked["lat_deg"], asked["revision"]) == (51.7511, "first of Respiration 1")
    page.get_by_test_id("sensor-edit-open").click()
    page.get_by_test_id("sensor-remove").click()
    page.get_by_test_id("sensor-forget-save").click()
    expect(page.get_by_test_id("sensor-respiration-01")).to_have_count(0)
    expect(page.get_by_test_id("sensor-edit-open")).to_be_disabled()


@pytest.mark.long
def test_a_camera_station_is_asked_for_a_picture_and_its_own_word_is_shown(
    look: Look, theatre: Theatre, stations: Callable[..., None]
) -> None:
    stations(outcome={"outcome": "rejected", "text": "Its 100 pictures of today are taken."})
    page = opened(look("/sensors"))
    page.get_by_test_id("sensor-multispec-01").click()
    expect(page.get_by_test_id("sensor-pictures")).to_contain_text("7 of 100 pictures today")
    page.get_by_test_id("sensor-trigger").click()
    expect(page.get_by_test_id("sensors-hint")).to_contain_text("Its 100 pictures of today are taken.")
    assert theatre.heard_sensors()["asked"][-1]["path"] == "multispec-01/trigger"
    page.get_by_test_id("sensor-cameras").click()
    page.wait_for_url("**/cameras")
    viewer = opened(look("/sensors", role="viewer", is_new=True))
    viewer.get_by_test_id("sensor-multispec-01").click()
    expect(viewer.get_by_test_id("sensor-trigger")).to_be_disabled()
    expect(viewer.get_by_test_id("sensors-hint")).to_contain_text("Operators take pictures.")


@pytest.mark.long
def test_stations_are_asked_for_only_while_the_page_is_seen_and_at_once_when_news_comes(
    look: Look, theatre: Theatre, stations: Callable[..., None]
) -> None:
    page = opened(look("/sensors"))
    before = theatre.heard_sensors()["polls"]
    theatre.alarms(tell=[{"kind": "sensors"}])
    page.wait_for_function(ASKED_MORE, arg=before)
    page.evaluate("Object.defineProperty(document, 'hidden', { value: true, configurable: true })")
    page.evaluate("document.dispatchEvent(new Event('visibilitychange'))")
    page.wait_for_timeout(200)
    quiet = theatre.heard_sensors()["polls"]
    theatre.alarms(tell=[{"kind": "sensors"}])
    page.wait_for_timeout(1500)
    assert theatre.heard_sensors()["polls"] == quiet
    page.evaluate("delete document.hidden")
    page.evaluate("document.dispatchEvent(new Event('visibilitychange'))")
    page.wait_for_function(ASKED_MORE, arg=quiet)
