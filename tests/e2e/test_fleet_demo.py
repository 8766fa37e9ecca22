"""The whole demo farm: every robot is heard, most are at work, and one press stops them all."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from hmi.demo.fleet import FULL
from tests.e2e.caller import Caller
from tests.e2e.installation import Installation
from tests.e2e.person import wait_for

pytestmark = [pytest.mark.broker, pytest.mark.long]
AT_WORK = 17


def test_twenty_four_robots_are_heard_work_can_be_troubled_and_stop(tmp_path: Path) -> None:
    running = Installation.start(tmp_path / "data", fleet="full")
    caller = Caller(running.url, "supervisor")

    def robots() -> dict[str, dict[str, object]]:
        return {one["id"]: one for one in caller.get("/robots")["robots"]}

    def statuses() -> Counter[str]:
        return Counter(one["status"] for one in caller.get("/missions")["missions"])

    try:
        wait_for(
            lambda: sum(bool(one["is_online"]) for one in robots().values()) == 24,
            within_s=40,
            what="24 robots are heard",
        )
        assert set(robots()) == {one.id for one in FULL}
        assert Counter(one["family"] for one in robots().values()) == {"weeder": 16, "planter": 4, "uav": 4}
        wait_for(lambda: statuses()["running"] >= AT_WORK - 5, within_s=90, what="most of the missions run")
        assert {robots()[one]["mode"] for one in ("weeder-01", "weeder-02")} == {"idle"}
        path = "/demo/robots/weeder-09/situation"
        assert caller.post(path, {"situation": "person-ahead"}).is_success
        wait_for(
            lambda: "stands in front" in str(robots()["weeder-09"]["why"]), within_s=15, what="somebody stands in front"
        )
        assert caller.get("/demo/situations")["now"]["weeder-09"] == "person-ahead"
        assert caller.post(path, {"situation": None}).is_success
        stop = {"stop_id": "fleet-demo-stop-1", "robots": "all"}
        assert caller.post("/stop", stop).is_success
        wait_for(
            lambda: all(running.world(one.id)["latched"] and running.world(one.id)["standstill"] for one in FULL),
            within_s=15,
            what="all 24 are latched and stand",
        )
    finally:
        caller.close()
        running.end()
