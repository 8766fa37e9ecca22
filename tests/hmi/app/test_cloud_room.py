"""The cloud of a console before, without and with settings it can work with."""

from __future__ import annotations

import asyncio
from datetime import timedelta
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hmi.app import cloud as cloud_module
from hmi.app.arrival_report import FromRobots
from hmi.app.cloud import CloudRoom
from hmi.app.service_report import broker_findings, clock_finding
from hmi.clock import FakeClock
from hmi.cloud.broker_link import broker_link
from hmi.cloud.outbox import Piece, Rank
from hmi.domain.command import OrderFailed
from hmi.service_link import NOT_OURS, LinkState
from hmi.settings import Settings
from tests.hmi.planning_service.rig import until


def room(folder: Path, **settings: Any) -> CloudRoom:
    """Return the cloud of a console that has nothing else."""
    records: Any = SimpleNamespace(missions=SimpleNamespace(on_changed=lambda _: None, on_deleted=lambda _: None))
    fleet: Any = SimpleNamespace()
    made = Settings(demo=True, data=folder, **settings)
    return CloudRoom(made, FakeClock(), records, fleet, FromRobots(), lambda _: None)


async def test_settings_nothing_can_be_sent_with_are_shown_as_such_and_everything_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cloud_module, "LATER_S", 0.0)
    monkeypatch.setattr(cloud_module, "SETTLE_S", 0.01)
    cloud = room(tmp_path, cloud_url="https://broker.example", cloud_ca=tmp_path / "none.pem")
    assert cloud.report()["state"] == "connecting"
    assert cloud.findings() == ()
    cloud.start()
    await until(lambda: cloud.report()["state"] != "connecting")
    told = cloud.report()
    assert (told["state"], told["head"], told["again_in_s"]) == ("misset", "Its settings cannot be used", 0.0)
    assert "none.pem" in told["why"]
    assert [one.code for one in cloud.findings()] == ["cloud-refused"]
    assert cloud.health()["cloud"]["state"] == "degraded"
    cloud._backlog.put(Piece("weeder-01", Rank.EVENT, 0.0, "{}"))
    await until(lambda: cloud._backlog.waiting.count == 1)
    await cloud.stop()


async def test_an_address_that_no_broker_posts_from_is_shown_and_everything_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cloud_module, "LATER_S", 0.0)
    monkeypatch.setattr(cloud_module, "SETTLE_S", 0.01)
    cloud = room(tmp_path, cloud_url="https://broker.example", cloud_notify_url="https://farm.example")
    cloud._settings.cloud_notify_from[:] = ["the broker"]  # as settings do not let it be
    cloud.start()
    await until(lambda: cloud.report()["state"] != "connecting")
    assert (cloud.report()["state"], [one.code for one in cloud.findings()]) == ("misset", ["cloud-refused"])
    cloud._backlog.put(Piece("weeder-01", Rank.EVENT, 0.0, "{}"))
    await until(lambda: cloud._backlog.waiting.count == 1)
    await cloud.stop()


async def test_a_folder_that_takes_no_secret_is_tried_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cloud_module, "LATER_S", 0.0)
    monkeypatch.setattr(cloud_module, "SETTLE_S", 0.01)
    cloud = room(tmp_path, cloud_url="http://127.0.0.1:9", cloud_notify_url="https://farm.example")
    (tmp_path / "cloud").write_text("in the way")
    cloud.start()
    await until(lambda: cloud.report()["state"] == "misset")
    assert "folder of the cloud" in cloud.report()["why"]
    (tmp_path / "cloud").unlink()
    await until(lambda: cloud._work is not None)
    await until(lambda: cloud.report()["state"] == "unreachable")
    assert cloud._work is not None
    assert cloud._work.missions._is_away(), "nobody who sends a mission waits long for it"
    await cloud.stop()


def test_addresses_the_broker_posts_from_are_checked_with_the_settings(tmp_path: Path) -> None:
    made = Settings(demo=True, data=tmp_path, cloud_notify_from=["192.168.1.5/24", "10.0.0.7"])
    assert made.cloud_notify_from == ["192.168.1.0/24", "10.0.0.7/32"]
    with pytest.raises(ValueError, match="cloud_notify_from"):
        Settings(demo=True, data=tmp_path, cloud_notify_from=["the broker"])


async def test_a_farm_without_a_cloud_says_so_and_does_nothing(tmp_path: Path) -> None:
    cloud = room(tmp_path)
    cloud.start()
    cloud.watch_cameras(lambda: pytest.fail("nobody asks for cameras"))
    await asyncio.sleep(0)
    assert (cloud.report()["state"], cloud.findings()) == ("off", ())
    await cloud.stop()
    assert not (tmp_path / "cloud").exists()


@pytest.mark.parametrize("state", sorted(NOT_OURS))
async def test_no_mission_goes_through_a_tenant_that_is_not_ours(tmp_path: Path, state: LinkState) -> None:
    cloud = room(tmp_path, cloud_url="https://broker.example")
    cloud._link.leave(state, "The tenant does not know this console any more.", "Check tenant.")
    with pytest.raises(OrderFailed) as failed:
        await cloud.upload_mission("weeder-01", {})
    assert (failed.value.code, failed.value.is_outcome_known) == ("cloud_not_ours", True)


@pytest.mark.parametrize(
    ("ahead_s", "words"),
    [(900, "Its clock is 15 min ahead of this server's."), (-40, "Its clock is 40 s behind this server's."),
     (8, ""), (0, ""), (-90_000, "Its clock is 25 h behind this server's.")],
)  # fmt: skip
def test_a_broker_whose_clock_is_off_is_an_alarm_of_its_own_and_the_link_stays_well(ahead_s: float, words: str) -> None:
    clock = FakeClock()
    link = broker_link(clock)
    link.well(0.1, f"{clock.utc() + timedelta(seconds=ahead_s):%a, %d %b %Y %H:%M:%S GMT}")
    found = broker_findings(link, 0)
    assert [one.code for one in found] == (["service-clock"] if words else [])
    assert link.is_well
    if words:
        assert clock_finding("Context broker", link)[0].text == f"Context broker. {words}"
