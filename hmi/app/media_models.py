"""Robots' own models, kept by the media process, as the REST routes want them."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from typing import Any

import httpx

from hmi.api.twin import ModelRefused, ModelsAway
from hmi.app.media_link import MediaDown, MediaLink
from hmi.twin.limits import CHUNK_LIMIT_S, STALLED

READING_S = 90.0  # the media process gives up after 60


class MediaModels:
    """Implements ``hmi.api.twin.ModelKeeper``."""

    def __init__(self, link: MediaLink) -> None:
        self._link = link

    async def describe(self, robot_id: str) -> dict[str, Any]:
        """Return what is known of a robot's own model."""
        return await self._answer("GET", f"/models/{robot_id}")

    async def take(self, robot_id: str, chunks: AsyncIterator[bytes]) -> dict[str, Any]:
        """Pass a zip on and return what was read of it."""
        try:
            return _judged(await self._link.upload(f"/models/{robot_id}", _in_time(chunks), READING_S))
        except MediaDown as down:
            raise ModelsAway from down

    async def remove(self, robot_id: str) -> bool:
        """Drop a robot's own model."""
        return bool((await self._answer("DELETE", f"/models/{robot_id}"))["removed"])

    async def status(self) -> dict[str, Any] | None:
        """Return how the media process does."""
        try:
            return await self._answer("GET", "/status")
        except ModelsAway:
            return None

    async def _answer(self, method: str, path: str) -> dict[str, Any]:
        try:
            return _judged(await self._link.ask(method, path))
        except MediaDown as down:
            raise ModelsAway from down


async def _in_time(chunks: AsyncIterator[bytes]) -> AsyncIterator[bytes]:
    """Yield the pieces as they come; whoever sends none for long is told so, for the answer waits for the last one."""
    try:
        while True:
            async with asyncio.timeout(CHUNK_LIMIT_S):
                chunk = await anext(chunks, None)
            if chunk is None:
                return
            yield chunk
    except TimeoutError as error:
        raise ModelRefused("bad_model", STALLED) from error


def _judged(answer: httpx.Response) -> dict[str, Any]:
    if answer.is_error and answer.status_code != 422:
        raise ModelsAway
    found: dict[str, Any] = answer.json() if answer.content else {}
    if answer.status_code == 422:
        raise ModelRefused(str(found["code"]), str(found["text"]))
    return found
