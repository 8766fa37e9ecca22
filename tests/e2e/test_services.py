"""A demo whose cloud serves a planner and a forecast: planned there, here while it is away, and there again."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.e2e.caller import Caller
from tests.e2e.installation import Installation
from tests.e2e.person import wait_for

WISH = {"field_id": "polder-17", "robot_id": "weeder-01", "width_m": 6.0}


@pytest.fixture
def farm(tmp_path: Path) -> Iterator[Installation]:
    """Return a running demo with both services."""
    running = Installation.start(tmp_path / "data", has_cloud=True, has_planner=True)
    yield running
    running.end()


def states(caller: Caller) -> dict[str, str]:
    """Return how the services are."""
    return {one["key"]: one["state"] for one in caller.get("/cloud")["services"]}


def planned(caller: Caller) -> dict[str, Any]:
    """Plan and store a mission; return where it was planned."""
    mission = caller.post("/missions/plan", WISH).json()
    place: dict[str, Any] = mission["statistics"]["planned_at"]
    log = caller.get(f"/missions/{mission['id']}")["log"]
    assert [one["why"] for one in log] == [place["text"]]
    return place


@pytest.mark.long
@pytest.mark.timeout(200)
def test_missions_are_planned_at_the_service_and_here_while_it_is_away(farm: Installation) -> None:
    caller = Caller(farm.url, "admin")
    well = {"planner": "ok", "forecast": "ok"}
    wait_for(lambda: states(caller) == well, within_s=60, what="both services answer")
    assert planned(caller)["where"] == "service"
    os.kill(farm.pid("context_broker"), signal.SIGKILL)
    place = planned(caller)
    assert place["where"] == "here"
    assert place["text"].startswith("Planned on this server: the planner service")
    wait_for(lambda: states(caller)["planner"] == "ok", within_s=60, what="the planner service is back")
    assert planned(caller)["where"] == "service"
    caller.close()
