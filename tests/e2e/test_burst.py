"""Ten thousand messages at once: the newest is shown, STOP gets through, nothing piles up."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import psutil
import pytest

from bench.mqtt_load import robot_id
from tests.e2e.caller import Caller
from tests.e2e.installation import ROOT, Installation
from tests.e2e.person import wait_for

SPEAKING = 5
BURST, BURSTS, EVERY_S = 10_000, 4, 2.0
MOST_MB = 80  # a burst that was kept, message by message, takes 30 MB


@pytest.fixture
def crowded(tmp_path: Path) -> Iterator[tuple[Installation, Caller]]:
    """A demo in which five more robots are accepted, and an admin."""
    running = Installation.start(tmp_path / "data")
    admin = Caller(running.url, "admin")
    try:
        for number in range(SPEAKING):
            body = {"id": robot_id(number), "name": f"Load {number}", "family": "weeder"}
            admin.post("/robots", body).raise_for_status()
        yield running, admin
    finally:
        admin.close()
        running.end()


def test_the_newest_of_ten_thousand_is_shown_and_a_stop_pressed_meanwhile_is_confirmed(
    crowded: tuple[Installation, Caller],
) -> None:
    running, admin = crowded
    console = psutil.Process(running.pid("console"))
    before_mb = console.memory_info().rss / 1e6
    load = subprocess.Popen(_load(running), cwd=ROOT, stdout=subprocess.PIPE, text=True)
    try:
        wait_for(lambda: _lat_deg(admin, 0) > 0, within_s=20, what="the first burst is heard")
        admin.stop("weeder-01")
        wait_for(lambda: running.world("weeder-01")["latched"], within_s=10, what="the robot latches")
        wait_for(lambda: admin.get("/robots/weeder-01")["safety"]["latched"], within_s=10, what="the console is told")
        sent = json.loads(load.communicate(timeout=60)[0])
    finally:
        load.kill()
        load.wait()
    assert sent["sent"] == BURST * BURSTS
    for number in range(SPEAKING):
        newest_deg = 52 + 1e-7 * sent["newest"][f"{robot_id(number)}/telemetry"]
        wait_for(partial(_is_at, admin, number, newest_deg), within_s=10, what=f"the newest of robot {number}")
    assert console.memory_info().rss / 1e6 - before_mb < MOST_MB


def _load(running: Installation) -> list[str]:
    broker = urlsplit(running.keeper()["broker"]["url"])
    each = ["--robots", str(SPEAKING), "--burst", str(BURST), "--every", str(EVERY_S)]
    times = ["--seconds", str(EVERY_S * (BURSTS - 0.5))]
    return [sys.executable, "-m", "bench.mqtt_load", "--port", str(broker.port), *each, *times]


def _lat_deg(caller: Caller, number: int) -> float:
    pose: dict[str, Any] = caller.get(f"/robots/{robot_id(number)}").get("pose") or {}
    return float(pose.get("lat", 0))


def _is_at(caller: Caller, number: int, lat_deg: float) -> bool:
    return abs(_lat_deg(caller, number) - lat_deg) < 2e-8
