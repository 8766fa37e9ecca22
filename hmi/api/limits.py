"""Bodies have a limit, told or counted; a large one is refused before it is read."""

from __future__ import annotations

from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from hmi.api.errors import answer

MAX_BODY_BYTES = 64 * 1024  # the largest honest body of these routes is under 4 KB
MAX_UPLOAD_BYTES = 16 * 1024 * 1024  # missions and maps, on the routes that take them
MAX_FILE_BYTES = 50 * 1024 * 1024  # a map file to import
UPLOADS = ("/missions", "/features", "/map/")
FILES = "/map/imports"
MAX_BASE_MAP_BYTES = 64 * 1024**3  # the route has the installation's own limit; this body goes to disk, not to memory
BASE_MAPS = "/base-maps"
MAX_PICTURE_BYTES = 8 * 1024 * 1024  # of a field camera, passed on as it comes
MAX_MODEL_BYTES = 41 * 1024 * 1024  # a robot's own 3D model, passed on as it comes


class BodyLimit:
    """ASGI middleware around the REST interface."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on what is small enough."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        limit = limit_of(scope)
        announced = next((v for k, v in scope["headers"] if k == b"content-length"), b"0")
        if not announced.isdigit() or int(announced) > limit:
            await _refuse(limit)(scope, receive, send)
            return
        seen = 0

        async def counted() -> Message:
            nonlocal seen
            message = await receive()
            seen += len(message.get("body", b""))
            if seen > limit:
                raise HTTPException(413, _text(limit))
            return message

        await self._app(scope, counted, send)


def limit_of(scope: Scope) -> int:
    """Return how many bytes a request may carry."""
    path: str = scope["path"].removeprefix(scope.get("root_path", ""))
    if path == FILES:
        return MAX_FILE_BYTES
    if path == BASE_MAPS:
        return MAX_BASE_MAP_BYTES
    if path.startswith("/robots/") and path.endswith("/model"):
        return MAX_MODEL_BYTES
    if path.startswith("/cameras/") and path.endswith("/frame"):
        return MAX_PICTURE_BYTES
    return MAX_UPLOAD_BYTES if path.startswith(UPLOADS) else MAX_BODY_BYTES


def _refuse(limit: int) -> ASGIApp:
    return answer(413, "too_large", _text(limit))


def _text(limit: int) -> str:
    return f"This is larger than {limit // 1024} KB."
