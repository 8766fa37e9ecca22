"""Tokens for brokers behind a proxy: a fixed header, or OAuth2 by client credentials or password.

Small and of our own, since the project has no OAuth2 library: two grants, no refresh token, nothing stored.
"""

from __future__ import annotations

import asyncio
import base64
import json
import time
from collections.abc import Callable, Mapping
from typing import Protocol
from urllib.parse import urlencode

import httpx
from pydantic import BaseModel, ConfigDict, Field, SecretStr, ValidationError

from backend_clients.http.exchange import Answer, BadAddress, Exchange, ExchangeFailed, check_address, trust
from backend_clients.http.trouble import PASSING, Trouble
from backend_clients.ngsi.errors import BadInput, NoToken

EARLY_S = 30.0  # a token is renewed so long before it ends, so that none ends on the way
TIMEOUT_S = 10.0
MAX_ANSWER = 65_536
MENDS_ITSELF = "Check that the token service runs and its address; it is asked again by itself."
MENDS = {
    "invalid_client": "Check client id and client secret.",
    "invalid_grant": "Check user and password.",
    "unauthorized_client": "Allow this client the grant at the token service.",
    "unsupported_grant_type": "Set a user for the grant password, none for client_credentials.",
    "invalid_scope": "The token service does not know the scope.",
    "invalid_request": "Check that the address is that of the token endpoint.",
}
"""By the word of the refusal (RFC 6749, 5.2)."""


class TokenSource(Protocol):
    """Where the credentials of a request come from."""

    async def headers(self) -> dict[str, str]:
        """Return the headers that let a request in; raises ``NoToken``."""
        ...

    def refused(self, sent: Mapping[str, str]) -> bool:
        """Take note that the broker refused these headers; say whether others may help."""
        ...

    async def close(self) -> None:
        """Let go of connections."""
        ...


class FixedHeader:
    """A header that never changes.

    Args:
        value: e.g. ``Bearer ...``.
        name: e.g. ``Authorization`` or ``X-Auth-Token``.
    """

    def __init__(self, value: SecretStr, name: str = "Authorization") -> None:
        text = value.get_secret_value()
        if not text.isascii() or not text.isprintable() or not name.replace("-", "").isalnum():
            raise BadInput("a header of credentials has visible ASCII characters only")
        self._headers = {name: text}

    async def headers(self) -> dict[str, str]:
        """See ``TokenSource``."""
        return self._headers

    def refused(self, sent: Mapping[str, str]) -> bool:
        """See ``TokenSource``."""
        return False

    async def close(self) -> None:
        """See ``TokenSource``."""


class OAuth2Settings(BaseModel):
    """Where tokens come from; with a user name the grant is ``password``, else ``client_credentials``."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    url: str
    client_id: str
    client_secret: SecretStr
    username: str = ""
    password: SecretStr = SecretStr("")
    scope: str = ""
    header: str = "Authorization"
    ca: str = ""
    """File of authorities to trust beside those of this machine: a token service often is not the broker's."""

    def form(self) -> dict[str, str]:
        """Return the body of a token request."""
        form = {"grant_type": "password" if self.username else "client_credentials"}
        if self.username:
            form |= {"username": self.username, "password": self.password.get_secret_value()}
        return form | ({"scope": self.scope} if self.scope else {})


class _Grant(BaseModel):
    access_token: str = Field(min_length=1, max_length=16_384, pattern=r"^[\x21-\x7e]+$")
    expires_in: float = Field(3600.0, ge=0, le=10**9, allow_inf_nan=False)


class OAuth2Tokens:
    """Fetches a token when there is none that lasts, one request at a time.

    Args:
        settings: where from, and as whom.
        transport: test seam, as in httpx.
        mono_s: monotonic clock, seconds.
    """

    def __init__(
        self,
        settings: OAuth2Settings,
        *,
        transport: httpx.AsyncBaseTransport | None = None,
        mono_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._settings, self._mono_s = settings, mono_s
        try:
            check_address(settings.url, "the token service", "set client id and secret")
            verify = trust(settings.url, settings.ca, is_ca_alone=False)
        except BadAddress as error:
            raise BadInput(f"{error}") from error
        pair = f"{settings.client_id}:{settings.client_secret.get_secret_value()}"
        basic = {"Authorization": f"Basic {base64.b64encode(pair.encode()).decode()}"}
        self._exchange = Exchange(
            settings.url, basic, verify, timeout_s=TIMEOUT_S, max_response=MAX_ANSWER, connections=(1, 1),
            transport=transport,
        )  # fmt: skip
        self._token, self._until_s = "", 0.0
        self._one_at_a_time = asyncio.Lock()

    async def headers(self) -> dict[str, str]:
        """See ``TokenSource``."""
        async with self._one_at_a_time:
            if not self._token or self._mono_s() >= self._until_s:
                await self._fetch()
        return self._header()

    def refused(self, sent: Mapping[str, str]) -> bool:
        """See ``TokenSource``; a call that went out with an older token does not cost the newer one."""
        if sent == self._header():
            self._token = ""
        return True

    def _header(self) -> dict[str, str]:
        is_bearer = self._settings.header.lower() == "authorization"
        return {self._settings.header: f"Bearer {self._token}" if is_bearer else self._token}

    async def close(self) -> None:
        """See ``TokenSource``."""
        await self._exchange.close()

    async def _fetch(self) -> None:
        content = await self._answer()
        try:
            grant = _Grant.model_validate_json(content)
        except ValidationError:
            raise NoToken("the token service answered without a usable token") from None
        self._token = grant.access_token
        self._until_s = self._mono_s() + max(grant.expires_in - EARLY_S, grant.expires_in / 2)

    async def _answer(self) -> bytes:
        form = urlencode(self._settings.form()).encode()
        kind = {"Content-Type": "application/x-www-form-urlencoded"}
        try:
            answer = await self._exchange.send("POST", self._settings.url, {}, kind, form)
        except ExchangeFailed as failed:
            raise _no_token(f"the token service: {failed}", failed.trouble, failed.mend) from failed
        if answer.status != 200:  # the body may repeat what was sent: only words that are known are shown
            raise _refused(answer)
        return answer.content


def _no_token(text: str, trouble: Trouble, mend: str = "") -> NoToken:
    found = NoToken(text)
    found.trouble = trouble
    found.mend = mend or (MENDS_ITSELF if trouble in PASSING else found.mend)
    return found


def _refused(answer: Answer) -> NoToken:
    text = f"the token service answered {answer.status}"
    if answer.status >= 500:
        return _no_token(text, Trouble.FAILING, "Look at the log of the token service.")
    if answer.status == 429:
        return _no_token(text, Trouble.BUSY)
    try:
        word = str(json.loads(answer.content)["error"])
    except (ValueError, KeyError, TypeError, RecursionError):
        word = ""
    mend = MENDS.get(word, "")
    return _no_token(f"{text}: {word}" if mend else text, Trouble.REFUSED, mend)
