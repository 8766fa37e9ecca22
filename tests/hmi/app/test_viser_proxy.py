"""The twin's sockets: who may open them, and that nothing but looking goes in."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator

import msgspec
import pytest
from starlette.applications import Starlette

from hmi.app import viser_proxy
from hmi.app.media_link import MediaDown
from hmi.app.viser_proxy import AWAY, REFUSED, SIGNED_OUT, TOO_MANY, TwinSockets
from hmi.domain.role import Role
from hmi.security.authorization import Authorizer
from hmi.security.session_info import SessionInfo
from tests.hmi.app.asgi_socket import AsgiSocket
from tests.hmi.app.people import session_of

KEY = "0123456789abcdef"
ORIGIN = {"origin": "http://console.local"}


class Inner:
    """The media process's end of a socket."""

    subprotocol = "viser-v1.1.1"

    def __init__(self) -> None:
        self.heard: list[str | bytes] = []

    async def send(self, said: str | bytes) -> None:
        """Take what the browser said."""
        self.heard.append(said)

    async def close(self) -> None:
        """End."""

    async def __aiter__(self) -> AsyncIterator[str | bytes]:
        yield b"picture"
        while len(self.heard) < 2:  # noqa: ASYNC110 - filled by the code under test
            await asyncio.sleep(0.005)


class Link:
    """A media process that is there or not."""

    def __init__(self, *, is_there: bool = True) -> None:
        self.inner, self._is_there, self.rights, self.viewers = Inner(), is_there, "", set[str]()

    async def viser(self, viewer: str, protocols: list[str]) -> Inner:
        """Open a picture."""
        return await self.control(viewer, "", "")

    async def control(self, viewer: str, robot_id: str, rights: str) -> Inner:
        """Open a page."""
        if not self._is_there:
            raise MediaDown("gone")
        self.rights = rights
        self.viewers.add(viewer)
        return self.inner


class Gate:
    """One session or none."""

    def __init__(self, session: SessionInfo | None) -> None:
        self.session = session

    def of_headers(self, headers: object) -> SessionInfo | None:
        """Return it."""
        return self.session

    def get(self, session_id: str) -> SessionInfo | None:
        """Return it."""
        return self.session


@contextlib.asynccontextmanager
async def nobody_is_told(_robot_id: str) -> AsyncIterator[None]:
    """Stand in for the news."""
    yield


class Robot:
    """A registered robot."""

    name, farm_id = "Weeder 07", "farm"


def open_socket(link: Link, path: str, role: Role | None = Role.VIEWER, headers: dict[str, str] = ORIGIN) -> AsgiSocket:
    """Return the socket of a person with this role."""
    gate = Gate(None if role is None else session_of(role))
    authorize = Authorizer(lambda robot_id: Robot() if robot_id == "weeder-07" else None)  # type: ignore[arg-type,return-value]
    sockets = TwinSockets(link, gate, authorize, lambda origin, host: origin == ORIGIN["origin"], nobody_is_told)  # type: ignore[arg-type]
    return AsgiSocket(Starlette(routes=sockets.routes()), path, headers, ["viser-v1.1.1"])


async def code_of(socket: AsgiSocket) -> int | None:
    """Return what a socket was closed with."""
    async with socket:
        if socket.code is None:
            await socket.next()
    return socket.code


PICTURE, CONTROL = f"/viser?viewer={KEY}", f"/viser/control?viewer={KEY}&robot=weeder-07"


async def test_a_picture_is_passed_on_and_only_looking_goes_in() -> None:
    link = Link()
    look = msgspec.msgpack.encode({"type": "ViewerCameraMessage"})
    async with open_socket(link, PICTURE) as socket:
        assert socket.subprotocol == "viser-v1.1.1"
        assert (await socket.next())["bytes"] == b"picture"
        for kind in ("ShareUrlRequest", "GuiUpdateMessage", "FileTransferStartUpload", "GetRenderResponseMessage"):
            socket.say(msgspec.msgpack.encode({"type": kind}))
        for said in (b"\xc1", b"x" * 70_000, "text", look, look):
            socket.say(said)
        await socket.next()
    assert link.inner.heard == [look, look]


@pytest.mark.parametrize("path", [PICTURE, CONTROL])
async def test_without_a_session_or_from_another_page_nothing_opens(path: str) -> None:
    assert await code_of(open_socket(Link(), path, None)) == SIGNED_OUT
    assert await code_of(open_socket(Link(), path, headers={"origin": "http://evil.example"})) == REFUSED
    assert await code_of(open_socket(Link(), path, headers={})) == REFUSED


@pytest.mark.parametrize("key", ["", "short", "x" * 20, "../../etc"])
async def test_a_key_that_is_none_opens_nothing(key: str) -> None:
    assert await code_of(open_socket(Link(), f"/viser?viewer={key}")) == TOO_MANY


async def test_too_many_pictures_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(viser_proxy, "MOST_PICTURES", 0)
    assert await code_of(open_socket(Link(), PICTURE)) == TOO_MANY


@pytest.mark.parametrize("path", [PICTURE, CONTROL])
async def test_a_media_process_that_is_away_is_said_so(path: str) -> None:
    assert await code_of(open_socket(Link(is_there=False), path)) == AWAY


@pytest.mark.parametrize("robot", ["", "../x", "A B"])
async def test_a_robot_that_has_no_legal_name_is_refused(robot: str) -> None:
    path = f"/viser/control?viewer={KEY}&robot={robot}"
    assert await code_of(open_socket(Link(), path)) == REFUSED


@pytest.mark.parametrize(("role", "rights"), [(Role.VIEWER, ""), (Role.OPERATOR, ""), (Role.SUPERVISOR, "replay")])
async def test_the_right_to_replay_comes_from_the_role_and_not_from_the_page(role: Role, rights: str) -> None:
    link = Link()
    async with open_socket(link, CONTROL, role):
        assert link.rights == rights


async def test_a_session_that_ends_ends_its_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(viser_proxy, "CHECK_S", 0.01)
    gate = Gate(session_of(Role.VIEWER))
    authorize = Authorizer(lambda robot_id: None)
    sockets = TwinSockets(Link(), gate, authorize, lambda origin, host: True, nobody_is_told)  # type: ignore[arg-type]
    async with AsgiSocket(Starlette(routes=sockets.routes()), PICTURE, ORIGIN) as socket:
        gate.session = None
        while socket.code is None:
            await socket.next()
    assert socket.code == SIGNED_OUT


async def test_another_session_cannot_have_the_same_key() -> None:
    link = Link()
    for role in (Role.VIEWER, Role.OPERATOR):
        async with open_socket(link, PICTURE, role):
            pass
    assert len(link.viewers) == 2
