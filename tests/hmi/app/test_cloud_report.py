"""What the panel, the alarms and health say of the cloud."""

from __future__ import annotations

import json
from pathlib import Path

import httpx
import pytest

from backend_clients.simulator.context_broker.faults import Faults
from hmi.app.arrival_report import FromRobots
from hmi.app.cloud_report import LOST_SHOWN_S, CloudReport
from hmi.cloud.delays import Delays
from hmi.cloud.kept_file import OutboxUnusable
from hmi.cloud.outbox import Piece, Rank
from hmi.cloud.proposals import ProposalBook
from hmi.settings import Settings
from tests.hmi.cloud.rig import Rig


def report_of(rig: Rig) -> CloudReport:
    """Return what a console with this rig says."""
    settings = Settings(demo=True, data=rig.folder, cloud_url="http://broker.test", cloud_tenant="farm")  # type: ignore[call-arg]
    book = ProposalBook(rig.urns)
    return CloudReport(
        settings, rig.clock, rig.mirror, rig.backlog, book, Delays(), FromRobots(lambda: {"repeated": 3})
    )


def codes(report: CloudReport) -> list[str]:
    """Return the alarms that hold."""
    return [one.code for one in report.findings()]


async def test_a_cloud_that_is_well_raises_nothing_and_shows_what_it_did(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    report = report_of(rig)
    await rig.run(1)
    shown = report.whole()
    assert (shown["state"], shown["waiting"]["count"], shown["counts"]["heard_twice"]) == ("ok", 0, 3)
    assert (codes(report), report.health()["cloud"]["state"]) == ([], "ok")
    await rig.close()


async def test_a_cloud_that_is_away_is_no_degraded_console_and_one_that_refuses_needs_an_admin(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    report = report_of(rig)
    rig.road.broken = lambda request: httpx.ConnectError("no route", request=request)
    await rig.run(5)
    assert codes(report) == ["cloud-away"]
    assert report.health()["cloud"]["state"] == "ok"
    rig.road.broken = None
    rig.switch.set(Faults(token="other"))
    await rig.run(60)
    assert codes(report) == ["cloud-refused"]
    assert report.health()["cloud"]["state"] == "degraded"
    assert "401" in report.whole()["why"]
    await rig.close()


async def test_a_record_the_cloud_never_takes_is_an_alarm_until_somebody_forgets_it(
    tmp_path: Path,
) -> None:
    rig = Rig(tmp_path)
    report = report_of(rig)
    await rig.run(1)
    rig.switch.set(Faults(max_body=2000))
    body = {"id": "urn:ngsi-ld:Alert:hof:a", "type": "Alert", "description": "x" * 3000}
    rig.backlog.put(Piece("weeder-01", Rank.ALARM, rig.clock.utc().timestamp(), json.dumps(body)))
    await rig.run(3)
    (found,) = report.findings()
    assert found.code == "cloud-not-taken"
    assert "1 record is refused by the cloud, the last: Alert: 413" in found.text
    shown = report.whole()
    assert (shown["counts"]["refused"], shown["counts"]["dropped"]) == (1, 0)
    (row,) = shown["refused"]["rows"]
    assert (row["id"], row["is_kept"], row["why"][:3]) == (body["id"], True, "413")
    rig.clock.advance(LOST_SHOWN_S)
    assert codes(report) == ["cloud-not-taken"]
    assert await rig.refused.forget_all() == 1
    assert codes(report) == []
    await rig.close()


async def test_what_was_dropped_is_an_alarm_and_is_counted(tmp_path: Path) -> None:
    rig = Rig(tmp_path, max_bytes=2000)
    report = report_of(rig)
    rig.road.broken = lambda request: httpx.ConnectError("no route", request=request)
    now_s = rig.clock.utc().timestamp()
    for number in range(40):
        rig.backlog.put(Piece("weeder-01", Rank.EVENT, now_s, f'{{"n": {number}, "x": "{"y" * 100}"}}'))
    await rig.run(12)
    assert "cloud-dropped" in codes(report)
    assert report.whole()["counts"]["dropped"] > 0
    assert report.whole()["waiting"]["bytes"] <= 2000
    await rig.close()


async def test_a_full_disk_is_an_alarm_of_its_own_and_nothing_is_said_to_be_dropped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = Rig(tmp_path)
    report = report_of(rig)

    def full(*_args: object) -> None:
        raise OutboxUnusable("outbox.db: database or disk is full")

    with monkeypatch.context() as disk:
        disk.setattr(rig.outbox, "add", full)
        rig.backlog.put(Piece("weeder-01", Rank.EVENT, rig.clock.utc().timestamp(), "{}"))
        await rig.backlog.settle()
        (alarm,) = [one for one in report.findings() if one.code in ("cloud-unkept", "cloud-dropped")]
        assert (alarm.code, alarm.text) == ("cloud-unkept", "outbox.db: database or disk is full. 1 record waits.")
    await rig.backlog.settle()
    assert not {"cloud-unkept", "cloud-dropped"} & set(codes(report))
    await rig.close()


async def test_what_does_not_go_up_is_no_alarm_while_nothing_can(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    report = report_of(rig)
    await rig.run(1)
    rig.mirror.guard.trouble["Map"] = "RuntimeError: the database is away"
    assert (codes(report), report.health()["cloud"]["state"]) == (["cloud-stuck"], "degraded")
    rig.road.broken = lambda request: httpx.ConnectError("no route", request=request)
    await rig.run(120)
    rig.mirror.guard.trouble["Map"] = "RuntimeError: the database is away"  # as it was when the link went
    assert (codes(report), report.health()["cloud"]["state"]) == (["cloud-away"], "ok")
    await rig.close()
