"""Missions through the cloud: read back by hash, never late, and nothing that anybody has to wait for."""

from __future__ import annotations

import os
from datetime import datetime, timedelta
from typing import Any

import httpx
import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from backend_clients.cloud_robot.mission_answer import MissionAnswer, read_answer
from backend_clients.cloud_robot.mission_order import MissionOrder, read_order
from backend_clients.cloud_robot.names import ANSWER, ORDER, PRESENCE, answer_ref, order_ref, presence_ref
from backend_clients.cloud_robot.packing import packed, unpacked
from backend_clients.cloud_robot.presence import Presence
from backend_clients.edge import messages_up as up
from backend_clients.http.retry import RetryPolicy
from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.connection import Broker
from backend_clients.ngsi.entity import Entity, entity_from_wire
from backend_clients.ngsi.errors import BadInput, Unreadable
from backend_clients.ngsi.query import Query
from backend_clients.ngsi.tenant import Tenant
from backend_clients.simulator.cloud_agent import CloudAgents
from backend_clients.simulator.config import RobotConfig
from backend_clients.simulator.context_broker.application import make_application
from backend_clients.simulator.context_broker.broker import ContextBroker
from backend_clients.simulator.context_broker.faults import Faults, FaultSwitch
from backend_clients.simulator.faults import Silence
from backend_clients.simulator.world import World
from hmi.clock import FakeClock
from hmi.cloud import missions
from hmi.cloud.delays import Delays
from hmi.cloud.missions import ANSWER_S, TIDY_S, CloudMissions
from hmi.domain.command import OrderFailed
from hmi.domain.mission_document import mission_sha256
from hmi.fiware.normalized import key_values
from tests.backend_clients.simulator.rig import small_mission
from tests.hmi.fiware.models import check

AT = FakeClock().utc()


class Elsewhere:
    """A clock whose date somebody set wrong; it ticks as the other does."""

    def __init__(self, clock: FakeClock, ahead: timedelta) -> None:
        self._clock, self._ahead = clock, ahead

    def utc(self) -> datetime:
        """See ``Clock``."""
        return self._clock.utc() + self._ahead

    def mono_s(self) -> float:
        """See ``Clock``."""
        return self._clock.mono_s() + 5_000.0


class Farm:
    """A console, a broker and real simulated robots with agents; time passes while the console waits."""

    def __init__(self, *robots: str, robots_ahead: timedelta | None = None) -> None:
        self.clock, self.switch = FakeClock(), FaultSwitch()
        self.world = World(tuple(RobotConfig(one, one, "t" * 8) for one in robots), self.clock, seed=1, speed=1.0)
        self.transport = httpx.ASGITransport(make_application(ContextBroker(self.clock, None), self.switch))
        self.acks: list[tuple[str, up.Ack]] = []
        theirs = self.clock if robots_ahead is None else Elsewhere(self.clock, robots_ahead)
        self.agents = CloudAgents(self.client(), "hof", dict(self.world.robots), theirs, self._acked)
        self.delays = Delays()
        self.is_away = False
        self.console = CloudMissions(self.client(), "hof", self.clock, self.delays, self.passes, is_ours=self.asked,
                                     is_away=lambda: self.is_away)  # fmt: skip
        self.agents_are_slow_s = 0.0
        self.are_agents_on = True
        self.seen: list[dict[str, Any]] = []
        self.is_ours = True

    async def asked(self) -> bool:
        """Say whether the tenant is the console's; asks the broker, as the console does."""
        await self.client().find(presence_ref("hof", "console"))
        return self.is_ours

    def client(self) -> NgsiClient:
        """Return a client of the farm's tenant."""
        broker = Broker("http://broker.test", Tenant("farm"), retry=RetryPolicy(attempts=1))
        return NgsiClient(broker, transport=self.transport)

    async def passes(self, seconds: float) -> None:
        """Let time pass, with the agents doing their round."""
        self.clock.advance(seconds + self.agents_are_slow_s)
        self.world.step(seconds)
        self.seen += [key_values(one) for one in await self.entities(ORDER)]
        if self.are_agents_on:
            await self.agents.round()
        self.seen += [key_values(one) for one in await self.entities(ANSWER)]

    async def entities(self, kind: str) -> list[Any]:
        """Return what the broker has of one type, past every fault."""
        faults, self.switch.faults = self.switch.faults, Faults()
        found = [one async for one in self.client().entities(Query(types=(kind,)))]
        self.switch.faults = faults
        return found

    def held(self, robot: str) -> str:
        """Return the hash of the mission a robot holds, empty if it holds none."""
        boot = self.world.robots[robot].boot
        assert boot is not None
        return boot.brain.run.sha256 if boot.brain.run is not None else ""

    def _acked(self, robot: str, ack: up.Ack) -> None:
        self.acks.append((robot, ack))


def document(robot: str = "weeder-01", **more: Any) -> dict[str, Any]:
    """Return a stored mission."""
    found: dict[str, Any] = msgspec.to_builtins(small_mission(robot, **more))
    return found


async def test_a_mission_through_the_cloud_is_read_back_and_starts_nothing() -> None:
    farm = Farm("weeder-01")
    await farm.agents.round()
    answer = await farm.console.upload_mission("weeder-01", document())
    assert answer.is_accepted
    assert answer.sha256 == mission_sha256(document()) == farm.held("weeder-01")
    assert farm.delays.told().count == 1
    for _ in range(100):
        farm.clock.advance(0.1)
        farm.world.step(0.1)
    robot = farm.world.robots["weeder-01"]
    assert robot.machine.is_standing
    assert robot.boot is not None
    assert robot.boot.brain.run is not None
    assert robot.boot.brain.run.status == "loaded"
    assert [one.outcome for _, one in farm.acks] == ["accepted"]


async def test_order_and_answer_fit_the_published_models_and_are_taken_away_after() -> None:
    farm = Farm("weeder-01")
    await farm.agents.round()
    await farm.console.upload_mission("weeder-01", document())
    assert {one["type"] for one in farm.seen} == {ORDER, ANSWER}
    for entity in farm.seen:
        check(entity)
    (presence,) = await farm.entities(PRESENCE)
    check(key_values(presence))
    assert await farm.entities(ORDER) == []
    assert await farm.entities(ANSWER) == []


async def test_a_robot_without_an_agent_is_told_of_before_anything_is_sent() -> None:
    farm = Farm("weeder-01")
    with pytest.raises(OrderFailed) as failed:
        await farm.console.upload_mission("weeder-02", document("weeder-02"))
    assert (failed.value.code, failed.value.is_outcome_known) == ("no_agent", True)
    assert farm.seen == []


async def test_an_order_that_is_picked_up_late_is_refused_by_the_robot() -> None:
    farm = Farm("weeder-01")
    await farm.agents.round()
    farm.agents_are_slow_s = 21.0
    answer = await farm.console.upload_mission("weeder-01", document())
    assert (answer.is_accepted, answer.code) == (False, "expired")
    assert farm.held("weeder-01") == ""
    assert farm.acks == []
    ignored = [one for one in farm.seen if one["type"] == ANSWER]
    assert {one["result"] for one in ignored} == {"ignore"}
    for entity in ignored:
        check(entity)


@pytest.mark.parametrize("ahead", [timedelta(days=400), timedelta(hours=-3), timedelta(seconds=40)])
async def test_a_robot_whose_date_is_wrong_takes_what_is_fresh_and_nothing_that_is_late(ahead: timedelta) -> None:
    farm = Farm("weeder-01", robots_ahead=ahead)
    await farm.agents.round()
    farm.agents_are_slow_s = 21.0
    late = await farm.console.upload_mission("weeder-01", document())
    assert (late.is_accepted, late.code, farm.held("weeder-01")) == (False, "expired", "")
    farm.agents_are_slow_s = 0.0
    assert (await farm.console.upload_mission("weeder-01", document())).is_accepted


async def test_an_order_left_behind_is_never_carried_out_however_late_it_is_found() -> None:
    farm = Farm("weeder-01")
    await farm.agents.round()
    farm.are_agents_on = False
    farm.switch.set(Faults(status=503, methods=("DELETE",)))  # it cannot even be withdrawn
    with pytest.raises(OrderFailed) as failed:
        await farm.console.upload_mission("weeder-01", document())
    assert (failed.value.code, failed.value.is_outcome_known) == ("no_answer", False)
    farm.switch.set(Faults())
    assert len(await farm.entities(ORDER)) == 1
    for later_s in (1.0, 60.0, 86_400.0):
        farm.clock.advance(later_s)
        await farm.agents.round()
        assert farm.held("weeder-01") == ""


async def test_a_robot_that_is_silent_does_not_hold_up_the_console_or_another_robot() -> None:
    farm = Farm("weeder-01", "weeder-02")
    await farm.agents.round()
    farm.world.robots["weeder-01"].set_fault(Silence(http=True, deaf=True))
    begin_s = farm.clock.mono_s()
    with pytest.raises(OrderFailed, match="did not come through the cloud"):
        await farm.console.upload_mission("weeder-01", document())
    assert farm.clock.mono_s() - begin_s <= ANSWER_S + 1
    answer = await farm.console.upload_mission("weeder-02", document("weeder-02"))
    assert answer.is_accepted
    farm.world.robots["weeder-01"].clear_fault()
    await farm.agents.round()
    assert farm.held("weeder-01") == "", "it was withdrawn, and it is too old"


async def test_an_order_that_is_found_twice_is_carried_out_once_and_answered_alike() -> None:
    farm = Farm("weeder-01")
    await farm.agents.round()
    presence = await farm.client().get(presence_ref("hof", "weeder-01"))
    plain = document()
    order = MissionOrder("weeder-01", "o1", plain["mission_id"], 1, mission_sha256(plain), str(presence.value("value")),
                         20.0, AT, msgspec.json.encode(plain))  # fmt: skip
    await farm.client().create(order.to_entity("hof"))
    await farm.agents.round()
    await farm.agents.round()
    assert len(farm.acks) == 1
    (answer,) = await farm.entities(ANSWER)
    assert read_answer(answer).is_accepted


async def test_the_robots_refusal_comes_back_in_its_words() -> None:
    farm = Farm("weeder-01")
    await farm.agents.round()
    far = document()
    far["segments"][0]["points"][1] = [90_000.0, 90_000.0]
    answer = await farm.console.upload_mission("weeder-01", far)
    assert (answer.is_accepted, answer.code) == (False, "bad_mission")
    assert "cannot be driven" in answer.text


@pytest.mark.parametrize(
    ("faults", "code", "is_known"),
    [
        (Faults(status=503), "cloud_away", True),
        (Faults(token="other"), "cloud_away", True),
        (Faults(status=413, methods=("POST",)), "too_large", True),
        (Faults(status=503, methods=("POST",)), "cloud_silent", False),
        (Faults(status=504, takes_effect=True, methods=("POST",)), "cloud_silent", False),
    ],
)
async def test_a_cloud_that_fails_is_said_so_and_nothing_is_sent_twice(
    faults: Faults, code: str, is_known: bool
) -> None:
    farm = Farm("weeder-01")
    await farm.agents.round()
    farm.switch.set(faults)
    with pytest.raises(OrderFailed) as failed:
        await farm.console.upload_mission("weeder-01", document())
    assert (failed.value.code, failed.value.is_outcome_known) == (code, is_known)
    farm.switch.set(Faults())
    assert await farm.entities(ORDER) == [], "what may have been put is withdrawn"


@pytest.mark.slow
async def test_a_cloud_that_is_known_to_be_away_is_asked_briefly_and_nothing_is_sent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(missions, "AWAY_S", 0.01)
    farm = Farm("weeder-01")
    await farm.agents.round()
    farm.is_away = True
    farm.switch.set(Faults(half_open=True))
    with pytest.raises(OrderFailed) as failed:
        await farm.console.upload_mission("weeder-01", document())
    assert (failed.value.code, failed.value.is_outcome_known) == ("cloud_away", True)
    assert "Send the mission directly" in failed.value.text
    assert isinstance(failed.value.__cause__, TimeoutError), "nobody waited until the broker was given up"
    assert await farm.entities(ORDER) == []


async def test_a_cloud_that_was_away_and_answers_again_takes_a_mission_at_once() -> None:
    farm = Farm("weeder-01")
    await farm.agents.round()
    farm.is_away = True  # as the console knows it from half a minute ago
    answer = await farm.console.upload_mission("weeder-01", document())
    assert answer.is_accepted


async def test_a_mission_that_is_too_large_goes_directly() -> None:
    farm = Farm("weeder-01")
    await farm.agents.round()
    large = document()
    points = [[n * 1.37 % 313, (n * n * 0.7193) % 977] for n in range(90_000)]
    large["segments"][0]["points"] = points
    with pytest.raises(OrderFailed) as failed:
        await farm.console.upload_mission("weeder-01", large)
    assert (failed.value.code, failed.value.is_outcome_known) == ("too_large", True)


@given(document=st.binary(max_size=5000))
def test_any_document_comes_back_as_it_went(document: bytes) -> None:
    assert unpacked(packed(document)) == document
    order = MissionOrder("weeder-01", "o", "m", 1, "a", "challenge", 20.0, AT, document, ((0.5, 1.0),))
    assert read_order(entity_from_wire(order.to_entity("hof").to_wire())) == order


def test_a_document_that_would_unpack_without_end_is_refused() -> None:
    with pytest.raises(Unreadable, match="too long"):
        unpacked(packed(b"0" * (9 * 1024 * 1024)))
    with pytest.raises(Unreadable):
        unpacked("not packed at all")
    with pytest.raises(BadInput):
        packed(os.urandom(10**6))


def test_presence_and_answer_come_back_as_they_went() -> None:
    order = MissionOrder("weeder-01", "o", "m", 1, "a", "challenge", 20.0, AT, b"{}", ((0.5, 1.0),))
    answer = MissionAnswer.to(order, is_accepted=False, code="mission_active", text="Another (one).", sha256="",
                              received_at=AT)  # fmt: skip
    back = read_answer(entity_from_wire(answer.to_entity("hof").to_wire()))
    assert (back.code, back.text, back.is_accepted) == ("mission_active", "Another (one).", False)
    assert Presence("weeder-01", "challenge", AT).to_entity("hof").value("value") == "challenge"


async def test_what_was_left_at_the_broker_is_deleted_and_what_somebody_waits_for_is_not() -> None:
    farm = Farm("weeder-01")
    await farm.agents.round()
    farm.are_agents_on = False

    async def dies(_seconds: float) -> None:
        farm.switch.set(Faults(status=503))
        raise RuntimeError("the console is killed")

    killed = CloudMissions(farm.client(), "hof", farm.clock, farm.delays, dies, is_ours=farm.asked)
    with pytest.raises(RuntimeError):
        await killed.upload_mission("weeder-01", document())
    farm.switch.set(Faults())
    other = Entity(ref=order_ref("other", "weeder-01", "theirs"), attributes={})
    await farm.client().create(other)
    await farm.agents.round()  # refused or not: the answer nobody reads
    assert (len(await farm.entities(ORDER)), len(await farm.entities(ANSWER))) == (2, 1)

    async def tidies(seconds: float) -> None:
        await farm.console.tidy()
        farm.are_agents_on = True
        await farm.passes(seconds)

    farm.console._sleep = tidies
    assert (await farm.console.upload_mission("weeder-01", document())).is_accepted
    assert [one.ref for one in await farm.entities(ORDER)] == [other.ref]
    assert await farm.entities(ANSWER) == []


async def test_an_answer_that_comes_too_late_is_deleted_later() -> None:
    farm = Farm("weeder-01")
    await farm.agents.round()
    await farm.console.tidy()
    farm.are_agents_on = False
    with pytest.raises(OrderFailed):
        await farm.console.upload_mission("weeder-01", document())
    await farm.client().create(Entity(ref=answer_ref("hof", "weeder-01", "late"), attributes={}))
    await farm.console.tidy()
    assert len(await farm.entities(ANSWER)) == 1
    farm.clock.advance(TIDY_S)
    await farm.console.tidy()
    assert await farm.entities(ANSWER) == []


async def test_an_agent_answers_an_order_once_and_looks_at_those_of_its_farm() -> None:
    farm = Farm("weeder-01")
    await farm.agents.round()
    farm.switch.set(Faults(status=503, methods=("DELETE",)))
    assert (await farm.console.upload_mission("weeder-01", document())).is_accepted
    assert len(await farm.entities(ORDER)) == 1  # it could not be taken back
    (answer,) = await farm.entities(ANSWER)
    farm.switch.set(Faults())
    await farm.client().delete(answer.ref)
    for _ in range(3):
        await farm.passes(1.0)
    assert await farm.entities(ANSWER) == []


async def test_a_page_of_a_proxy_while_the_robot_is_waited_for_is_asked_again() -> None:
    farm = Farm("weeder-01")
    await farm.agents.round()
    pages = [httpx.Response(404, text="default backend"), httpx.Response(408, text="")]
    inner = farm.transport

    class Way(httpx.AsyncBaseTransport):
        async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
            is_answer = request.method == "GET" and ANSWER in request.url.path
            return pages.pop() if is_answer and pages else await inner.handle_async_request(request)

    broker = Broker("http://broker.test", Tenant("farm"), retry=RetryPolicy(attempts=1))
    console = CloudMissions(
        NgsiClient(broker, transport=Way()), "hof", farm.clock, farm.delays, farm.passes, is_ours=farm.asked
    )
    assert (await console.upload_mission("weeder-01", document())).is_accepted
    assert pages == []
