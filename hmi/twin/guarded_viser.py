"""A ``ViserServer`` that only the console may talk to.

viser itself answers everybody who reaches its port, serves files, takes frames of 50 MB and opens a public tunnel on
request. None of that is left here.
"""

from __future__ import annotations

import contextlib
import http
from collections.abc import Callable, Iterator
from typing import Any
from unittest import mock

import viser
import websockets.asyncio.server
from viser import _messages
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

MAX_FRAME_BYTES = 64 * 1024  # what a viewer sends: camera, clicks
Judge = Callable[[Headers], bool]


def guarded_viser(judge: Judge) -> viser.ViserServer:
    """Start a server on a free port of loopback; ``judge`` looks at the headers of every handshake."""
    with _guard(judge):
        server = viser.ViserServer(host="127.0.0.1", port=0, label="Headland", verbose=False)
    _without_tunnel(server)
    return server


def headers_of(server: viser.ViserServer, client_id: int) -> Headers | None:
    """Return the headers a viewer's handshake came with."""
    connection = server._websock_server._live_connections.get(client_id)
    request = None if connection is None else connection.request
    return None if request is None else request.headers


@contextlib.contextmanager
def _guard(judge: Judge) -> Iterator[None]:
    """viser has no hook for the handshake; its call to ``websockets`` is the place to add one."""
    real = websockets.asyncio.server.serve

    def serve(handler: Any, *args: Any, **kwargs: Any) -> Any:
        kwargs |= {"process_request": _door(judge), "max_size": MAX_FRAME_BYTES}
        return real(handler, *args, **kwargs)

    with mock.patch.object(websockets.asyncio.server, "serve", serve):
        yield


def _door(judge: Judge) -> Callable[[Any, Request], Response | None]:
    def look(_connection: Any, request: Request) -> Response | None:
        if not judge(request.headers):
            return Response(http.HTTPStatus.FORBIDDEN, "Forbidden", Headers(), b"")
        if request.headers.get("Upgrade", "").lower() != "websocket":
            return Response(http.HTTPStatus.NOT_FOUND, "Not found", Headers(), b"")
        return None

    return look


def _without_tunnel(server: viser.ViserServer) -> None:
    """Nobody may ask for the public tunnel, nor upload files."""
    for kind in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        server._websock_server.unregister_handler(kind)
    server.request_share_url = _refuse  # type: ignore[method-assign]


def _refuse(*_args: object, **_kwargs: object) -> None:
    return None
