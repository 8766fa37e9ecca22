"""The cloud behind TLS and a token service, over real sockets: what is trusted, what is not, and what is said then."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from backend_clients.http.trouble import OutsideError
from backend_clients.ngsi import errors
from backend_clients.ngsi.identifier import EntityRef
from backend_clients.simulator.context_broker.application import make_application
from backend_clients.simulator.context_broker.broker import ContextBroker
from backend_clients.simulator.context_broker.faults import FaultSwitch
from hmi.app.cloud_work import make_client
from hmi.app.service_report import broker_findings
from hmi.clock import SystemClock
from hmi.cloud.link import CloudLink
from hmi.cloud.marker import Marker
from hmi.keeper.certificates import Certificates, make_certificates
from hmi.keeper.service_checkup import cloud_answers
from hmi.service_link import LinkState
from hmi.settings import Settings
from tests.hmi.cloud.token_service import CLIENT, PASSWORD, SECRET, USER, TokenService
from tests.served import served

REF = EntityRef("urn:ngsi-ld:Headland:hof:console", "Headland")


def broker() -> Any:
    """Return a context broker to be served."""
    return make_application(ContextBroker(None, None), FaultSwitch())


@asynccontextmanager
async def linked(folder: Path, url: str, **settings: Any) -> AsyncIterator[CloudLink]:
    """Give the console's link to a broker, after it looked once."""
    client = make_client(Settings(demo=True, data=folder, cloud_url=url, **settings))
    link = CloudLink(client, Marker(folder / "console.json", REF, "Hof"), SystemClock())
    await link.is_ready()
    yield link
    await client.close()


def said(link: CloudLink) -> tuple[str, str, list[str]]:
    """Return state, what is to be done, and the alarms."""
    found = broker_findings(link.link, 3)
    assert all(one.text for one in found)
    return link.link.state.value, link.link.mend, [one.code for one in found]


async def test_a_broker_with_an_authority_of_its_own_is_trusted_once_it_is_named(tmp_path: Path) -> None:
    made = make_certificates(["127.0.0.1"], tmp_path / "tls", days=2)
    async with served(broker(), cert=made.cert, key=made.key) as url:
        async with linked(tmp_path, url) as link:
            state, mend, alarms = said(link)
            assert (state, alarms) == ("untrusted", ["cloud-refused"])
            assert mend.startswith("Name the file of its authority in the settings.")
            assert "Nobody we trust vouches" in link.link.why
        async with linked(tmp_path, url, cloud_ca=made.ca) as link:
            assert said(link) == ("ok", "", [])


def _ran_out(folder: Path) -> Certificates:
    return make_certificates(["127.0.0.1"], folder, days=0)


def _other_name(folder: Path) -> Certificates:
    return make_certificates(["broker.example"], folder, days=2)


@pytest.mark.parametrize(
    ("make", "why", "mend"),
    [
        (_ran_out, "Its certificate ran out.", "Have it renewed. If it is valid, this machine's clock is wrong."),
        (_other_name, "Its certificate is for another name.", "Set the address that stands in the certificate"),
    ],
)
async def test_a_certificate_that_ran_out_or_is_for_another_name_says_which(
    tmp_path: Path, make: Callable[[Path], Certificates], why: str, mend: str
) -> None:
    made = make(tmp_path / "tls")
    async with served(broker(), cert=made.cert, key=made.key) as url, linked(tmp_path, url, cloud_ca=made.ca) as link:
        assert said(link)[0::2] == ("untrusted", ["cloud-refused"])
        assert link.link.why.endswith(why)
        assert link.link.mend.startswith(mend)


async def test_a_broker_without_tls_at_an_https_address_says_to_look_at_the_address(tmp_path: Path) -> None:
    async with served(broker()) as url, linked(tmp_path, url.replace("http:", "https:")) as link:
        assert said(link) == (
            "unreachable",
            "Check whether the address begins with http or with https.",
            ["cloud-away"],
        )


def oauth(url: str, **changes: Any) -> dict[str, Any]:
    """Return the settings for a token service."""
    return {"cloud_oauth_url": f"{url}/token", "cloud_oauth_client": CLIENT, "cloud_oauth_secret": SECRET, **changes}


@pytest.mark.slow
async def test_tokens_of_a_service_with_the_same_authority_let_the_console_in_behind_a_proxy(tmp_path: Path) -> None:
    made, tokens = make_certificates(["127.0.0.1"], tmp_path / "tls", days=2), TokenService()
    tls = {"cert": made.cert, "key": made.key}
    async with served(tokens.application, **tls) as idm, served(tokens.behind(broker()), **tls) as url:
        async with linked(tmp_path, url, cloud_ca=made.ca) as link:  # nobody told it of the token service
            assert said(link)[0::2] == ("refused", ["cloud-refused"])
        for who in ({}, {"cloud_oauth_user": USER, "cloud_oauth_password": PASSWORD}):
            async with linked(tmp_path, url, cloud_ca=made.ca, **oauth(idm, **who)) as link:
                assert said(link) == ("ok", "", [])
                before = tokens.asked
                tokens.valid.clear()  # taken back before its time: one refusal, a new token, nothing lost
                await link.client.find(REF)
                assert tokens.asked == before + 1


@pytest.mark.parametrize(
    ("changes", "why", "mend"),
    [
        ({"cloud_oauth_secret": "wrong"}, "401: invalid_client", "Check client id and client secret."),
        ({"cloud_oauth_user": USER, "cloud_oauth_password": "no"}, "400: invalid_grant", "Check user and password."),
    ],
)
async def test_wrong_credentials_say_which_and_never_show_them(
    tmp_path: Path, changes: dict[str, Any], why: str, mend: str
) -> None:
    tokens = TokenService()
    async with (
        served(tokens.application) as idm,
        served(tokens.behind(broker())) as url,
        linked(tmp_path, url, **oauth(idm, **changes)) as link,
    ):
        assert said(link) == ("refused", mend, ["cloud-refused"])
        assert link.link.why.endswith(why)
        assert not {"wrong", SECRET, PASSWORD} & set(link.link.why.replace(":", " ").split())


async def test_a_token_service_that_is_away_or_fails_is_waited_for_as_a_broker_is(tmp_path: Path) -> None:
    tokens = TokenService()
    async with served(tokens.behind(broker())) as url:
        async with served(tokens.application) as idm:
            tokens.status = 503
            async with linked(tmp_path, url, **oauth(idm)) as link:
                assert said(link)[0::2] == ("failing", ["cloud-away"])
                assert "token service answered 503" in link.link.why
        async with linked(tmp_path, url, **oauth(idm)) as link:  # its port is closed now
            state, mend, alarms = said(link)
            assert (state, alarms) == ("unreachable", ["cloud-away"])
            assert mend == "Check that the token service runs and its address; it is asked again by itself."


async def test_a_token_service_nobody_vouches_for_gets_no_secret(tmp_path: Path) -> None:
    made, tokens = make_certificates(["127.0.0.1"], tmp_path / "tls", days=2), TokenService()
    async with (
        served(tokens.application, cert=made.cert, key=made.key) as idm,
        served(broker()) as url,
        linked(tmp_path, url, **oauth(idm)) as link,
    ):
        assert said(link)[0::2] == ("untrusted", ["cloud-refused"])
        assert "token service" in link.link.why
    assert tokens.asked == 0


@pytest.mark.slow
async def test_the_check_of_an_installation_asks_the_broker_and_says_what_to_mend(tmp_path: Path) -> None:
    made, tokens = make_certificates(["127.0.0.1"], tmp_path / "tls", days=2), TokenService()
    tls = {"cert": made.cert, "key": made.key}
    async with served(tokens.application, **tls) as idm, served(tokens.behind(broker()), **tls) as url:
        good = {"cloud_ca": made.ca, **oauth(idm)}
        for changes, is_ok, text in (
            ({}, True, "answers: orion"),
            ({"cloud_ca": None}, False, "Name the file of its authority"),
            ({"cloud_ca": tmp_path / "none.pem"}, False, "no file of authorities"),
            ({"cloud_oauth_secret": "wrong"}, False, "Check client id and client secret."),
        ):
            asked = Settings(demo=True, data=tmp_path, cloud_url=url, **{**good, **changes})
            found = await asyncio.to_thread(cloud_answers, asked)
            assert found[0] is is_ok, found
            assert text in found[1]


@pytest.mark.slow
async def test_many_calls_at_once_ask_for_one_token(tmp_path: Path) -> None:
    tokens = TokenService()
    async with (
        served(tokens.application) as idm,
        served(tokens.behind(broker())) as url,
        linked(tmp_path, url, **oauth(idm)) as link,
    ):
        await asyncio.gather(*(link.client.find(REF) for _ in range(20)))
        assert tokens.asked == 1
        tokens.valid.clear()
        await asyncio.gather(*(link.client.find(REF) for _ in range(8)))
        assert tokens.asked == 2, "a token that was taken back is not asked for by every call"


@pytest.mark.parametrize("settings", [{"cloud_ca": Path("/nowhere/ca.pem")}, {"cloud_token": "two\nlines"}])
def test_settings_that_nothing_can_be_sent_with_are_refused_in_words(tmp_path: Path, settings: dict[str, Any]) -> None:
    with pytest.raises(errors.BadInput) as caught:
        make_client(Settings(demo=True, data=tmp_path, cloud_url="https://broker.example", **settings))
    assert isinstance(caught.value, OutsideError)
    assert "lines" not in str(caught.value)
    assert LinkState(caught.value.trouble) is LinkState.MISSET  # type: ignore[arg-type]
