"""No fault of the cloud makes an order late: whatever breaks, and whenever it ends, nothing is carried out by then."""

from __future__ import annotations

import re
import ssl
from collections.abc import Callable
from datetime import timedelta
from pathlib import Path

import httpx
import pytest

from backend_clients.cloud_robot.names import ANSWER, ORDER
from backend_clients.http.retry import RetryPolicy
from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.connection import Broker
from backend_clients.ngsi.tenant import Tenant
from backend_clients.simulator.cloud_agent import CloudAgents
from hmi.cloud.missions import ANSWER_S, TIDY_S, TTL_S, CloudMissions
from hmi.domain.command import OrderFailed
from tests.hmi.cloud.rig import Road
from tests.hmi.cloud.test_missions import Elsewhere, Farm, document

PORT = Path(__file__).parents[3] / "static/js/ui/port.js"
LONG_AFTER = (0.0, 1.0, 5.0, 60.0, 3_600.0, 86_400.0)
Answer = Exception | httpx.Response | None
Breaks = Callable[["Broken", httpx.Request], Answer]


class Broken(Farm):
    """A farm whose console and agents reach the broker over roads that break apart from each other."""

    def __init__(self, ahead: timedelta = timedelta()) -> None:
        super().__init__("weeder-01")
        self.here, self.there = Road(self.transport, self.clock), Road(self.transport, self.clock)
        self.console = CloudMissions(self._client(self.here), "hof", self.clock, self.delays, self.passes,
                                     is_ours=self.asked)  # fmt: skip
        theirs = Elsewhere(self.clock, ahead)
        self.agents = CloudAgents(self._client(self.there), "hof", dict(self.world.robots), theirs, self._acked)
        self.taken_s: list[float] = []

    def _client(self, road: Road) -> NgsiClient:
        broker = Broker("http://broker.test", Tenant("farm"), timeout_s=8, retry=RetryPolicy(attempts=1))
        return NgsiClient(broker, transport=road)

    def _acked(self, robot: str, ack: object) -> None:
        self.taken_s.append(self.clock.mono_s())

    async def passes(self, seconds: float) -> None:
        """Let time pass, with the agents trying as they do."""
        self.clock.advance(seconds)
        self.world.step(min(seconds, 1.0))
        await self.agents._try()

    def breaks(self, how: Breaks) -> None:
        """Break both roads."""
        self.here.broken = self.there.broken = lambda request: how(self, request)

    def mends(self) -> None:
        """End every fault."""
        self.here.broken = self.there.broken = None
        self.here.delay_s = self.there.delay_s = 0.0


def half_open(farm: Broken, request: httpx.Request) -> Answer:
    """Take the request and say nothing until the client gives up."""
    farm.clock.advance(8.0)
    return httpx.ReadTimeout("", request=request)


def failing(_farm: Broken, _request: httpx.Request) -> Answer:
    """Answer as a broker does whose database is away."""
    return httpx.Response(503, json={"error": "Unavailable", "description": "no database"})


def too_large(_farm: Broken, request: httpx.Request) -> Answer:
    """Refuse what has a body."""
    return httpx.Response(413, html="<p>too large</p>") if request.method == "POST" else None


def untrusted(_farm: Broken, request: httpx.Request) -> Answer:
    """Raise what httpx raises for a certificate that ran out."""
    error = httpx.ConnectError("certificate verify failed", request=request)
    error.__cause__ = ssl.SSLCertVerificationError("certificate has expired")
    return error


def moved(_farm: Broken, request: httpx.Request) -> Answer:
    """Look as an empty tenant does."""
    if request.method == "GET" and request.url.path == "/v2/entities":
        return httpx.Response(200, json=[], headers={"Fiware-Total-Count": "0"})
    return httpx.Response(404, json={"error": "NotFound", "description": "The requested entity has not been found."})


FAULTS = {
    "broker slow": None,
    "5xx": failing,
    "half-open": half_open,
    "wrong tenant": moved,
    "413": too_large,
    "certificate": untrusted,
}


def is_still(farm: Broken) -> bool:
    """Say whether the robot stands and nothing on it was started."""
    robot = farm.world.robots["weeder-01"]
    assert robot.boot is not None
    run = robot.boot.brain.run
    return robot.machine.is_standing and (run is None or run.status == "loaded")


async def ends(farm: Broken) -> None:
    """End the fault, and let a day go by."""
    farm.mends()
    for later_s in LONG_AFTER:
        await farm.passes(later_s)
        await farm.console.tidy()


async def is_sent(farm: Broken) -> bool:
    """Send a mission; return whether the console says that the robot has it."""
    try:
        return (await farm.console.upload_mission("weeder-01", document())).is_accepted
    except OrderFailed:
        return False


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("begins", ["before it is put", "while it waits", "in the agent alone", "after it arrived"])
async def test_no_order_is_carried_out_late_whatever_breaks_and_whenever_it_ends(fault: str, begins: str) -> None:
    farm, broken = Broken(), FAULTS[fault]
    await farm.agents.round()
    begin_s = farm.clock.mono_s()

    def begin(request: httpx.Request | None = None) -> Answer:
        if request is not None and request.method != "POST":
            return None
        for road in (farm.there,) if begins == "in the agent alone" else (farm.here, farm.there):
            road.delay_s = 7.0 if broken is None else 0.0
            road.broken = None if broken is None else (lambda one: broken(farm, one))
        # what begins after it arrived begins with the next request: this one goes through
        return None

    farm.here.broken = begin
    if begins in ("before it is put", "in the agent alone"):
        begin()
    if begins == "while it waits":
        farm.there.broken = failing_for(farm)
    is_accepted = await is_sent(farm)
    taken = list(farm.taken_s)
    await ends(farm)
    assert all(at_s - begin_s <= TTL_S for at_s in farm.taken_s), "nothing is taken that was decided long ago"
    assert is_accepted <= bool(taken)
    assert is_still(farm)
    assert (await farm.entities(ORDER), await farm.entities(ANSWER)) == ([], []), "nothing lies in wait"


def failing_for(farm: Broken) -> Callable[[httpx.Request], Answer]:
    """Keep the agents away until the order is old."""
    until_s = farm.clock.mono_s() + TTL_S + 1
    return lambda request: failing(farm, request) if farm.clock.mono_s() < until_s else None


async def test_an_answer_that_comes_late_changes_nothing_and_starts_nothing() -> None:
    farm = Broken()
    await farm.agents.round()
    await farm.console.tidy()  # of an earlier run

    held: list[httpx.Request] = []

    def holds_answers_back(request: httpx.Request) -> Answer:
        if b"CommandReturnMessage" not in request.content:
            return None
        held.append(request)
        return httpx.ReadTimeout("", request=request)

    farm.there.broken = holds_answers_back
    with pytest.raises(OrderFailed) as failed:
        await farm.console.upload_mission("weeder-01", document())
    assert (failed.value.code, failed.value.is_outcome_known) == ("no_answer", False)
    assert "Should it have the mission, it does not move by it" in failed.value.text
    assert farm.held("weeder-01"), "it came in time, and only its answer did not"
    assert farm.delays.told().count == 0
    late = httpx.Request("POST", held[0].url, content=held[0].content, headers=held[0].headers)
    await farm.transport.handle_async_request(late)
    assert len(await farm.entities(ANSWER)) == 1
    await ends(farm)
    assert len(farm.taken_s) == 1
    assert is_still(farm)
    assert await farm.entities(ANSWER) == [], "an answer nobody waits for is taken away"


@pytest.mark.parametrize("ahead", [timedelta(days=-400), timedelta(seconds=-40), timedelta(hours=3)])
async def test_a_clock_that_is_off_makes_no_old_order_fresh(ahead: timedelta) -> None:
    farm = Broken(ahead)
    await farm.agents.round()
    farm.there.broken = failing_for(farm)
    assert not await is_sent(farm)
    await ends(farm)
    assert (farm.taken_s, farm.held("weeder-01")) == ([], "")


async def test_the_screen_waits_at_least_as_long_as_the_console_whose_broker_is_slow() -> None:
    farm = Broken()
    await farm.agents.round()
    farm.here.delay_s, farm.there.broken = (
        7.9,
        lambda request: failing(farm, request),
    )  # each answer comes just before it is given up
    begin_s = farm.clock.mono_s()
    with pytest.raises(OrderFailed):
        await farm.console.upload_mission("weeder-01", document())
    (waits_ms,) = re.findall(r'way === "cloud" \? (\d+)', PORT.read_text())
    assert farm.clock.mono_s() - begin_s < int(waits_ms) / 1000


async def test_nothing_is_put_into_a_tenant_that_is_not_ours_although_a_robot_of_that_name_listens_there() -> None:
    farm = Broken()
    await farm.agents.round()
    farm.is_ours = False
    with pytest.raises(OrderFailed) as failed:
        await farm.console.upload_mission("weeder-01", document())
    assert (failed.value.code, failed.value.is_outcome_known) == ("cloud_not_ours", True)
    assert {one.method for one in farm.here.requests} <= {"GET"}
    await ends(farm)
    assert (farm.taken_s, farm.held("weeder-01")) == ([], "")


def test_an_order_is_dead_before_the_console_stops_waiting_for_it() -> None:
    assert TTL_S < ANSWER_S < TIDY_S
