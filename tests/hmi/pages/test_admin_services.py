"""Admin, Cloud: the cards of planner service and forecast, whether or not there is a context broker."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, Route, expect

from hmi.presenters.cloud import clock_words, words_of
from hmi.presenters.services import service_words

Look = Callable[..., Page]


def service(key: str, name: str, state: str, **changes: Any) -> dict[str, Any]:
    """Return the row of a service as the console tells it."""
    head, text, level = service_words(key, state)
    told = {"key": key, "name": name, "state": state, "head": head, "text": text, "level": level}
    if state == "off":
        return told
    usual = {
        "why": "", "mend": "", "for_s": 431.0, "again_in_s": 0.0, "url": f"https://{key}.example/v1",
        "heard_utc": "2026-06-15T12:00:00.000+00:00", "delay_s": 0.184, "skew_s": 0.0, "clock": "", "last_error": None,
        "facts": [],
    }  # fmt: skip
    return {**told, **usual, **changes}


AWAY = service(
    "planner", "Planner service", "silent",
    why="GET : no answer in 5 s", mend="Check the load of the service and the delay of the network.",
    again_in_s=40.0, skew_s=95.0, clock=clock_words(95.0), facts=[["A plan may take", "30 s"]],
    last_error={"text": "GET : no answer in 5 s", "utc": "2026-06-15T11:58:02.000+00:00"},
)  # fmt: skip
WELL = service(
    "forecast", "Weather forecast", "ok", facts=[["Newest forecast", "24 min old"], ["Reaches ahead", "47 h"]]
)


def cloud_of(*services: dict[str, Any]) -> dict[str, Any]:
    """Return what the console tells of a farm without a context broker."""
    head, text, level = words_of("off")
    return {"state": "off", "head": head, "text": text, "level": level, "services": list(services)}


@pytest.mark.long
def test_a_service_that_is_away_says_why_what_to_do_and_when_it_is_asked_again(look: Look) -> None:
    told = [cloud_of(AWAY, WELL)]
    page = look("/fleet", role="admin")

    def reply(route: Route) -> None:
        route.fulfill(status=200, content_type="application/json", body=json.dumps(told[0]))

    page.route("**/api/v1/cloud", reply)
    page.get_by_test_id("nav-admin").click()
    page.get_by_test_id("admin-tab-cloud").click()
    planner = page.get_by_test_id("service-planner")
    expect(planner).to_have_attribute("data-state", "silent")
    expect(planner).to_contain_text("Missions are planned on this server meanwhile.")
    expect(planner).to_contain_text("To do: Check the load of the service")
    place = page.get_by_test_id("cloud-services")
    expect(place).to_contain_text("no answer in 5 s")
    expect(place).to_contain_text("95 s ahead of ours")
    expect(planner.get_by_test_id("clock-off")).to_contain_text("Its clock is 95 s ahead of this server's.")
    expect(place).to_contain_text("in 40 s")
    expect(place).to_contain_text("24 min old")
    expect(place).to_contain_text("184 ms (median of the last 50)")
    told[0] = cloud_of(service("planner", "Planner service", "off"), service("forecast", "Weather forecast", "off"))
    expect(planner).to_have_attribute("data-state", "off")
    expect(place).to_contain_text("HEADLAND_PLANNER_URL names a service.")


def broker_of(state: str, **changes: Any) -> dict[str, Any]:
    """Return what the console tells of a farm with a context broker."""
    head, text, level = words_of(state)
    delay = {"mean_s": 0.11, "p50_s": 0.1, "p99_s": 0.3, "count": 400}
    told = {
        "state": state, "head": head, "text": text, "level": level, "why": "", "mend": "", "for_s": 12.0,
        "again_in_s": 0.0, "heard_utc": "2026-06-15T12:00:00.000+00:00", "delay_s": 0.012, "skew_s": 0.0, "clock": "",
        "last_error": None, "url": "https://broker.example", "tenant": "farm", "path": "/", "can_take_tenant": False,
        "waiting": {"count": 3, "bytes": 1200, "limit_bytes": 2**26, "oldest_age_s": 70.0, "trouble": ""},
        "delays": {"robot_console": delay, "robot_cloud": delay, "mission": delay, "published_mean_s": 0.25},
        "counts": {"states": 9, "others": 40, "records": 7, "sent_twice": 0, "refused": 0, "last_refusal": "",
                   "dropped": 0, "heard_twice": 0, "lost_from_robots": 0},
        "map": {"proposals": 1, "left_out": 0, "is_told": True, "subscribed": True, "subscription_lost": 0,
                "subscription_lost_utc": None, "notifications": 12, "notifications_refused": 0, "is_storm": False,
                "old_news": 2},
        "services": [],
    }  # fmt: skip
    return {**told, **changes}


@pytest.mark.long
def test_the_broker_says_why_it_is_not_trusted_and_what_became_of_the_subscription(look: Look) -> None:
    why, mend = (
        "GET /version: Its certificate ran out.",
        "Have it renewed. If it is valid, this machine's clock is wrong.",
    )
    told = [broker_of("untrusted", why=why, mend=mend, again_in_s=21.0)]
    page = look("/fleet", role="admin")

    def reply(route: Route) -> None:
        route.fulfill(status=200, content_type="application/json", body=json.dumps(told[0]))

    page.route("**/api/v1/cloud", reply)
    page.get_by_test_id("nav-admin").click()
    page.get_by_test_id("admin-tab-cloud").click()
    state = page.get_by_test_id("cloud-state")
    expect(state).to_have_attribute("data-state", "untrusted")
    expect(state).to_contain_text(f"To do: {mend}")
    expect(page.get_by_test_id("cloud-oldest")).to_have_text("1 min old")
    expect(page.get_by_text("in 21 s")).to_be_visible()
    expect(page.get_by_test_id("cloud-delays-said")).to_contain_text("the newest 400 count")
    expect(page.get_by_test_id("cloud-delays-said")).to_contain_text("took 250 ms to its cloud")
    expect(page.get_by_test_id("cloud-delays-old")).to_contain_text("Nothing arrives in the cloud now")
    lost = {**told[0]["map"], "subscription_lost": 2, "subscription_lost_utc": "2026-06-15T11:00:00.000+00:00"}
    told[0] = broker_of("ok", map=lost, skew_s=-900.0, clock=clock_words(-900.0))
    expect(state).to_have_attribute("data-state", "ok")
    expect(state.get_by_test_id("clock-off")).to_contain_text("15 min behind this server's.")
    expect(page.get_by_test_id("cloud-delays-old")).to_have_count(0)
    expect(page.get_by_test_id("cloud-subscription-lost")).to_have_attribute("data-value", "2")
    told[0] = broker_of("ok", map={**lost, "untold": "no route to host"})
    expect(page.get_by_text("the broker does not get through to this console (no route to host)")).to_be_visible()
    told[0] = {**words_only("misset"), "services": []}
    expect(state).to_contain_text("Its settings cannot be used")
    expect(page.get_by_test_id("cloud-waiting")).to_have_count(0)


def words_only(state: str) -> dict[str, Any]:
    """Return what is told before there is a client."""
    found = broker_of(state)
    return {key: found[key] for key in found if key not in ("waiting", "delays", "counts", "map")}


@pytest.mark.long
def test_what_was_lost_on_the_way_and_what_the_cloud_refuses_is_listed_and_sent_again(look: Look) -> None:
    count = {"received": 990, "lost": 12, "late": 2, "twice": 4, "out_of_order": 1, "lost_share": 0.01,
             "lost_utc": "2026-06-15T11:00:00+00:00"}  # fmt: skip
    heard = {**count, "kinds": {"state": count}, "numbered": 23, "not_numbered": 1, "more_robots": 0,
             "robots": [{"id": "weeder-05", **count, "kinds": {"state": count}}]}  # fmt: skip
    row = {"id": "urn:ngsi-ld:Alert:hof:a-1", "type": "Alert", "why": "413 RequestEntityTooLarge",
           "is_kept": True, "bytes": 30_000, "utc": "2026-06-15T11:00:00+00:00",
           "happened_utc": "2026-06-15T10:00:00+00:00"}  # fmt: skip
    refused = {"records": 1, "rows": [row], "more": 0, "is_sending": False}
    told = [broker_of("ok", arrivals=heard, refused=refused)]
    asked: list[str] = []
    page = look("/fleet", role="admin")

    def reply(route: Route) -> None:
        request = route.request
        if request.method != "GET":
            asked.append(f"{request.method} {request.url.rpartition('/api/v1')[2]}")
            told[0] = broker_of("ok", arrivals=heard, refused={**refused, "records": 0, "rows": []})
        route.fulfill(status=200, content_type="application/json", body=json.dumps(told[0]))

    page.route("**/api/v1/cloud", reply)
    page.route("**/api/v1/cloud/refused**", reply)
    page.get_by_test_id("nav-admin").click()
    page.get_by_test_id("admin-tab-cloud").click()
    expect(page.get_by_test_id("cloud-lost-weeder-05-lost")).to_have_text("10 (1.0 %)")
    expect(page.get_by_test_id("cloud-lost-console")).to_contain_text("state 10")
    expect(page.get_by_text("1 of 24 robots do not number their messages")).to_be_visible()
    listed = page.get_by_test_id("cloud-refused-row")
    expect(listed).to_contain_text("413 RequestEntityTooLarge")
    expect(listed).to_contain_text("yes, 30 kB")
    page.get_by_test_id("cloud-refused-send").click()
    expect(listed).to_have_count(0)
    assert asked == ["POST /cloud/refused/send"]
