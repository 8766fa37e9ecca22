"""The drawing process: started by the first picture, ended when nobody asks, started anew when it died."""

from __future__ import annotations

import asyncio
import os
import signal
from collections.abc import Callable

import pytest

from backend_clients.simulator.cameras import time_code
from backend_clients.simulator.cameras.scene import Look, Scene
from backend_clients.simulator.cameras.studio import NoPicture, Studio
from tests.backend_clients.simulator.cameras.field import FIELD, NOON, look, opened

pytestmark = pytest.mark.slow


def take(wanted: Look) -> Callable[[], tuple[Look, Callable[[], Scene]]]:
    return lambda: (wanted, lambda: FIELD)


async def until(condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(20):
        while not condition():  # noqa: ASYNC110 - a process ends when it ends
            await asyncio.sleep(0.02)


async def test_it_lives_from_the_first_picture_until_nobody_asked_for_a_while_and_survives_its_death() -> None:
    studio = Studio(idle_s=0.3)
    assert not studio.is_running
    try:
        picture = await studio.picture(take(look(width=320)))
        assert time_code.read(opened(picture.jpeg)) == NOON & 0xFFFFFF
        await until(lambda: not studio.is_running)
        again = asyncio.gather(*(studio.picture(take(look(width=160))) for _ in range(3)))
        assert len({one.number for one in await again}) == 3
        assert studio.starts == 2
        assert studio.pid is not None
        os.kill(studio.pid, signal.SIGKILL)
        await until(lambda: not studio.is_running)
        assert (await studio.picture(take(look(width=160)))).jpeg
        with pytest.raises(NoPicture):
            await studio.picture(take(look("roof")))
        assert studio.is_running
    finally:
        await studio.close()
    assert not studio.is_running
