"""The client asks again when that is safe, says so when nobody knows, and keeps secrets."""

from __future__ import annotations

import asyncio
import logging
import ssl
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest
import structlog
from pydantic import SecretStr

from backend_clients.http.exchange import ExchangeFailed
from backend_clients.http.retry import RetryBudget, RetryPolicy
from backend_clients.http.trouble import OutsideError
from backend_clients.ngsi import entity as make
from backend_clients.ngsi import errors
from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.connection import Broker, Connection
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.identifier import EntityRef
from backend_clients.ngsi.query import Query
from backend_clients.ngsi.tenant import Tenant
from backend_clients.ngsi.token import FixedHeader, OAuth2Settings, OAuth2Tokens, TokenSource
from hmi.keeper.certificates import make_certificates

REF = EntityRef("r1", "Robot")
ROBOT = Entity(ref=REF, attributes={"speed": make.number(1)})
Step = int | Exception | httpx.Response


class Wire:
    """Answers from a list, and keeps what was asked and how long was waited."""

    def __init__(self, *steps: Step) -> None:
        self.steps = list(steps)
        self.requests: list[httpx.Request] = []
        self.pauses: list[float] = []

    def __call__(self, request: httpx.Request) -> httpx.Response:
        self.requests.append(request)
        step = self.steps.pop(0)
        if isinstance(step, Exception):
            raise step
        if isinstance(step, httpx.Response):
            return step
        return httpx.Response(step, json={"error": "E", "description": "d"} if step >= 400 else None)

    def client(self, tokens: TokenSource | None = None, **broker: Any) -> NgsiClient:
        async def sleep(seconds: float) -> None:
            self.pauses.append(seconds)

        where = Broker("http://broker", Tenant("g1", "/farm"), **broker)
        transport = httpx.MockTransport(self)
        clock: Callable[[], float] = lambda: sum(self.pauses)  # noqa: E731
        return NgsiClient(where, connection=Connection(where, tokens, transport=transport, sleep=sleep, mono_s=clock))


async def test_a_read_is_tried_again_with_longer_pauses_and_one_correlator() -> None:
    wire = Wire(503, httpx.ConnectError("refused"), httpx.ReadTimeout("slow"), httpx.Response(200, json={"orion": {}}))
    assert await wire.client().version() == "orion"
    assert len(wire.pauses) == 3
    assert len({request.headers["fiware-correlator"] for request in wire.requests}) == 1
    assert all("content-type" not in request.headers for request in wire.requests)


async def test_what_is_not_idempotent_is_sent_once() -> None:
    for send in (
        lambda client: client.create(ROBOT),
        lambda client: client.increment(REF, "speed", 1),
        lambda client: client.append_new(REF, {"speed": make.number(1)}),
    ):
        wire = Wire(httpx.ReadTimeout("slow"))
        with pytest.raises(errors.NoAnswer) as caught:
            await send(wire.client())
        assert caught.value.is_outcome_unknown
        assert len(wire.requests) == 1


async def test_a_failure_before_anything_was_sent_is_not_in_doubt() -> None:
    with pytest.raises(errors.Unreachable) as caught:
        await Wire(httpx.ConnectError("refused")).client().create(ROBOT)
    assert not caught.value.is_outcome_unknown


async def test_an_earlier_attempt_that_may_have_worked_keeps_the_outcome_in_doubt() -> None:
    wire = Wire(httpx.ReadTimeout("slow"), *[httpx.ConnectError("refused")] * 3)
    with pytest.raises(errors.Unreachable) as caught:
        await wire.client().upsert(ROBOT)
    assert caught.value.is_outcome_unknown
    assert caught.value.attempts == 4


async def test_a_delete_whose_answer_was_lost_is_done() -> None:
    wire = Wire(httpx.ReadTimeout("slow"), 404)
    await wire.client().delete(REF)
    with pytest.raises(errors.NotFound):
        await Wire(404).client().delete(REF)


async def test_a_refusal_is_not_repeated() -> None:
    for status, kind in ((400, errors.BrokerRefused), (404, errors.NotFound), (409, errors.Ambiguous),
                         (413, errors.TooLarge), (403, errors.NotAllowed)):  # fmt: skip
        wire = Wire(status)
        with pytest.raises(kind) as caught:
            await wire.client().upsert(ROBOT)
        assert type(caught.value) is kind
        assert len(wire.requests) == 1
        assert not caught.value.is_outcome_unknown
        assert caught.value.correlator in str(caught.value)


async def test_the_wish_of_the_broker_to_wait_is_kept_within_limits() -> None:
    asks = [httpx.Response(429, headers={"Retry-After": text}, json={"error": "E"}) for text in ("3", "900", "soon")]
    wire = Wire(*asks, httpx.Response(200, json={"orion": {}}))
    await wire.client().version()
    assert wire.pauses[0] == 3
    assert wire.pauses[1] == RetryPolicy().longest_s


async def test_no_attempt_begins_after_the_deadline() -> None:
    wire = Wire(*[httpx.Response(503, headers={"Retry-After": "5"}, json={}) for _ in range(4)])
    with pytest.raises(errors.BrokerFailed):
        await wire.client(retry=RetryPolicy(attempts=9, deadline_s=12)).version()
    assert len(wire.requests) == 3


async def test_a_broker_in_trouble_is_not_buried_in_retries() -> None:
    wire = Wire(*[503] * 200)
    client = wire.client()
    for _ in range(40):
        with pytest.raises(errors.BrokerFailed):
            await client.version()
    assert 40 < len(wire.requests) <= 40 + 10 + 40 * 0.2 + 1


def test_a_budget_comes_back_with_calls() -> None:
    budget = RetryBudget(reserve=1)
    assert budget.take()
    assert not budget.take()
    for _ in range(5):
        budget.called()
    assert budget.take()


async def test_an_answer_without_end_is_not_read_to_the_end() -> None:
    wire = Wire(httpx.Response(200, content=b"[" + b" " * 5000))
    with pytest.raises(errors.TooLong):
        await wire.client(max_response=4096).types()


@pytest.mark.parametrize(
    "answer",
    [httpx.Response(200, content=b"<html>"), httpx.Response(200, content=b"[NaN]"), httpx.Response(200, json={}),
     httpx.Response(200, json=[1]), httpx.Response(302, headers={"Location": "http://elsewhere"}),
     httpx.Response(200, headers={"Content-Encoding": "gzip"}, content=b"")],
)  # fmt: skip
async def test_an_answer_that_is_not_ngsi_is_unreadable(answer: httpx.Response) -> None:
    with pytest.raises(errors.Unreadable):
        await Wire(answer).client().types()


async def test_a_list_without_its_number_is_unreadable() -> None:
    with pytest.raises(errors.Unreadable):
        await Wire(httpx.Response(200, json=[])).client().count(Query())


async def test_a_refusal_in_html_is_still_a_refusal() -> None:
    with pytest.raises(errors.TooLarge) as caught:
        await Wire(httpx.Response(413, content=b"<html>nginx</html>")).client().upsert(ROBOT)
    assert caught.value.error == "HTTP413"


async def test_more_than_a_broker_takes_is_not_sent() -> None:
    wire = Wire()
    big = Entity(ref=REF, attributes={"note": make.text("x" * 1_100_000)})
    with pytest.raises(errors.BadInput):
        await wire.client().upsert(big)
    assert not wire.requests


@pytest.mark.parametrize(
    "url", ["ftp://a", "broker", "http://", "http://u:secret@a", "http://a?b=c", "http://a#b", "http://a:x"]
)
def test_an_address_that_is_none_or_has_credentials_is_refused(url: str) -> None:
    with pytest.raises(errors.BadInput) as caught:
        Broker(url)
    assert "secret" not in str(caught.value)


async def test_a_token_is_renewed_before_its_end_and_after_a_refusal() -> None:
    given: list[httpx.Request] = []
    now = [0.0]

    def service(request: httpx.Request) -> httpx.Response:
        given.append(request)
        return httpx.Response(200, json={"access_token": f"token-{len(given)}", "expires_in": 300})

    settings = OAuth2Settings(url="http://idm/token", client_id="c", client_secret=SecretStr("s"))
    tokens = OAuth2Tokens(settings, transport=httpx.MockTransport(service), mono_s=lambda: now[0])
    wire = Wire(*[httpx.Response(200, json={"orion": {}}) for _ in range(3)], 401, httpx.Response(200, json={"x": {}}))
    client = wire.client(tokens)
    await client.version()
    now[0] = 269
    await client.version()
    now[0] = 271
    await client.version()
    await client.version()
    seen = [request.headers["authorization"] for request in wire.requests]
    assert seen == [f"Bearer token-{n}" for n in (1, 1, 2, 2, 3)]
    assert given[0].content == b"grant_type=client_credentials"
    assert given[0].headers["authorization"].startswith("Basic ")


async def test_a_password_grant_names_the_user() -> None:
    settings = OAuth2Settings(
        url="http://idm/token", client_id="c", client_secret=SecretStr("s"), username="farm", password=SecretStr("p&w"),
        header="X-Auth-Token",
    )  # fmt: skip
    asked: list[bytes] = []

    def service(request: httpx.Request) -> httpx.Response:
        asked.append(request.content)
        return httpx.Response(200, json={"access_token": "t"})

    tokens = OAuth2Tokens(settings, transport=httpx.MockTransport(service))
    assert await tokens.headers() == {"X-Auth-Token": "t"}
    assert asked == [b"grant_type=password&username=farm&password=p%26w"]
    await tokens.close()


@pytest.mark.parametrize("answer", [httpx.Response(401), httpx.Response(200, content=b"x"), httpx.ReadTimeout("s"),
                                    httpx.Response(200, content=b" " * 70_000),
                                    httpx.Response(200, json={"access_token": "a\nb"})])  # fmt: skip
async def test_without_a_token_nothing_is_sent(answer: Any) -> None:
    def service(_request: httpx.Request) -> httpx.Response:
        if isinstance(answer, Exception):
            raise answer
        return answer

    settings = OAuth2Settings(url="http://idm/token", client_id="c", client_secret=SecretStr("top-secret"))
    wire = Wire()
    with pytest.raises(errors.NoToken) as caught:
        await wire.client(OAuth2Tokens(settings, transport=httpx.MockTransport(service))).version()
    assert not wire.requests
    assert "top-secret" not in str(caught.value) + repr(settings)


async def test_no_credentials_reach_the_log(caplog: pytest.LogCaptureFixture) -> None:
    wire = Wire(503, httpx.Response(200, json={"orion": {}}))
    tokens = FixedHeader(SecretStr("Bearer top-secret"))
    with structlog.testing.capture_logs() as said, caplog.at_level(logging.DEBUG):
        await wire.client(tokens).version()
    assert wire.requests[0].headers["authorization"] == "Bearer top-secret"
    assert [line["event"] for line in said] == ["ngsi.call", "ngsi.again", "ngsi.call"]
    assert all(line["correlator"] == wire.requests[0].headers["fiware-correlator"] for line in said)
    assert "top-secret" not in str(said) + caplog.text


def test_every_error_is_of_the_tree_and_says_how_to_mend_it() -> None:
    kinds = [kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, Exception)]
    ours = [kind for kind in kinds if kind not in (OutsideError, ExchangeFailed)]
    assert all(issubclass(kind, errors.NgsiError) and kind.mend.endswith(".") for kind in ours)
    assert all(kind.__name__ in (errors.__doc__ or "") for kind in ours)


async def test_a_certificate_that_nobody_vouches_for_is_told_apart_and_not_tried_again(tmp_path: Path) -> None:
    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readuntil(b"\r\n\r\n")
        writer.write(b'HTTP/1.1 200 OK\r\nContent-Length: 12\r\n\r\n{"orion":{}}')
        await writer.drain()
        writer.close()

    made = make_certificates(["localhost"], tmp_path, days=1)
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    context.load_cert_chain(made.cert, made.key)
    async with await asyncio.start_server(serve, "127.0.0.1", 0, ssl=context) as server:
        url = f"https://localhost:{server.sockets[0].getsockname()[1]}"
        async with NgsiClient(Broker(url)) as client:
            with pytest.raises(errors.Untrusted) as caught:
                await client.version()
        assert caught.value.attempts == 1
        async with NgsiClient(Broker(url, ca=str(made.ca))) as client:
            assert await client.version() == "orion"


def test_a_file_of_authorities_that_is_none_is_refused(tmp_path: Path) -> None:
    (tmp_path / "empty.pem").write_text("nothing")
    for file in (tmp_path / "empty.pem", tmp_path / "missing.pem"):
        with pytest.raises(errors.BadInput):
            NgsiClient(Broker("https://broker", ca=str(file)))


@pytest.mark.parametrize("status", [400, 404, 405, 409, 411, 415, 422])
async def test_what_no_broker_writes_is_about_the_way_and_not_about_the_entity(status: int) -> None:
    page = httpx.Response(status, text="default backend - 404")
    with pytest.raises(errors.Unreadable):
        await Wire(page).client().upsert(ROBOT)
    with pytest.raises(errors.Unreadable):
        await Wire(page).client().find(REF)


@pytest.mark.parametrize("status", [408, 425])
async def test_a_proxy_that_passes_nothing_on_for_a_while_is_asked_again(status: int) -> None:
    wire = Wire(status, 204)
    await wire.client().upsert(ROBOT)
    assert len(wire.requests) == 2


async def test_a_proxy_may_say_in_its_own_words_that_a_request_is_too_large() -> None:
    with pytest.raises(errors.TooLarge):
        await Wire(httpx.Response(413, html="<h1>413</h1>")).client().upsert(ROBOT)
