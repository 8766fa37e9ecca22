"""The alarms screen, counts, sound and strip in a browser, with the alarms of the stage."""

from __future__ import annotations

import json
import re
import time
import urllib.request
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.hmi.pages.conftest import SIZES, Theatre

Look = Callable[..., Page]
LINK, STOP, WIND = "link-lost.weeder-07", "stop-not-confirmed.weeder-07", "wind.uav-03"
ALARMS: dict[str, Any] = {
    STOP: {"title": "Stop not confirmed", "priority": 1, "latching": True, "first": LINK, "place": 2, "group": 2},
    LINK: {"ago_s": 12, "group": 2},
    WIND: {"title": "Wind above 11 m/s", "priority": 3, "state": "returned", "name": "Kestrel 3", "ago_s": 300},
    "seedlings.planter-01": {"title": "Seedlings: 14 left", "priority": 4, "state": "acknowledged", "seen_by": "A O"},
}


@pytest.fixture
def farm(theatre: Theatre) -> Theatre:
    """A stage with four alarms."""
    theatre.play("running")
    theatre.alarms(put=ALARMS)
    return theatre


def rows(page: Page) -> list[str]:
    """Return the ids of the rows from top to bottom."""
    found: list[str] = page.evaluate(
        """[...document.querySelectorAll('.al-rows .al-row')]
            .sort((a, b) => a.getBoundingClientRect().top - b.getBoundingClientRect().top)
            .map((row) => row.dataset.testid.replace('alarm-row-', ''))"""
    )
    return found


def opened(look: Look, **how: Any) -> Page:
    """Open the screen and wait for its list."""
    page = look("/alarms", **how)
    expect(page.locator(".al-rows .al-row").first).to_be_visible()
    return page


def test_alarms_are_listed_by_urgency_and_an_answer_shows_when_the_server_gave_it(look: Look, farm: Theatre) -> None:
    page = opened(look)
    assert rows(page) == [STOP, LINK, WIND, "seedlings.planter-01"]
    expect(page.get_by_test_id(f"alarm-row-{STOP}")).to_contain_text("2nd, after no data link")
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).to_contain_text("First out, 1 of 2")
    farm.alarms(refusal="Somebody is changing it.")
    page.get_by_test_id(f"alarm-ack-{LINK}").tap()
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).to_contain_text("Somebody is changing it.")
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).to_have_attribute("data-state", "unacknowledged")
    farm.alarms(refusal="")
    page.get_by_test_id(f"alarm-ack-{LINK}").tap()
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).to_have_attribute("data-state", "acknowledged")
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).to_contain_text("Active, acknowledged MK")
    page.get_by_test_id(f"alarm-ack-{WIND}").tap()
    expect(page.get_by_test_id(f"alarm-row-{WIND}")).to_have_count(0, timeout=10_000)
    assert [order["path"] for order in farm.orders("alarms/")] == [
        f"alarms/{LINK}/acknowledge", f"alarms/{LINK}/acknowledge", f"alarms/{WIND}/clear",
    ]  # fmt: skip


@pytest.mark.long
def test_counts_and_badge_are_on_every_screen_and_lead_to_the_list(look: Look, farm: Theatre) -> None:
    page = look("/fleet")
    expect(page.get_by_test_id("alarm-counts")).to_have_attribute("data-value", "1,1,1,1")
    expect(page.get_by_test_id("nav-alarms")).to_have_attribute("data-state", "unacknowledged")
    expect(page.get_by_test_id("nav-alarms")).to_have_attribute("data-value", "1")
    farm.alarms(put={STOP: {**ALARMS[STOP], "state": "acknowledged"}})
    expect(page.get_by_test_id("nav-alarms")).to_have_attribute("data-value", "2")
    page.get_by_test_id("alarm-counts").get_by_role("link").click()
    expect(page.get_by_test_id(f"alarm-row-{STOP}")).to_be_visible()
    farm.alarms(old_s=40)
    expect(page.get_by_test_id("alarm-counts")).to_have_attribute("data-state", "stale")
    expect(page.get_by_test_id("alarm-old")).to_contain_text(re.compile(r"Alarm list is 4\d s old. Do not rely on it."))


def test_rows_hold_still_under_a_pointer_and_new_ones_are_announced(look: Look, farm: Theatre) -> None:
    page = opened(look, size="desk")
    page.get_by_test_id(f"alarm-row-{WIND}").hover()
    page.get_by_test_id("alarm-row-seedlings.planter-01").hover()
    before = rows(page)
    farm.alarms(put={"person-ahead.weeder-01": {"title": "Somebody ahead", "ago_s": 0}}, drop=[LINK])
    expect(page.locator(".al-news")).to_contain_text("1 new, priority 2")
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).to_have_attribute("data-state", "normal")
    assert rows(page) == before
    page.mouse.move(5, 5)
    expect(page.get_by_test_id("alarm-row-person-ahead.weeder-01")).to_be_visible()
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).to_have_count(0)


@pytest.mark.long
def test_the_detail_says_what_to_do_and_whom_to_call(look: Look, farm: Theatre) -> None:
    page = opened(look, role="supervisor")
    page.get_by_test_id(f"alarm-row-{LINK}").click()
    expect(page.get_by_test_id("alarm-steps")).to_contain_text("Look before you walk up to it")
    expect(page.get_by_test_id("alarm-sequence").locator("time").first).to_have_text(
        re.compile(r"^\d\d:\d\d:\d\d\.\d\d$")
    )
    expect(page.get_by_test_id("alarm-call")).to_have_attribute("href", "tel:+491510000")
    expect(page.get_by_test_id("alarm-open")).to_have_attribute("href", "/operate/weeder-07")
    page.get_by_test_id("alarm-diagnose").click()
    expect(page.get_by_test_id("alarm-conclusion")).to_have_text("The robot's radio is silent, others are heard.")
    expect(page.locator(".al-check[data-state=unknown]")).to_contain_text("Cannot be told from here")
    page.keyboard.press("Escape")
    page.get_by_test_id(f"alarm-row-{STOP}").click()
    expect(page.get_by_test_id("alarm-shelve")).to_contain_text("not for priority 1")
    expect(page.get_by_test_id(f"alarm-shelve-{STOP}")).to_have_attribute("aria-disabled", "true")


@pytest.mark.long
def test_shelving_asks_for_time_and_reason_and_comes_back_by_hand(look: Look, farm: Theatre) -> None:
    page = opened(look, role="supervisor")
    page.get_by_test_id(f"alarm-row-{LINK}").click()
    page.get_by_test_id(f"alarm-shelve-{LINK}").click()
    sheet = page.get_by_test_id("alarm-shelve-sheet")
    sheet.get_by_role("button", name="Shelve", exact=True).click()
    expect(page.get_by_test_id("alarm-problem")).to_contain_text("Say why")
    assert farm.orders("shelve") == []
    sheet.get_by_role("radio", name="End of shift").click()
    page.get_by_test_id("alarm-reason").fill("Radio is being mended")
    sheet.get_by_role("button", name="Shelve", exact=True).click()
    expect(sheet).to_have_count(0)
    [order] = farm.orders("/shelve")
    assert (order["until_shift_end"], order["reason"]) == (True, "Radio is being mended")
    page.mouse.move(5, 5)  # the list holds still as long as the mouse is over it
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).to_have_count(0)
    page.get_by_test_id("alarms-tab-shelved").click()
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).to_contain_text("Shelved by AO until")
    page.get_by_test_id(f"alarm-shelve-{LINK}").click()
    page.mouse.move(5, 5)
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).to_have_count(0)
    assert len(farm.until_orders("/unshelve")) == 1


@pytest.mark.long
@pytest.mark.parametrize(
    ("role", "words"),
    [
        ("operator", "Shelving needs the supervisor role."),
        ("viewer", "You can watch alarms. Acknowledging needs the operator role."),
    ],
)
def test_what_a_role_may_not_do_stays_in_place_with_its_reason(
    look: Look, farm: Theatre, role: str, words: str
) -> None:
    page = opened(look, role=role)
    expect(page.get_by_test_id("alarm-rights")).to_have_text(words)
    expect(page.get_by_test_id("alarm-shelve-chosen")).to_contain_text("needs the supervisor role")
    page.get_by_test_id(f"alarm-ack-{LINK}").click(force=True)
    if role == "viewer":
        assert farm.orders("alarms/") == []


@pytest.mark.long
def test_no_alarms_says_when_the_last_one_was(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    three_hours_ago = round((time.time() - 3 * 3600) * 1000)
    theatre.alarms(journal=[{"at": three_hours_ago}])
    page = look("/alarms")
    expect(page.get_by_test_id("alarm-blank")).to_contain_text("No alarms.Last one 3 h 00 ago.")
    expect(page.get_by_test_id("alarm-counts")).to_have_attribute("data-value", "0,0,0,0")
    theatre.alarms(put={LINK: {}})
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).to_be_visible()
    expect(page.get_by_test_id("alarm-blank")).to_be_hidden()


def test_five_hundred_alarms_of_a_flood_stand_under_their_causes(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    flood: dict[str, Any] = {}
    for robot in range(1, 26):
        cause = f"link-lost.weeder-{robot:02}"
        for n in range(20):
            one = {"first": cause, "place": n + 1, "group": 20, "priority": 2 if n == 0 else 3, "ago_s": 30 - n / 10}
            flood[cause if n == 0 else f"follows-{n}.weeder-{robot:02}"] = one
    theatre.alarms(put=flood, flood={"since": 0, "count": 500})
    page = opened(look)
    expect(page.get_by_test_id("alarm-flood")).to_contain_text("Flood: 500 alarms in 10 min.")
    expect(page.get_by_role("table", name="Alarms")).to_have_attribute("aria-rowcount", "25")
    page.get_by_label("Show 19 that follow").first.click()
    expect(page.get_by_role("table", name="Alarms")).to_have_attribute("aria-rowcount", "44")
    theatre.alarms(flood=None)
    page.get_by_role("button", name="456 new, priority 3. Show").click()
    expect(page.get_by_role("table", name="Alarms")).to_have_attribute("aria-rowcount", "500")
    assert page.locator(".al-rows .al-row").count() < 40
    page.locator(".al-box").evaluate("(box) => (box.scrollTop = box.scrollHeight)")
    expect(page.locator(".al-row[aria-rowindex='500']")).to_be_visible()


@pytest.mark.long
def test_a_flood_that_grows_keeps_the_worst_on_top_and_its_answer_in_reach(look: Look, theatre: Theatre) -> None:
    theatre.play("running")
    theatre.alarms(put={"link-lost.weeder-01": {"group": 500}}, flood={"since": 0, "count": 10})
    page = opened(look)
    for batch in range(1, 21):
        follows = {
            f"follows-{batch}-{n}.weeder-01": {"first": "link-lost.weeder-01", "place": batch * 25 + n, "group": 500,
                                               "priority": 3, "ago_s": 0}
            for n in range(25)
        }  # fmt: skip
        theatre.alarms(put=follows, flood={"since": 0, "count": batch * 25})
        if batch == 10:
            theatre.alarms(put={STOP: {**ALARMS[STOP], "first": STOP, "place": 1, "group": 1, "ago_s": 0}})
    expect(page.get_by_test_id("alarm-flood")).to_contain_text("Flood: 500 alarms in 10 min.")
    expect(page.get_by_role("table", name="Alarms")).to_have_attribute("aria-rowcount", "2")
    assert rows(page) == [STOP, "link-lost.weeder-01"]
    expect(page.get_by_test_id("alarm-row-link-lost.weeder-01")).to_contain_text("First out, 1 of 500")
    page.get_by_test_id(f"alarm-ack-{STOP}").tap()
    expect(page.get_by_test_id(f"alarm-row-{STOP}")).to_have_attribute("data-state", "acknowledged")
    page.get_by_test_id("alarm-ack-link-lost.weeder-01").tap()
    expect(page.get_by_test_id("toast")).to_contain_text("501 acknowledged")


def test_the_first_touch_turns_the_sound_on_and_silence_leaves_the_list(look: Look, farm: Theatre) -> None:
    page = opened(look)
    sound = page.get_by_test_id("alarm-sound")
    expect(sound).to_have_attribute("data-state", "blocked")
    expect(page.get_by_test_id("alarm-sound-button")).to_contain_text("Sound is off. Tap to turn on.")
    page.locator(".al-kpi").first.tap()
    expect(sound).to_have_attribute("data-state", "on")
    expect(sound).to_have_attribute("data-value", "1")
    page.get_by_test_id("alarm-silence").tap()
    expect(sound).to_have_attribute("data-state", "silenced")
    assert rows(page)[0] == STOP
    farm.alarms(put={"outside-fence.uav-01": {"title": "Outside its fence", "priority": 1, "ago_s": 0}})
    expect(sound).to_have_attribute("data-state", "on")
    event = {"what": "raised", "id": "x", "priority": 1, "title": "Outside its fence", "name": "Kestrel 1", "by": ""}
    farm.alarms(tell=[event])
    expect(page.get_by_test_id("alarm-voice-alert")).to_have_text("Priority 1. Kestrel 1: Outside its fence.")


@pytest.mark.long
def test_keys_walk_the_list_and_acknowledge_but_moving_here_does_not(look: Look, farm: Theatre) -> None:
    page = look("/fleet", size="landscape")
    expect(page.get_by_test_id("nav-alarms")).to_have_attribute("data-state", "unacknowledged")
    page.keyboard.press("g")
    page.keyboard.press("a")
    expect(page.get_by_test_id(f"alarm-row-{STOP}")).to_be_visible()
    page.keyboard.press("j")
    page.keyboard.press("j")
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).to_have_attribute("aria-selected", "true")
    page.keyboard.press("g")
    page.keyboard.press("a")
    page.keyboard.press("Enter")
    expect(page.get_by_test_id("alarm-detail").get_by_role("heading", level=2)).to_be_focused()
    assert farm.orders("alarms/") == []
    page.keyboard.press("a")
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).to_have_attribute("data-state", "acknowledged")


def test_nothing_is_acknowledged_offline_or_later(look: Look, farm: Theatre) -> None:
    page = opened(look)
    page.wait_for_load_state("networkidle")
    page.evaluate("window.headland.link = () => 'server-lost'")
    page.get_by_test_id(f"alarm-ack-{LINK}").tap()
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).to_contain_text("Not sent: the link to the server is lost.")
    page.get_by_test_id("alarm-ack-shown").tap()
    expect(page.get_by_test_id("toast")).to_contain_text("Not sent")
    assert farm.orders("alarms") == []


@pytest.mark.long
def test_operate_shows_this_robots_worst_alarm_and_takes_the_answer(look: Look, farm: Theatre) -> None:
    page = look("/operate/weeder-07")
    strip = page.get_by_test_id("alarm-strip")
    expect(strip).to_have_attribute("data-value", STOP)
    page.get_by_test_id(f"strip-ack-{STOP}").tap()
    expect(strip).to_have_attribute("data-value", LINK)
    expect(strip).to_contain_text("Look before you walk up to it")
    page.get_by_test_id(f"strip-ack-{LINK}").tap()
    expect(strip).to_be_hidden()


def test_what_nobody_answered_says_so_in_the_strip_and_in_the_list(look: Look, farm: Theatre) -> None:
    page = look("/operate/weeder-07")
    strip = page.get_by_test_id("alarm-strip")
    expect(strip).not_to_contain_text("Nobody answered")
    farm.alarms(put={STOP: {**ALARMS[STOP], "escalated": round(time.time() * 1000)}})
    expect(strip).to_contain_text("Nobody answered, responsible: Martha Keller.")
    page.goto("/alarms")
    expect(page.get_by_test_id(f"alarm-row-{STOP}")).to_contain_text("Nobody answered")
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).not_to_contain_text("Nobody answered")


@pytest.mark.parametrize("screen", ["operate", "supervisor"])
def test_in_portrait_a_bell_counts_what_nobody_answered_and_leads_to_it(look: Look, farm: Theatre, screen: str) -> None:
    farm.alarms(put={STOP: {**ALARMS[STOP], "escalated": round(time.time() * 1000)}})
    page = look(f"/{screen}/weeder-07", size="portrait")
    bell = page.get_by_test_id("alarm-unanswered")
    expect(bell).to_be_visible()
    expect(bell).to_have_attribute("data-value", "1")
    box = bell.bounding_box()
    assert box is not None
    assert min(box["width"], box["height"]) >= 48
    assert page.evaluate("document.querySelector('.h-top').scrollWidth <= innerWidth")
    shown = "[...document.querySelectorAll('hl-alarms span')].filter((one) => one.offsetTop < 40).length"
    assert page.evaluate(shown) >= 3, "the counts of what is urgent stay"
    bell.click()
    expect(page.get_by_test_id(f"alarm-row-{STOP}")).to_be_visible()


def test_rows_and_detail_name_who_is_responsible_for_the_robot_now(look: Look, farm: Theatre) -> None:
    def tell(**wish: Any) -> None:
        body = json.dumps(wish).encode()
        urllib.request.urlopen(urllib.request.Request(f"{farm.url}/stage-fleet", body)).close()

    tell(anew=True)
    page = opened(look)
    row = page.get_by_test_id(f"alarm-row-{LINK}").locator(".robot")
    expect(row).to_have_text("Weeder 07")  # nobody takes robots on this farm
    held = {"user": "operator", "name": "Martha Keller", "since": 1, "note": "", "offer": None}
    tell(duty={"weeder-07": held})
    farm.alarms(tell=[{"kind": "duty", "what": "taken"}])
    expect(row).to_contain_text("Martha Keller")
    page.get_by_test_id(f"alarm-row-{LINK}").click()
    expect(page.get_by_test_id("alarm-detail")).to_contain_text("Responsible: Martha Keller.")
    tell(duty={"weeder-01": held})
    farm.alarms(tell=[{"kind": "duty", "what": "released"}])
    expect(row).to_contain_text("unassigned")
    expect(page.get_by_test_id("alarm-detail")).to_contain_text("Responsible: nobody.")
    tell(anew=True)


SMALL = """[...document.querySelectorAll('.al-screen button, .al-screen a, .al-screen select, .al-screen input')]
    .filter((node) => node.offsetParent).map((node) => [node, node.getBoundingClientRect()])
    .filter(([node, box]) => box.height < 46 || box.width < 46).map(([node]) => node.outerHTML.slice(0, 90))"""
ASIDE = (
    "document.documentElement.scrollWidth > innerWidth || document.querySelector('.al-screen').scrollWidth > innerWidth"
)


@pytest.mark.long
@pytest.mark.parametrize("size", SIZES)
def test_targets_are_large_and_nothing_scrolls_sideways(look: Look, farm: Theatre, size: str) -> None:
    page = opened(look, role="supervisor", size=size)
    page.get_by_test_id(f"alarm-row-{LINK}").click()
    expect(page.get_by_test_id("alarm-steps")).to_be_visible()
    assert page.evaluate(SMALL) == []
    assert not page.evaluate(ASIDE)
    assert page.evaluate(
        """() => { const box = document.querySelector('[data-testid=stop]').getBoundingClientRect();
            return Boolean(document.elementFromPoint(box.x + box.width / 2, box.y + 4)?.closest('#headland-stop')); }"""
    )


@pytest.mark.long
def test_journal_and_statistics_open_and_the_chart_has_a_table(look: Look, farm: Theatre) -> None:
    step = {
        "at": 1,
        "what": "raised",
        "priority": 2,
        "title": "No data link",
        "name": "Weeder 07",
        "seq": 1,
        "by": "",
        "text": "x",
    }
    farm.alarms(journal=[step])
    page = opened(look)
    page.get_by_test_id("alarms-tab-journal").click()
    expect(page.get_by_test_id("alarm-journal")).to_contain_text("No data link")
    with page.expect_download() as download:
        page.get_by_test_id("alarm-export").click()
    assert download.value.suggested_filename.endswith(".csv")
    page.get_by_test_id("alarms-tab-statistics").click()
    expect(page.get_by_test_id("alarm-statistics")).to_contain_text("Position not exact")
    page.get_by_test_id("alarm-chart-table").click()
    expect(page.get_by_role("columnheader", name="From")).to_be_visible()


@pytest.mark.long
def test_an_admin_adds_a_web_address_and_a_test_shows_the_real_answer(look: Look, farm: Theatre) -> None:
    page = look("/admin", role="admin")
    page.get_by_test_id("admin-tab-notifications").click()
    expect(page.get_by_text("Nobody is told outside the console")).to_be_visible()
    page.get_by_test_id("notify-add-webhook").click()
    page.get_by_test_id("notify-name").fill("On call")
    page.get_by_role("button", name="Save").last.click()
    expect(page.get_by_test_id("notify-problem")).to_contain_text("Address")
    page.get_by_test_id("notify-url").fill("https://calls.example/alarm")
    page.get_by_test_id("notify-secret").fill("not shown again")
    page.get_by_role("button", name="Save").last.click()
    [order] = farm.until_orders("notifications")
    [channel] = order["channels"]
    assert (channel["url"], channel["secret"]) == ("https://calls.example/alarm", "not shown again")
    assert (channel["priorities"], channel["steps"]) == ([1, 2], ["raised", "escalated"])
    page.get_by_test_id(f"notify-test-{channel['id']}").click()
    expect(page.get_by_test_id(f"notify-last-{channel['id']}")).to_have_text(
        "Test failed: The other side answered 403."
    )
    page.get_by_test_id(f"notify-edit-{channel['id']}").click()
    expect(page.get_by_test_id("notify-secret")).to_have_value("")
    page.get_by_test_id("notify-priority-2").uncheck()
    page.get_by_role("button", name="Save").last.click()
    changed = farm.until_orders("notifications", 2)[1]["channels"][0]
    assert (changed["id"], changed["secret"], changed["priorities"]) == (channel["id"], None, [1])


HOOK = {"id": "hook", "name": "Control room", "kind": "webhook", "url": "https://hooks.example/…", "is_on": True,
        "priorities": [1], "steps": ["raised"], "robots": [], "per_hour": 30, "secret": "kept"}  # fmt: skip


@pytest.mark.long
def test_what_an_admin_typed_stays_when_somebody_else_saved_first(look: Look, farm: Theatre) -> None:
    page = look("/admin", role="admin")
    page.get_by_test_id("admin-tab-notifications").click()
    expect(page.get_by_text("Nobody is told outside the console")).to_be_visible()
    farm.alarms(channels=[HOOK], saved=1)
    page.get_by_test_id("notify-add-webhook").click()
    page.get_by_test_id("notify-name").fill("On call")
    page.get_by_test_id("notify-url").fill("https://calls.example/alarm")
    page.get_by_role("button", name="Save").last.click()
    expect(page.get_by_test_id("notify-problem")).to_contain_text("Not saved: Somebody changed it meanwhile.")
    page.route("**/api/v1/alarms/notifications", lambda route: route.abort())
    page.get_by_test_id("notify-problem-load").click()
    expect(page.get_by_test_id("notify-problem")).to_contain_text("Not loaded: no answer. Try again.")
    page.unroute("**/api/v1/alarms/notifications")
    page.get_by_test_id("notify-problem-load").click()
    expect(page.get_by_test_id("notify-problem")).to_contain_text("What you typed is still here")
    expect(page.get_by_test_id("notify-row-hook")).to_be_attached()
    expect(page.get_by_test_id("notify-name")).to_have_value("On call")
    page.get_by_role("button", name="Save").last.click()
    order = farm.until_orders("notifications", 2)[1]
    assert [one["name"] for one in order["channels"]] == ["Control room", "On call"]
    assert (order["channels"][0]["secret"], order["escalate_after_s"]) == (None, None)
    expect(page.get_by_test_id("notify-sheet")).to_have_count(0)

    farm.alarms(saved=7)
    page.get_by_test_id("notify-after-1").fill("45")
    page.get_by_test_id("notify-limits").get_by_role("button", name="Save").click()
    expect(page.get_by_test_id("notify-limits-problem")).to_contain_text("Somebody changed it meanwhile.")
    expect(page.get_by_test_id("notify-after-1")).to_have_value("45")
    page.get_by_test_id("notify-limits-problem-load").click()
    expect(page.get_by_test_id("notify-after-1")).to_have_value("60")
    page.get_by_test_id("notify-after-1").fill("45")
    page.get_by_test_id("notify-limits").get_by_role("button", name="Save").click()
    order = farm.until_orders("notifications", 4)[3]
    assert (order["channels"], order["escalate_after_s"]["1"], order["revision"]) == (None, 45, 7)


PLACES = """() => ['hl-link', 'hl-alarms', 'hl-theme', 'hl-clock', 'hl-user'].map((tag) => {
  const box = document.querySelector(tag).getBoundingClientRect(); return [tag, box.right, box.top, box.height]; })"""


@pytest.mark.parametrize("size", ["landscape", "portrait"])
def test_what_nobody_answered_is_said_in_the_top_bar_and_moves_nothing(look: Look, farm: Theatre, size: str) -> None:
    page = look("/fleet", size=size)
    farm.alarms(put={"x.weeder-02": {"escalated": 5, "state": "acknowledged"}})
    expect(page.get_by_test_id("alarm-counts")).to_have_attribute("data-value", re.compile("."))
    expect(page.get_by_test_id("alarm-sound")).to_have_attribute("data-state", re.compile("."))
    said = page.get_by_test_id("alarm-unanswered")
    expect(said).to_be_hidden()
    before = page.evaluate(PLACES)
    farm.alarms(put={LINK: {**ALARMS[LINK], "escalated": 5}})
    expect(said).to_be_visible()
    expect(said).to_have_attribute("aria-label", "1 not answered. Go to Alarms")
    expect(said.locator("b")).to_have_text("1")
    assert said.get_by_text("not answered").is_visible() == (size == "landscape")
    assert page.evaluate(PLACES) == before
    assert page.evaluate("(top => top.scrollWidth <= top.clientWidth)(document.querySelector('.h-top'))")
    said.click()
    expect(page.get_by_test_id(f"alarm-row-{LINK}")).to_be_visible()
    expect(said).to_be_hidden()
    farm.alarms(drop=[LINK])
    page.get_by_test_id("nav-fleet").click()
    expect(page.get_by_test_id("alarm-row-" + LINK)).to_have_count(0)
    expect(said).to_be_hidden()
