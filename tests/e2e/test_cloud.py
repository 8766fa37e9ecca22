"""A farm with a cloud: mirrored, missions by the other way, a broker that dies, a field changed by somebody else."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.e2e.caller import Caller
from tests.e2e.installation import Installation
from tests.e2e.person import wait_for

TENANT = {"Fiware-Service": "demo"}


@pytest.fixture
def farm(tmp_path: Path) -> Iterator[Installation]:
    """Return a running demo with its cloud."""
    running = Installation.start(tmp_path / "data", has_cloud=True)
    yield running
    running.end()


def in_cloud(farm: Installation, kind: str) -> list[dict[str, Any]]:
    """Return what the broker has of one type, as key-values."""
    url = f"{farm.keeper()['context_broker']['url']}/v2/entities?type={kind}&options=keyValues&limit=1000"
    found: list[dict[str, Any]] = httpx.get(url, headers=TENANT, trust_env=False).json()
    return found


def is_well(farm: Installation, caller: Caller) -> bool:
    """Say whether the link is up and everything is told."""
    told = caller.get("/cloud")
    parts = farm.health()["parts"]
    return bool(told["state"] == "ok" and told["counts"]["states"] and parts["context_broker"]["state"] == "ok")


@pytest.mark.long
@pytest.mark.timeout(200)
def test_a_day_with_a_cloud(farm: Installation) -> None:
    caller = Caller(farm.url, "admin")
    wait_for(lambda: is_well(farm, caller), within_s=60, what="the cloud is connected")
    assert {one["id"].rpartition(":")[2] for one in in_cloud(farm, "StateMessage")} >= {"weeder-01", "weeder-02"}
    wait_for(lambda: in_cloud(farm, "AgriParcel"), within_s=20, what="the map, which goes up after the robots")

    (mission,) = [one for one in caller.get("/missions")["missions"] if one["id"] == "trial-strip"]
    order = {"mission_id": mission["id"], "way": "cloud"}
    sent: dict[str, Any] = {}

    def is_answered() -> bool:
        """The robot's agent comes to the cloud later than the console; until then the order is refused and says so."""
        sent.update(caller.post(f"/robots/{mission['robot_id']}/mission", order).json())
        return sent["code"] != "no_agent"

    wait_for(is_answered, within_s=60, what="the robot's agent is at the cloud")
    assert (sent["outcome"], sent["way"]) == ("accepted", "cloud"), sent
    truth = farm.world(mission["robot_id"])
    assert (truth["standstill"], truth["mode"]) == (True, "idle")
    log = caller.get(f"/missions/{mission['id']}")["log"]
    assert any("through the cloud" in one["why"] for one in log)

    field = in_cloud(farm, "AgriParcel")[0]
    broker = farm.keeper()["context_broker"]["url"]
    change = {"name": {"type": "Text", "value": "Renamed there"}}
    httpx.post(
        f"{broker}/v2/entities/{field['id']}/attrs?type=AgriParcel", json=change, headers=TENANT, trust_env=False
    )
    wait_for(lambda: caller.get("/map/proposals")["proposals"], within_s=10, what="the broker told of the change")
    (wish,) = caller.get("/map/proposals")["proposals"]
    assert wish["after"]["properties"]["name"] == "Renamed there"

    def is_down() -> bool:
        """A broker killed once is back before anybody asks it: it is killed until somebody did."""
        pid = farm.keeper()["context_broker"]["pid"]
        with contextlib.suppress(ProcessLookupError):
            if pid:  # none while it is down
                os.kill(pid, signal.SIGKILL)
        return bool(caller.get("/cloud")["state"] != "ok")

    wait_for(is_down, within_s=30, what="the link is said to be down")
    late = caller.post(f"/robots/{mission['robot_id']}/mission", {"mission_id": mission["id"], "way": "cloud"}).json()
    assert late["outcome"] != "accepted"
    assert farm.world(mission["robot_id"])["standstill"]
    wait_for(lambda: is_well(farm, caller), within_s=60, what="the link is up again")
    wait_for(lambda: in_cloud(farm, "StateMessage"), within_s=10, what="the new broker was told everything")
    caller.close()
