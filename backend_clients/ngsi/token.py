"""Tokens for brokers behind a proxy: a fixed header, or OAuth2 by client credentials or password.

Small and of our own, since the project has no OAuth2 library: two grants, no refresh token, nothing stored.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import Protocol

import httpx
from pydantic import BaseModel, ConfigDict, Field, SecretStr, ValidationError

from backend_clients.ngsi.errors import BadInput, NoToken

EARLY_S = 30.0  # a token is renewed so long before it ends, so that none ends on the way
TIMEOUT_S = 10.0
MAX_ANSWER = 65_536


class TokenSource(Protocol):
    """Where the credentials of a request come from."""

    async def headers(self) -> dict[str, str]:
        """Return the headers that let a request in; raises ``NoToken``."""
        ...

    def refused(self) -> bool:
        """Take note that the broker refused the token; say whether a new one may help."""
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

    def refused(self) -> bool:
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
        self._client = httpx.AsyncClient(
            transport=transport, timeout=TIMEOUT_S, trust_env=False, follow_redirects=False
        )
        self._token, self._until_s = "", 0.0
        self._one_at_a_time = asyncio.Lock()

    async def headers(self) -> dict[str, str]:
        """See ``TokenSource``."""
        async with self._one_at_a_time:
            if not self._token or self._mono_s() >= self._until_s:
                await self._fetch()
        is_bearer = self._settings.header.lower() == "authorization"
        return {self._settings.header: f"Bearer {self._token}" if is_bearer else self._token}

    def refused(self) -> bool:
        """See ``TokenSource``."""
        self._token = ""
        return True

    async def close(self) -> None:
        """See ``TokenSource``."""
        await self._client.aclose()

    async def _fetch(self) -> None:
        content = await self._answer()
        try:
            grant = _Grant.model_validate_json(content)
        except ValidationError:
            raise NoToken("the token service answered without a usable token") from None
        self._token = grant.access_token
        self._until_s = self._mono_s() + max(grant.expires_in - EARLY_S, grant.expires_in / 2)

    async def _answer(self) -> bytes:
        settings, content = self._settings, bytearray()
        secrets = (settings.client_id, settings.client_secret.get_secret_value())
        headers = {"Accept": "application/json", "Accept-Encoding": "identity"}
        try:
            async with (
                asyncio.timeout(TIMEOUT_S),
                self._client.stream("POST", settings.url, data=settings.form(), auth=secrets, headers=headers) as reply,
            ):
                if reply.status_code != 200:  # the body may repeat what was sent: it is not shown
                    raise NoToken(f"the token service answered {reply.status_code}")
                if reply.headers.get("content-encoding", "identity") != "identity":
                    raise NoToken("the token service answered compressed although nobody asked for it")
                async for piece in reply.aiter_bytes():
                    content += piece
                    if len(content) > MAX_ANSWER:
                        raise NoToken("the token service answered at too great length")
        except (httpx.HTTPError, httpx.InvalidURL, TimeoutError) as error:
            raise NoToken(f"the token service cannot be reached: {type(error).__name__}") from error
        return bytes(content)
