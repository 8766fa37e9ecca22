"""A farm for each test."""

from __future__ import annotations

import shutil
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from tests.hmi.missions.conftest import migrated as migrated
from tests.hmi.pictures.rig import PictureRig

MakeRig = Callable[..., Awaitable[PictureRig]]


@pytest.fixture
async def make_rig(tmp_path: Path, migrated: Path) -> AsyncIterator[MakeRig]:
    """Return what makes a farm with these settings; made again on the same folder it is the console restarted."""
    open_ones: list[PictureRig] = []

    async def make(**settings: Any) -> PictureRig:
        while open_ones:
            await open_ones.pop().close()
        if not (tmp_path / "headland.db").exists():
            shutil.copyfile(migrated, tmp_path / "headland.db")
        rig = PictureRig(tmp_path, **settings)
        await rig.open()
        open_ones.append(rig)
        return rig

    yield make
    for rig in open_ones:
        await rig.close()


@pytest.fixture
async def rig(make_rig: MakeRig) -> PictureRig:
    """Return a farm with the settings as shipped."""
    return await make_rig()
