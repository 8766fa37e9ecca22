"""A farm with stations for each test."""

from __future__ import annotations

import shutil
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from tests.hmi.missions.conftest import migrated as migrated
from tests.hmi.sensors.rig import SensorRig


@pytest.fixture
async def rig(tmp_path: Path, migrated: Path) -> AsyncIterator[SensorRig]:
    """Return a farm with a parcel, a weeder, and a broker that only a test speaks on."""
    shutil.copyfile(migrated, tmp_path / "headland.db")
    rig = SensorRig(tmp_path)
    await rig.begin()
    yield rig
    await rig.end()
