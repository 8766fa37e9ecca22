"""Each fault of the broker as the client meets it over a real connection."""

from __future__ import annotations

import asyncio
import socket
import sys
from collections.abc import AsyncIterator
from datetime import UTC, datetime, timedelta
from typing import Any

import httpx
import pytest
from pydantic import SecretStr

from backend_clients.http.retry import RetryPolicy
from backend_clients.ngsi import entity as make
from backend_clients.ngsi import errors
from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.connection import Broker, Call
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.identifier import EntityRef
from backend_clients.ngsi.query import Query
from backend_clients.ngsi.subscription import Wanted
from backend_clients.ngsi.subscriptions import Subscriptions
from backend_clients.ngsi.tenant import Tenant
from backend_clients.ngsi.token import FixedHeader
from backend_clients.simulator.context_broker import __main__ as program
from backend_clients.simulator.context_broker.faults import Faults
from backend_clients.simulator.context_broker.server import Served, serve

REF = EntityRef("r1", "Robot")
ROBOT = Entity(ref=REF, attributes={"speed": make.number(1)})
QUICK = RetryPolicy(attempts=3, first_s=0.001)


@pytest.fixture
async def served() -> AsyncIterator[Served]:
    async with serve() as served:
        yield served


def client(served: Served, token: str = "", **broker: Any) -> NgsiClient:
    tokens = FixedHeader(SecretStr(f"Bearer {token}")) if token else None
    return NgsiClient(Broker(served.url, Tenant("g1"), retry=QUICK, **broker), tokens)


async def test_a_broker_that_fails_for_a_moment_is_asked_again(served: Served) -> None:
    served.switch.set(Faults(status=503, times=2))
    async with client(served) as robot:
        assert await robot.version() == "orion 4.3.0"
        served.switch.set(Faults(status=500))
        with pytest.raises(errors.BrokerFailed) as caught:
            await robot.version()
    assert caught.value.attempts == 3


async def test_an_answer_lost_on_the_way_is_known_to_be_unknown(served: Served) -> None:
    async with client(served) as robot:
        served.switch.set(Faults(status=504, times=1, takes_effect=True))
        with pytest.raises(errors.BrokerFailed) as caught:
            await robot.create(ROBOT)
        assert caught.value.is_outcome_unknown
        assert (await robot.get(REF)).value("speed") == 1
        served.switch.set(Faults(status=504, times=1, takes_effect=True))
        await robot.delete(REF)
        assert await robot.find(REF) is None


async def test_a_slow_or_half_open_broker_does_not_hold_a_call(served: Served) -> None:
    for faults in (Faults(delay_s=30), Faults(half_open=True)):
        served.switch.set(faults)
        async with client(served, timeout_s=0.05) as robot:
            with pytest.raises(errors.NoAnswer):
                await robot.version()


async def test_an_answer_that_breaks_off_is_no_answer(served: Served) -> None:
    served.switch.set(Faults(cut=5))
    async with client(served) as robot:
        with pytest.raises(errors.Unreachable):
            await robot.version()


async def test_another_tenants_entities_are_not_taken_for_ours_unnoticed(served: Served) -> None:
    async with client(served) as robot:
        await robot.create(ROBOT)
        served.switch.set(Faults(wrong_tenant="other"))
        assert await robot.find(REF) is None
        assert await robot.count(Query()) == 0


async def test_a_smaller_limit_of_a_proxy_is_told_and_a_batch_says_for_which(served: Served) -> None:
    served.switch.set(Faults(max_body=600))
    big = Entity(ref=EntityRef("big", "Robot"), attributes={"note": make.text("x" * 700)})
    async with client(served) as robot:
        with pytest.raises(errors.TooLarge):
            await robot.upsert(big)
        small = [Entity(ref=EntityRef(f"r{n}", "Robot"), attributes={"n": make.number(n)}) for n in range(9)]
        outcome = await robot.batch("append", [*small, big])
    assert set(outcome.failed) == {big.ref}
    assert len(outcome.done) == 9


async def test_a_batch_that_loses_the_broker_says_what_was_not_sent_and_what_nobody_knows(served: Served) -> None:
    many = [Entity(ref=EntityRef(f"r{n:03d}", "Robot"), attributes={"n": make.number(n)}) for n in range(250)]
    served.switch.set(Faults(half_open=True))
    async with client(served, timeout_s=0.05) as robot:
        outcome = await robot.batch("append", many)
    assert not outcome.done
    assert len(outcome.failed) == 250
    assert len(outcome.unknown()) == 200


async def test_a_proxy_lets_in_only_who_has_the_token(served: Served) -> None:
    served.switch.set(Faults(token="t-1"))
    async with client(served, token="t-1") as robot:
        assert await robot.version()
    async with client(served, token="old") as robot:
        with pytest.raises(errors.NotAllowed):
            await robot.version()


async def test_no_broker_at_all_is_unreachable() -> None:
    async with serve() as served:
        pass
    async with client(served) as robot:
        with pytest.raises(errors.Unreachable) as caught:
            await robot.create(ROBOT)
    assert not caught.value.is_outcome_unknown


async def test_faults_are_switched_over_http(served: Served) -> None:
    async with httpx.AsyncClient(base_url=served.url, verify=False) as tester:
        assert (await tester.put("/simulator/faults", json={"status": 503})).status_code == 204
        assert (await tester.get("/version")).status_code == 503
        assert (await tester.put("/simulator/faults", json={"colour": 1})).status_code == 400
        assert (await tester.delete("/simulator/faults")).status_code == 204
        assert (await tester.get("/version")).status_code == 200


async def test_many_writes_at_once_are_all_taken(served: Served) -> None:
    async with client(served) as robot:
        await robot.create(ROBOT)
        await asyncio.gather(*(robot.increment(REF, "speed", 1) for _ in range(20)))
        assert (await robot.get(REF)).value("speed") == 21


async def test_a_body_over_a_megabyte_is_refused_and_nothing_of_it_is_kept(served: Served) -> None:
    body = b'{"id":"big","n":{"value":"' + b"x" * 1_048_576 + b'"}}'
    async with httpx.AsyncClient(base_url=served.url, verify=False) as tester:
        answer = await tester.post("/v2/entities", content=body, headers={"Content-Type": "application/json"})
        assert (answer.status_code, answer.json()["error"]) == (413, "RequestEntityTooLarge")
        assert str(len(body)) in answer.json()["description"]
        assert (await tester.get("/v2/entities")).json() == []


def test_a_taken_port_is_said_and_ends_the_program(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        monkeypatch.setattr(sys, "argv", ["context_broker", "--port", port])
        assert program.main() == 2
    assert port in capsys.readouterr().err


async def test_a_subscription_whose_answer_was_lost_is_found_and_not_made_twice(served: Served) -> None:
    wanted = Wanted("robots", "http://127.0.0.1:9/notify", ("Robot",))
    async with client(served) as robot:
        ours = Subscriptions(robot.connection, "console-1")
        assert [item async for item in ours.mine()] == []
        served.switch.set(Faults(status=504, methods=("POST",), takes_effect=True))
        made = await ours.ensure(wanted, datetime.now(UTC))
        assert [item.id async for item in ours.mine()] == [made.id]


async def test_doubles_of_a_subscription_are_deleted_and_the_oldest_is_kept(served: Served) -> None:
    wanted, now = Wanted("robots", "http://127.0.0.1:9/notify", ("Robot",)), datetime.now(UTC)
    async with client(served) as robot:
        ours = Subscriptions(robot.connection, "console-1")
        first = await ours.ensure(wanted, now)
        for _ in range(2):
            double = Call("POST", "v2/subscriptions", body=wanted.body("console-1", now + timedelta(hours=24)))
            await robot.connection.send(double)
        assert (await ours.ensure(wanted, now)).how == "adopted"
        assert [item.id async for item in ours.mine()] == [first.id]


async def test_a_subscription_that_was_switched_off_or_ran_out_is_mended(served: Served) -> None:
    wanted, now = Wanted("robots", "http://127.0.0.1:9/notify", ("Robot",)), datetime.now(UTC)
    async with client(served) as robot:
        ours = Subscriptions(robot.connection, "console-1")
        made = await ours.ensure(wanted, now)
        for change in ({"status": "inactive"}, {"expires": "2020-01-01T00:00:00Z"}):
            await robot.connection.send(Call("PATCH", f"v2/subscriptions/{made.id}", body=change))
            assert not (await ours.get(made.id)).delivers()
            assert (await ours.ensure(wanted, now)).how == "mended"
            assert (await ours.get(made.id)).delivers()


async def test_a_deaf_receiver_is_told_by_the_subscription(served: Served) -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        nobody = f"http://127.0.0.1:{listener.getsockname()[1]}/notify"
    async with client(served) as robot:
        ours = Subscriptions(robot.connection, "console-1")
        made = await ours.ensure(Wanted("robots", nobody, ("Robot",)), datetime.now(UTC))
        await robot.create(ROBOT)
        await served.broker.notifier.settle()
        told = await ours.get(made.id)
        assert (told.fails, told.times_sent) == (1, 1)
        assert "ConnectError" in told.last_failure_reason
        assert not told.delivers()
