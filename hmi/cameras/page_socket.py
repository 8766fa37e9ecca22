"""Serves the socket of one page until it leaves or falls silent; then everything it watched is let go."""

from __future__ import annotations

import asyncio
import contextlib

from starlette.websockets import WebSocket, WebSocketDisconnect

from hmi.cameras.door import VIEWER_HEADER
from hmi.cameras.hub import Hub
from hmi.cameras.pages import Page
from hmi.cameras.whep import WhepDesk
from hmi.clock import Clock

BAD_FRAME, SILENT, TOO_MANY = 4400, 4408, 4429
CHECK_S = 0.25
MAX_FRAME_BYTES = 4096


class PageSockets:
    """All pages that watch, by their token."""

    def __init__(self, hub: Hub, whep: WhepDesk, clock: Clock, most: int) -> None:
        self._hub, self._whep, self._clock, self._most = hub, whep, clock, most
        self.pages: dict[str, Page] = {}

    def of(self, token: str, viewer: str) -> Page | None:
        """Return a page that still lives, if the token is that viewer's."""
        page = self.pages.get(token)
        return page if page is not None and page.viewer == viewer else None

    async def serve(self, socket: WebSocket) -> None:
        """Serve one socket."""
        await socket.accept()
        if len(self.pages) >= self._most:
            await socket.close(TOO_MANY)
            return
        page = Page(self._hub, self._clock, socket.headers.get(VIEWER_HEADER, ""))
        self.pages[page.token] = page
        tasks = [
            asyncio.create_task(_tell(socket, page), name="page-tell"),
            asyncio.create_task(_hear(socket, page), name="page-hear"),
            asyncio.create_task(_until_silent(page, self._clock), name="page-silence"),
        ]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            code = SILENT if tasks[2].done() else BAD_FRAME
        finally:
            del self.pages[page.token]
            page.end()
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await self._whep.end_of(page)
        with contextlib.suppress(RuntimeError, WebSocketDisconnect):  # it left first
            await socket.close(code)


async def _tell(socket: WebSocket, page: Page) -> None:
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):
        while True:
            said = page.next()
            if said is None:
                await page.wait()
            elif isinstance(said, str):
                await socket.send_text(said)
            else:
                await socket.send_bytes(said)


async def _hear(socket: WebSocket, page: Page) -> None:
    with contextlib.suppress(WebSocketDisconnect, RuntimeError, KeyError):
        while True:
            text = await socket.receive_text()
            if len(text) > MAX_FRAME_BYTES or not page.hear(text):
                return


async def _until_silent(page: Page, clock: Clock) -> None:
    """Return once the page is gone; time in which this process itself stood still does not count against it."""
    while not page.is_silent:
        before_s = clock.mono_s()
        await asyncio.sleep(CHECK_S)
        stalled_s = clock.mono_s() - before_s - CHECK_S
        if stalled_s > CHECK_S:
            page.forgive(stalled_s)
