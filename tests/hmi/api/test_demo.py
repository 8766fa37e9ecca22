"""The demo panel's routes: what they tell, who may, and what happens without the simulator."""

from __future__ import annotations

import json
from typing import Any

import httpx

from hmi.api.demo import demo_routes
from hmi.app.demo import SimulatorStage
from hmi.demo.fleet import write_demo_fleet
from hmi.domain.role import Role
from tests.hmi.api.console import Console

TOLD = {"situations": [{"id": "rtk-float"}], "now": {"weeder-01": "rtk-float"}}
PATH = "/demo/robots/weeder-01/situation"


class Simulator:
    """What the tester's HTTP of a simulator answers."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, str, Any]] = []
        self.status, self.body = 200, TOLD
        self.is_away = False

    def __call__(self, request: httpx.Request) -> httpx.Response:
        """Answer one request."""
        if self.is_away:
            raise httpx.ConnectError("nobody there")
        body = json.loads(request.content) if request.content else None
        self.asked.append((request.method, request.url.path, body))
        return httpx.Response(self.status, json=self.body)


async def staged(console: Console, role: Role = Role.OPERATOR) -> tuple[httpx.AsyncClient, Simulator]:
    """Return a browser of a console that runs as demo, and its simulator."""
    simulator = Simulator()
    write_demo_fleet(console.folder, "http://127.0.0.1:9000")
    stage = SimulatorStage(console.folder, httpx.MockTransport(simulator))
    console.api.include_router(demo_routes(stage, console.authorize))
    return await console.browser(role), simulator


async def test_outside_the_demo_there_is_no_such_route(console: Console) -> None:
    browser = await console.browser(Role.OPERATOR)
    assert (await browser.get("/demo/situations")).status_code == 404
    assert (await browser.post(PATH, json={"situation": None})).status_code == 404


async def test_a_viewer_sees_what_can_happen_and_may_not_start_it(console: Console) -> None:
    browser, simulator = await staged(console, Role.VIEWER)
    assert (await browser.get("/demo/situations")).json() == TOLD
    refused = await browser.post(PATH, json={"situation": "rtk-float"})
    assert (refused.status_code, refused.json()["code"]) == (403, "not_allowed")
    assert [method for method, _, _ in simulator.asked] == ["GET"]


async def test_an_operator_starts_and_ends_a_situation(console: Console) -> None:
    browser, simulator = await staged(console)
    for wanted in ("rtk-float", None):
        answer = await browser.post(PATH, json={"situation": wanted})
        assert answer.json() == {"robot": "weeder-01", "situation": wanted}
        assert simulator.asked[-1] == ("POST", "/_situations/weeder-01", {"situation": wanted})


async def test_what_cannot_happen_is_said_in_a_sentence(console: Console) -> None:
    browser, simulator = await staged(console)
    simulator.status = 409
    simulator.body = {"code": "not_possible", "text": "Crane outside its limit cannot happen to a weeder."}
    refused = await browser.post(PATH, json={"situation": "crane-limit"})
    assert (refused.status_code, refused.json()["text"]) == (409, simulator.body["text"])
    simulator.status = 404
    assert (await browser.post(PATH, json={"situation": "no-such"})).status_code == 404
    assert (await browser.post(PATH, json={"situation": "../x"})).status_code in (400, 422)


async def test_a_simulator_that_is_away_is_told_as_that(console: Console) -> None:
    browser, simulator = await staged(console)
    simulator.is_away = True
    for answer in (await browser.get("/demo/situations"), await browser.post(PATH, json={"situation": None})):
        assert (answer.status_code, answer.json()["code"]) == (503, "simulator_away")


async def test_an_operator_provokes_a_field_sensor_and_a_viewer_does_not(console: Console) -> None:
    path = "/demo/stations/soil-03/situation"
    browser, simulator = await staged(console)
    answer = await browser.post(path, json={"situation": "sensor-silent"})
    assert answer.json() == {"station": "soil-03", "situation": "sensor-silent"}
    assert simulator.asked[-1] == ("POST", "/_situations/soil-03", {"situation": "sensor-silent"})
    simulator.status = 404
    unknown = await browser.post("/demo/stations/no-such/situation", json={"situation": None})
    assert (unknown.status_code, unknown.json()["code"]) == (404, "not_found")
    many = len(simulator.asked)
    assert (await browser.post("/demo/stations/..%2F_faults/situation", json={"situation": None})).status_code >= 400
    assert (await browser.post("/demo/stations/Soil%20/situation", json={"situation": None})).status_code in (400, 422)
    assert len(simulator.asked) == many


async def test_provoking_a_sensor_needs_the_operator_role(console: Console) -> None:
    viewer, simulator = await staged(console, Role.VIEWER)
    refused = await viewer.post("/demo/stations/soil-03/situation", json={"situation": None})
    assert (refused.status_code, refused.json()["code"]) == (403, "not_allowed")
    assert simulator.asked == []
