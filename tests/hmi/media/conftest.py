"""The studio that tests of the media process share."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from hmi.clock import SystemClock
from hmi.media.intake import Intake
from hmi.media.studio import Studio
from hmi.twin.farm import Farm, FarmRobot
from tests.hmi.media.studio_stage import ROBOT, SECRET


@pytest.fixture
async def studio(tmp_path: Path) -> AsyncIterator[Studio]:
    """A studio whose planter has introduced itself."""
    made = Studio(Intake(SystemClock()), tmp_path, SECRET, SystemClock())
    made.start()
    made.set_farm(Farm([FarmRobot(ROBOT, "Planter 02", 6.2)]))
    yield made
    await made.stop()
