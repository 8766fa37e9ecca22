"""Waits for what becomes true in another process."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

LIMIT_S = 20.0


async def until(is_true: Callable[[], object], limit_s: float = LIMIT_S) -> None:
    """Return as soon as ``is_true()``; fails after ``limit_s``."""
    async with asyncio.timeout(limit_s):
        while not is_true():  # noqa: ASYNC110 - it happens in another process
            await asyncio.sleep(0.02)
