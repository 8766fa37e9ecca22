"""The fleet screen: find, choose, order several with a result for each, keep views, hand over, stop one."""

from __future__ import annotations

import json
import urllib.request
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.hmi.pages.conftest import Theatre
from tests.hmi.pages.test_operate import slide

Look = Callable[..., Page]


@pytest.fixture
def fleet(theatre: Theatre) -> Callable[..., dict[str, Any]]:
    """Set the fleet's answers on stage, or read what reached it."""
    theatre.play("running")

    def call(**wish: Any) -> dict[str, Any]:
        body = json.dumps(wish).encode() if wish else None
        with urllib.request.urlopen(urllib.request.Request(f"{theatre.url}/stage-fleet", body)) as reply:
            heard: dict[str, Any] = json.loads(reply.read())
        return heard

    call(anew=True)
    return call


def choose(page: Page, *robots: str) -> None:
    """Tick robots."""
    for robot in robots:
        page.get_by_test_id(f"fleet-pick-{robot}").check()
    expect(page.get_by_test_id("fleet-chosen")).to_have_text(f"{len(robots)} chosen")


def test_two_robots_are_found_chosen_and_paused_and_the_one_that_refused_is_tried_again(
    look: Look, fleet: Callable[..., dict[str, Any]]
) -> None:
    fleet(outcomes={"weeder-01": {"outcome": "rejected", "code": "robot_silent", "text": "No link to Weeder 01."}})
    page = look("/fleet")
    page.get_by_test_id("fleet-search").fill("weeder")
    expect(page.get_by_test_id("fleet-row-planter-02")).to_have_count(0)
    expect(page.get_by_text("You see 2 of 3 robots.")).to_be_visible()
    choose(page, "weeder-07", "weeder-01")
    page.get_by_test_id("fleet-do-pause").click()
    expect(page.get_by_test_id("fleet-results-sum")).to_have_text("1 of 2 took it. One did not.")
    expect(page.get_by_test_id("fleet-result-weeder-01")).to_contain_text("No link to Weeder 01.")
    fleet(outcomes={})
    page.get_by_role("button", name="Try again with 1").click()
    expect(page.get_by_test_id("fleet-results-sum")).to_have_text("It took it.")
    orders = fleet()["orders"]
    assert [(one["action"], sorted(one["robots"])) for one in orders] == [
        ("pause", ["weeder-01", "weeder-07"]),
        ("pause", ["weeder-01"]),
    ]
    assert orders[0]["action_id"] != orders[1]["action_id"]
    assert all(one["tick"].startswith("stage-") for one in orders)


@pytest.mark.long
def test_going_home_needs_one_slide_that_names_them_all_and_what_stands_against_it(
    look: Look, fleet: Callable[..., dict[str, Any]]
) -> None:
    page = look("/fleet")
    choose(page, "weeder-07", "planter-02")
    page.get_by_test_id("fleet-do-home").click()
    expect(page.get_by_test_id("fleet-home-names")).to_contain_text("Weeder 07")
    expect(page.get_by_test_id("fleet-home-names")).to_contain_text("No link. It will not hear this")
    assert fleet()["orders"] == []
    page.get_by_test_id("fleet-home").focus()
    page.keyboard.down("Enter")
    expect(page.get_by_test_id("fleet-results-sum")).to_have_text("All 2 took it.")
    page.keyboard.up("Enter")
    assert [one["action"] for one in fleet()["orders"]] == ["return_home"]


def test_a_stop_meanwhile_cancels_the_slide_home_and_says_which_robots_it_holds(
    look: Look, fleet: Callable[..., dict[str, Any]]
) -> None:
    page = look("/fleet")
    choose(page, "weeder-07", "weeder-01")
    page.get_by_test_id("fleet-do-home").click()
    slide(page, "fleet-home", share=0.6, is_released=False)
    expect(page.get_by_test_id("fleet-home")).to_have_attribute("data-state", "armed")
    page.evaluate(
        """dispatchEvent(new CustomEvent('headland:stop', { detail: { ...window.headlandStop.state(),
            steps: [{ robot: 'weeder-07', stop_id: 'of-somebody', state: 'sent', at: performance.now() }] } }))"""
    )
    expect(page.get_by_test_id("fleet-home")).to_have_attribute("data-state", "idle")
    expect(page.get_by_test_id("fleet-home-names")).to_contain_text("Reset the stop first")
    track = page.get_by_test_id("fleet-home").bounding_box()
    assert track is not None
    page.mouse.move(track["x"] + track["width"] - 4, track["y"] + track["height"] / 2, steps=4)
    page.mouse.up()
    assert fleet()["orders"] == []


def test_a_filter_by_a_group_that_is_deleted_falls_away_and_says_so(
    look: Look, fleet: Callable[..., dict[str, Any]], theatre: Theatre
) -> None:
    group = {"id": "g-0", "name": "North", "robots": ["weeder-07"], "changed_by": "Martha Keller"}
    view = {"id": "v-0", "name": "Mornings", "filter": {"group": "g-0"}}
    fleet(groups=[group], views=[view])
    page = look("/fleet")
    page.wait_for_function("HL.fleet.groups.length === 1")
    page.evaluate("HL.fleet.setFilter({ group: 'g-0' })")
    expect(page.get_by_test_id("fleet-row-planter-02")).to_have_count(0)
    fleet(groups=[{**group, "name": "North again", "robots": ["weeder-07", "planter-02"]}])
    theatre.alarms(tell=[{"kind": "fleet", "what": "groups"}])
    expect(page.get_by_test_id("fleet-row-planter-02")).to_be_visible()
    expect(page.get_by_text("You see 2 of 3 robots.")).to_be_visible()
    fleet(groups=[])
    theatre.alarms(tell=[{"kind": "fleet", "what": "groups"}])
    expect(page.get_by_test_id("toast")).to_contain_text("The group of this filter was deleted.")
    expect(page.get_by_text("You see 2 of 3 robots.")).to_be_hidden()
    page.get_by_test_id("fleet-filter").click()
    expect(page.get_by_test_id("fleet-view-v-0")).to_contain_text("a group that was deleted")
    page.get_by_test_id("fleet-view-v-0").click()
    page.wait_for_function("HL.fleet.filter.group === '' && HL.fleet.visible().length === 3")


def test_robots_whose_person_is_gone_are_named_to_a_supervisor_until_somebody_takes_them(
    look: Look, fleet: Callable[..., dict[str, Any]], theatre: Theatre
) -> None:
    anna = look("/fleet", role="supervisor")
    anna.wait_for_function("typeof HL.dutyNotice === 'object'")
    expect(anna.get_by_test_id("duty-freed")).to_have_count(0)
    fleet(freed={"weeder-07": {"since": 1_779_280_000_000}, "weeder-99": {"since": 1_779_280_000_000}})
    told = {"kind": "duty", "what": "released", "robots": ["weeder-07"], "names": ["Weeder 07"], "by": "Martha Keller"}
    theatre.alarms(tell=[{**told, "by_id": "operator", "from_users": ["operator"]}])
    expect(anna.get_by_test_id("toast")).to_contain_text("Nobody is responsible for Weeder 07 any more.")
    expect(anna.get_by_test_id("duty-freed")).to_contain_text("Nobody is responsible for Weeder 07 any more")
    expect(look("/fleet").get_by_test_id("fleet-row-weeder-07")).to_be_visible()  # an operator is not asked
    anna.get_by_test_id("duty-freed-leave").click()
    expect(anna.get_by_test_id("duty-freed")).to_have_count(0)
    fleet(freed={"weeder-07": {"since": 1_779_280_999_000}})  # somebody took it, and left it again
    theatre.alarms(tell=[told])
    anna.get_by_test_id("duty-freed-take").click()
    expect(anna.get_by_test_id("duty-freed")).to_have_count(0)
    anna.wait_for_function("HL.fleet.duty['weeder-07'].user === 'supervisor'")


def test_a_group_that_somebody_saves_meanwhile_is_offered_in_the_open_sheet(
    look: Look, fleet: Callable[..., dict[str, Any]], theatre: Theatre
) -> None:
    page = look("/fleet")
    page.get_by_test_id("fleet-filter").click()
    expect(page.get_by_text("Groups of this farm")).to_be_hidden()
    fleet(groups=[{"id": "g-0", "name": "North", "robots": ["weeder-07"], "changed_by": "Martha Keller"}])
    theatre.alarms(tell=[{"kind": "fleet", "what": "groups"}])
    expect(page.get_by_test_id("fleet-choose-g-0")).to_be_visible()
    page.get_by_test_id("fleet-filter-group").select_option(label="North (1)")
    expect(page.get_by_test_id("fleet-row-planter-02")).to_have_count(0)


@pytest.mark.long
def test_a_saved_view_and_a_group_survive_a_reload(look: Look, fleet: Callable[..., dict[str, Any]]) -> None:
    page = look("/fleet")
    choose(page, "weeder-07", "weeder-01")
    page.get_by_test_id("fleet-do-group").click()
    page.get_by_test_id("fleet-group-name").fill("North")
    page.get_by_role("button", name="Save", exact=True).click()
    page.get_by_test_id("fleet-sort-name").click()
    page.get_by_test_id("fleet-filter").click()
    page.get_by_test_id("fleet-filter-group").select_option(label="North (2)")
    page.get_by_test_id("fleet-view-name").fill("Mornings")
    page.get_by_test_id("fleet-view-save").click()
    expect(page.get_by_test_id("fleet-view-v-0")).to_be_visible()
    page.get_by_role("button", name="Show all").last.click()
    expect(page.get_by_test_id("fleet-row-planter-02")).to_be_visible()
    page.reload()
    expect(page.get_by_test_id("fleet-row-planter-02")).to_be_visible()
    page.get_by_test_id("fleet-filter").click()
    page.get_by_test_id("fleet-view-v-0").click()
    expect(page.get_by_test_id("fleet-row-planter-02")).to_have_count(0)
    expect(page.get_by_test_id("fleet-sort-name")).to_have_attribute("aria-pressed", "true")
    page.reload()
    expect(page.get_by_test_id("fleet-sort-name")).to_have_attribute("aria-pressed", "true")
    expect(page.get_by_test_id("fleet-row-weeder-07")).to_be_visible()
    expect(page.get_by_test_id("fleet-row-planter-02")).to_have_count(0)


@pytest.mark.long
def test_a_hand_over_waits_for_the_other_to_take_over(look: Look, fleet: Callable[..., dict[str, Any]]) -> None:
    martha = look("/fleet")
    choose(martha, "weeder-07")
    martha.get_by_test_id("fleet-do-duty").click()
    martha.get_by_test_id("duty-person").select_option("supervisor")
    martha.get_by_test_id("duty-note").fill("07 pulls to the left")
    martha.get_by_role("button", name="Hand over", exact=True).last.click()
    expect(martha.get_by_test_id("toast")).to_contain_text("You stay responsible until it is taken over.")
    anna = look("/fleet", role="supervisor")
    expect(anna.get_by_test_id("duty-offer")).to_contain_text("Martha Keller hands over Weeder 07")
    expect(anna.get_by_test_id("duty-offer")).to_contain_text("07 pulls to the left")
    anna.get_by_test_id("duty-accept").click()
    expect(anna.get_by_test_id("duty-offer")).to_have_count(0)
    anna.get_by_test_id("fleet-filter").click()
    anna.get_by_test_id("fleet-filter-mine").check()
    expect(anna.get_by_test_id("fleet-row-weeder-01")).to_have_count(0)
    expect(anna.get_by_test_id("fleet-row-weeder-07")).to_be_visible()


def test_an_offer_is_withdrawn_in_the_menu_by_who_made_it(look: Look, fleet: Callable[..., dict[str, Any]]) -> None:
    martha = look("/fleet")
    choose(martha, "weeder-07")  # it is nobody's
    martha.get_by_test_id("fleet-do-duty").click()
    martha.get_by_test_id("duty-person").select_option("supervisor")
    martha.get_by_role("button", name="Hand over", exact=True).last.click()
    expect(martha.get_by_test_id("toast")).to_contain_text("Offered.")
    martha.get_by_test_id("fleet-menu-weeder-07").click()
    expect(martha.get_by_test_id("fleet-menu")).to_contain_text("Offered to Anna Ostermeier.")
    martha.get_by_test_id("fleet-menu-withdraw").click()
    expect(martha.get_by_test_id("fleet-menu")).to_have_count(0)
    martha.wait_for_function("HL.fleet.duty['weeder-07'].offer === null")
    martha.get_by_test_id("fleet-menu-weeder-07").click()
    expect(martha.get_by_test_id("fleet-menu-duty")).to_be_visible()
    expect(martha.get_by_test_id("fleet-menu-withdraw")).to_have_count(0)


def test_a_group_is_deleted_after_a_question_and_a_refusal_is_told(
    look: Look, fleet: Callable[..., dict[str, Any]]
) -> None:
    group = {"id": "g-0", "name": "North", "robots": ["weeder-07", "weeder-01"], "changed_by": "Martha Keller"}
    fleet(groups=[group], refusal="North is in use.")
    page = look("/fleet")
    page.wait_for_function("HL.fleet.groups.length === 1")
    page.get_by_test_id("fleet-filter").click()
    page.get_by_test_id("fleet-group-drop-g-0").click()
    expect(page.get_by_test_id("fleet-delete")).to_contain_text("It is gone for everybody on this farm")
    assert fleet()["groups"] == [group]
    page.get_by_role("button", name="Delete", exact=True).click()
    expect(page.get_by_test_id("toast")).to_contain_text("North is in use.")
    expect(page.get_by_test_id("fleet-choose-g-0")).to_be_visible()
    fleet(refusal="")
    page.get_by_test_id("fleet-group-drop-g-0").click()
    page.get_by_role("button", name="Delete", exact=True).click()
    expect(page.get_by_test_id("fleet-choose-g-0")).to_have_count(0)
    assert fleet()["groups"] == []


def test_keys_walk_the_list_and_the_row_menu_stops_this_robot_alone(
    look: Look, theatre: Theatre, fleet: Callable[..., dict[str, Any]]
) -> None:
    page = look("/fleet")
    expect(page.get_by_test_id("fleet-row-weeder-07")).to_be_visible()
    page.keyboard.press("/")
    expect(page.get_by_test_id("fleet-search")).to_be_focused()
    page.keyboard.press("Escape")
    page.keyboard.press("j")
    page.keyboard.press("j")
    expect(page.locator("[data-testid^=fleet-row-]").nth(1)).to_have_attribute("aria-current", "true")
    page.get_by_test_id("fleet-row-weeder-07").click()
    expect(page.get_by_test_id("fleet-row-weeder-07")).to_have_attribute("aria-current", "true")
    page.keyboard.press("x")
    expect(page.get_by_test_id("fleet-chosen")).to_have_text("1 chosen")
    page.keyboard.press("Escape")
    expect(page.get_by_test_id("fleet-do-pause")).to_be_hidden()
    page.get_by_test_id("fleet-menu-weeder-07").click()
    expect(page.get_by_test_id("fleet-sentence")).to_contain_text("Rain in 35 min")
    page.get_by_test_id("fleet-stop-one").click()
    (stop,) = theatre.until_orders("stop")[:1]
    assert stop["robots"] == ["weeder-07"]
    expect(page.get_by_test_id("fleet-stop")).to_be_visible()
    page.keyboard.press("j")
    page.keyboard.press("k")
    page.keyboard.press("Enter")
    page.wait_for_url("**/operate/**")


@pytest.mark.long
def test_a_viewer_sees_everything_and_reads_why_orders_are_off(
    look: Look, fleet: Callable[..., dict[str, Any]]
) -> None:
    page = look("/fleet", role="viewer")
    choose(page, "weeder-07")
    page.get_by_test_id("fleet-do-pause").click(force=True)
    expect(page.get_by_test_id("toast")).to_contain_text("Pausing needs the operator role.")
    assert fleet()["orders"] == []
    expect(page.get_by_test_id("fleet-kpi-working")).to_have_attribute("data-value", "1")
    expect(page.get_by_test_id("fleet-kpi-area")).to_contain_text("7.84")


@pytest.mark.long
@pytest.mark.parametrize("size", ["landscape", "portrait", "desk"])
@pytest.mark.parametrize("theme", ["day", "night", "sunlight"])
def test_map_and_list_are_both_usable_at_every_size(
    look: Look, fleet: Callable[..., dict[str, Any]], size: str, theme: str
) -> None:
    page = look("/fleet", size=size)
    page.evaluate(f"document.documentElement.dataset.theme = '{theme}'")
    choose(page, "weeder-07", "weeder-01")
    for name in ("map", "fleet-list", "fleet-do-pause"):
        box = page.get_by_test_id(name).bounding_box()
        assert box is not None
        assert box["width"] >= 48
        assert box["height"] >= 48
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    small = page.evaluate(
        """() => [...document.querySelectorAll('.f-screen button, .f-screen label.pick, .f-screen a.h-btn')]
            .filter((one) => one.offsetParent && getComputedStyle(one).visibility !== 'hidden')
            .map((one) => [one.dataset.testid || one.className, one.getBoundingClientRect()])
            .filter(([, box]) => box.width && (box.width < 39.5 || box.height < 45.5)).map(([name]) => name)"""
    )
    assert small == []
    slab = page.get_by_test_id("stop").bounding_box()
    dock = page.get_by_test_id("fleet-dock").bounding_box()
    assert slab is not None
    assert dock is not None
    assert dock["x"] + dock["width"] <= slab["x"] + 1 or dock["y"] + dock["height"] <= slab["y"] + 1


@pytest.mark.long
def test_the_wall_shows_who_is_needed_in_big_type_and_nothing_to_press_but_stop(
    look: Look, fleet: Callable[..., dict[str, Any]]
) -> None:
    page = look("/wall", role="viewer", size="desk")
    expect(page.get_by_test_id("wall-sum")).to_have_text("2 need somebody")
    expect(page.get_by_test_id("wall-row-weeder-01")).to_contain_text("Never heard")
    expect(page.get_by_test_id("stop")).to_be_visible()
    assert page.locator(".w-screen button:visible").count() == 0


def test_the_wall_hides_no_robot_that_the_fleet_screen_filters_out(
    look: Look, fleet: Callable[..., dict[str, Any]]
) -> None:
    page = look("/fleet", role="supervisor")
    page.get_by_test_id("fleet-search").fill("planter")
    expect(page.get_by_test_id("fleet-row-weeder-07")).to_have_count(0)
    page.get_by_test_id("fleet-filter").click()
    page.get_by_test_id("wall-open").click()
    expect(page.get_by_test_id("wall-row-weeder-01")).to_be_visible()
    expect(page.get_by_test_id("fleet-filters")).to_have_count(0)
    said = "document.querySelector('.w-screen .hl-map')?.hlMap?.fleet.said"
    page.wait_for_function(f"({said})?.verdicts.size === 3")
    assert page.evaluate(f"HL.fleet.items.every((one) => {said}.isSeen(one.id))")


def test_the_wall_counts_those_it_has_no_room_for_by_who_needs_somebody(
    look: Look, fleet: Callable[..., dict[str, Any]], theatre: Theatre
) -> None:
    names = [f"disk-{number}.console" for number in range(20)]
    theatre.alarms(put={name: {"title": "Disk full", "text": "", "name": "Headland"} for name in names})
    page = look("/wall", role="viewer", size="landscape")
    expect(page.get_by_test_id("wall-sum")).to_have_text("22 need somebody")
    shown = "document.querySelectorAll('.w-row').length"
    page.wait_for_function(f"{shown} < 22 && document.querySelector('.w-rest').innerText.includes('more')")
    rest = page.locator(".w-rest").inner_text()
    assert rest == f"{22 - page.evaluate(shown)} more need somebody · 1 to watch · 0 normal"
    assert page.evaluate(
        """() => {
        const card = document.querySelector('.f-kpis').getBoundingClientRect();
        const right = document.querySelector('.f-map').getBoundingClientRect().right;
        return [...document.querySelectorAll('.f-kpi:not([hidden])')].every((one) =>
            one.getBoundingClientRect().right <= Math.min(card.right, right));
        }"""
    ), "no figure is cut"
    theatre.alarms(anew=True)


@pytest.mark.parametrize("address", ["/fleet", "/wall"])
def test_what_is_wrong_with_the_console_needs_somebody_and_old_alarms_are_no_comfort(
    look: Look, fleet: Callable[..., dict[str, Any]], theatre: Theatre, address: str
) -> None:
    gateway = {"title": "STOP service down", "text": "", "priority": 1, "name": "Headland"}
    theatre.alarms(put={"gateway-down.console": gateway})
    page = look(address, size="desk")
    row = "wall-row-gateway-down.console" if address == "/wall" else "fleet-notice-gateway-down.console"
    expect(page.get_by_test_id(row)).to_contain_text("STOP service down")
    band = page.locator(".w-old, .f-note")
    expect(band).to_be_hidden()
    theatre.alarms(old_s=30, drop=["gateway-down.console"])
    expect(band).to_contain_text("Do not rely on them")
    expect(page.get_by_test_id(row)).to_have_count(0)
    theatre.alarms(anew=True)


@pytest.mark.long
def test_on_a_tablet_every_figure_is_a_tap_away_and_no_disc_lies_on_a_button(
    look: Look, fleet: Callable[..., dict[str, Any]]
) -> None:
    page = look("/fleet", size="landscape")
    expect(page.get_by_test_id("fleet-kpi-slowest")).to_be_visible()
    expect(page.get_by_test_id("fleet-kpi-utilisation")).to_be_hidden()
    page.get_by_test_id("fleet-kpi-more").click()
    expect(page.get_by_test_id("fleet-kpi-utilisation")).to_contain_text("67")
    expect(page.get_by_test_id("fleet-kpi-interventions")).to_be_visible()
    page.wait_for_function("document.querySelectorAll('.f-map .hl-map-labels').length === 2")
    assert page.evaluate(
        """() => [...document.querySelectorAll('.f-map .hl-map-labels')].every((canvas) =>
            canvas.compareDocumentPosition(document.querySelector('.f-map .hl-map-controls'))
              & Node.DOCUMENT_POSITION_FOLLOWING)"""
    )


IN_SIGHT = """() => {
  const { engine, intake } = document.querySelector('.f-map .hl-map')?.hlMap ?? {};
  if (!engine || !intake.robots.size) return false;
  const { camera } = engine;
  return [...intake.robots.values()].filter((robot) => robot.pose).every(({ pose }) => {
    const [x, y] = camera.project(pose.mx, pose.my);
    return x > 0 && y > 0 && x < camera.width && y < camera.height;
  });
}"""
ZOOM = "document.querySelector('.f-map .hl-map').hlMap.engine.camera.zoom"


@pytest.mark.long
def test_a_turned_tablet_shows_the_whole_fleet_again_unless_the_map_was_moved(
    look: Look, fleet: Callable[..., dict[str, Any]]
) -> None:
    fleet()
    page = look("/fleet", size="desk")
    page.wait_for_function(IN_SIGHT)
    wide = page.evaluate(ZOOM)
    page.set_viewport_size({"width": 800, "height": 1280})
    page.wait_for_function(f"{ZOOM} < {wide} - 0.2")
    assert page.evaluate(IN_SIGHT)
    page.get_by_test_id("map-zoom-in").click()
    page.wait_for_timeout(600)
    near = page.evaluate(ZOOM)
    page.set_viewport_size({"width": 1920, "height": 1080})
    page.wait_for_timeout(600)
    assert page.evaluate(ZOOM) == pytest.approx(near)
