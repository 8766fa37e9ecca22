"""Admin, Cloud: the cards of planner service and forecast, whether or not there is a context broker."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, Route, expect

from hmi.presenters.cloud import words_of
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
        "heard_utc": "2026-06-15T12:00:00.000+00:00", "delay_s": 0.184, "skew_s": 0.0, "last_error": None, "facts": [],
    }  # fmt: skip
    return {**told, **usual, **changes}


AWAY = service(
    "planner", "Planner service", "silent",
    why="GET : no answer in 5 s", mend="Check the load of the service and the delay of the network.",
    again_in_s=40.0, skew_s=95.0, facts=[["A plan may take", "30 s"]],
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
    expect(place).to_contain_text("in 40 s")
    expect(place).to_contain_text("24 min old")
    expect(place).to_contain_text("184 ms (median)")
    told[0] = cloud_of(service("planner", "Planner service", "off"), service("forecast", "Weather forecast", "off"))
    expect(planner).to_have_attribute("data-state", "off")
    expect(place).to_contain_text("HEADLAND_PLANNER_URL names a service.")
