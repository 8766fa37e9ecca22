"""What the broker will not take is kept with its reason, and goes up when it is taken after all."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Sequence
from pathlib import Path

import httpx
import pytest

from backend_clients.ngsi.identifier import EntityRef
from backend_clients.simulator.context_broker.faults import Faults
from hmi.clock import FakeClock
from hmi.cloud import refused as refused_module
from hmi.cloud.kept_file import OutboxUnusable
from hmi.cloud.outbox import Piece, Rank
from hmi.cloud.refused import Refused, RefusedFile, RefusedRecords
from hmi.service_link import NEEDS_PERSON, LinkState
from tests.hmi.cloud.rig import Rig


def alert(rig: Rig, name: str, text: str = "", *, size: int = 0) -> None:
    """Let an alarm happen; the same name is the same alarm."""
    body = {"id": f"urn:ngsi-ld:Alert:hof:{name}", "type": "Alert", "description": text + "x" * size}
    rig.backlog.put(Piece("weeder-01", Rank.ALARM, rig.clock.utc().timestamp(), json.dumps(body)))


async def texts(rig: Rig) -> dict[str, str]:
    """Return the alarms in the cloud, what each says."""
    return {
        key.rpartition(":")[2]: one["description"].rstrip("x") for key, one in (await rig.in_cloud("Alert")).items()
    }


async def test_a_record_that_is_too_large_is_kept_over_a_restart_and_goes_up_once_it_is_taken(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    await rig.run(1)
    rig.switch.set(Faults(max_body=2000))
    alert(rig, "large", "kept", size=3000)
    alert(rig, "small", "told")
    await rig.run(3)
    assert (await texts(rig), rig.backlog.total) == ({"small": "told"}, 0)
    await rig.close()

    again = Rig(tmp_path, clock=rig.clock, broker=rig.broker)
    again.switch.set(Faults(max_body=2000))
    await again.run(3)
    (kept,) = again.refused.all()
    assert kept.ref.id.endswith(":large")
    again.switch.set(Faults())
    await again.run(3)
    assert len(again.refused.all()) == 1  # nobody asked for it yet
    again.mirror.send_again()
    await again.run(1)
    assert (again.refused.all(), await texts(again)) == ([], {"small": "told", "large": "kept"})
    await again.close()


async def test_an_older_record_never_goes_over_what_is_newer_of_the_same_thing(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    await rig.run(1)
    rig.switch.set(Faults(max_body=2000))
    alert(rig, "a", "raised", size=3000)
    alert(rig, "b", "raised", size=3000)
    await rig.run(3)
    alert(rig, "a", "cleared")
    await rig.run(1)
    assert [one.ref.id[-1] for one in rig.refused.all()] == ["b"]
    rig.switch.set(Faults(status=503))
    await rig.run(2)
    alert(rig, "b", "cleared")  # waits, while the older one is asked for
    rig.mirror.send_again()
    rig.switch.set(Faults())
    await rig.run(60)
    assert (await texts(rig), rig.refused.all()) == ({"a": "cleared", "b": "cleared"}, [])
    await rig.close()


async def test_a_batch_that_a_proxy_calls_too_large_is_asked_for_in_parts_and_remembered(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    await rig.run(1)

    def proxy(request: httpx.Request) -> httpx.Response | None:
        too_large = request.url.path.endswith("/op/update") and len(request.content) > 8192
        return httpx.Response(413, html="<h1>413 Request Entity Too Large</h1>") if too_large else None

    rig.road.broken = proxy
    for number in range(60):
        alert(rig, f"n{number}", size=500)
    await rig.run(3)
    assert (len(await texts(rig)), rig.refused.all()) == (60, [])
    before = len(rig.road.requests)
    for number in range(60, 120):
        alert(rig, f"n{number}", size=500)
    await rig.run(3)
    refused = [one for one in rig.road.requests[before:] if len(one.content) > 8192]
    assert (len(await texts(rig)), refused) == (120, [])
    await rig.close()


async def test_a_proxy_that_takes_nothing_holds_everything_up_and_drops_nothing(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    await rig.run(1)
    rig.road.broken = lambda request: (
        httpx.Response(413, html="<h1>413</h1>") if request.url.path.endswith("/op/update") else None
    )
    for number in range(30):
        alert(rig, f"n{number}")
    before = len(rig.road.requests)
    await rig.run(5)
    assert (rig.backlog.total, rig.refused.all(), rig.link.link.state) == (30, [], LinkState.NARROW)
    assert rig.link.link.state in NEEDS_PERSON
    assert "limit of a proxy" in rig.link.link.mend
    assert len(rig.road.requests) - before < 30
    rig.road.broken = None
    await rig.run(60)
    assert (len(await texts(rig)), rig.backlog.total) == (30, 0)
    await rig.close()


async def test_an_entity_of_the_map_that_is_refused_is_named_until_it_is_taken_or_is_on_the_map_no_more(
    tmp_path: Path,
) -> None:
    rig = Rig(tmp_path)
    rig.switch.set(Faults(max_body=4000))
    field = {"id": "urn:ngsi-ld:AgriParcel:hof:f1", "type": "AgriParcel", "name": "x" * 5000}
    rig.whole = [field, {"id": "urn:ngsi-ld:AgriParcel:hof:f2", "type": "AgriParcel", "name": "small"}]
    await rig.run(2)
    assert [ref.id[-2:] for ref in rig.mirror.not_taken] == ["f1"]
    assert rig.refused.all() == []
    rig.switch.set(Faults())
    rig.mirror.send_again()
    await rig.run(2)
    assert rig.mirror.not_taken == {}
    rig.switch.set(Faults(max_body=4000))
    rig.mirror.tell_whole()
    await rig.run(2)
    assert len(rig.mirror.not_taken) == 1
    rig.whole = rig.whole[1:]
    rig.mirror.tell_whole()
    await rig.run(2)
    assert rig.mirror.not_taken == {}
    await rig.close()


class Full(RefusedFile):
    """Takes nothing while the disk is full."""

    is_full = False

    def _write(self, statement: str, rows: Sequence[tuple[object, ...]]) -> int:
        if self.is_full:
            raise self._unusable(sqlite3.OperationalError("database or disk is full"))
        return super()._write(statement, rows)


def record(name: str, rank: Rank = Rank.EVENT, at_s: float = 0.0) -> tuple[EntityRef, Piece, str]:
    """Return what was refused."""
    return EntityRef(name, "Alert"), Piece("r", rank, at_s, "{}"), "413"


async def test_a_full_disk_loses_no_refused_record(tmp_path: Path) -> None:
    file = Full(tmp_path / "r.db")
    kept = RefusedRecords(file, FakeClock())
    await kept.keep([record("a"), record("b")])
    file.is_full = True
    await kept.keep([record("c")])
    await kept.arrived([EntityRef("a", "Alert")])
    assert {one.ref.id for one in kept.all()} == {"b", "c"}
    file.is_full = False
    await kept.close()
    later = RefusedRecords(RefusedFile(tmp_path / "r.db"), FakeClock())
    await later.settle()
    assert {one.ref.id for one in later.all()} == {"b", "c"}


async def test_refused_records_are_bounded_and_what_makes_room_is_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(refused_module, "MOST", 3)
    kept = RefusedRecords(RefusedFile(tmp_path / "r.db"), FakeClock())
    await kept.keep([record("mission", Rank.MISSION, 1.0), *(record(f"e{n}", at_s=2.0 + n) for n in range(4))])
    assert {one.ref.id for one in kept.all()} == {"mission", "e2", "e3"}
    assert kept.dropped == 2
    await kept.close()


async def test_two_entities_of_a_map_under_one_id_never_write_over_each_other_and_are_named(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    await rig.run(1)
    rig.link.most = 2
    crops = [{"id": f"urn:ngsi-ld:AgriCrop:hof:c{n}", "type": "AgriCrop", "name": f"{n}"} for n in range(5)]
    rig.whole = [*crops, {**crops[0], "name": "another"}]
    rig.mirror.tell_whole()
    await rig.run(2)
    assert (await rig.in_cloud("AgriCrop"))[crops[0]["id"]]["name"] == "0"
    assert [(ref.id, one.why[:11]) for ref, one in rig.mirror.not_taken.items()] == [(crops[0]["id"], "two at once")]
    rig.whole = crops
    rig.mirror.tell_whole()
    await rig.run(2)
    assert rig.mirror.not_taken == {}
    await rig.close()


async def test_what_is_told_again_when_it_changes_is_forgotten_with_the_records(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.switch.set(Faults(max_body=4000))
    rig.whole = [{"id": "urn:ngsi-ld:AgriParcel:hof:f1", "type": "AgriParcel", "name": "x" * 5000}]
    await rig.run(2)
    alert(rig, "a", size=5000)
    await rig.run(2)
    assert (len(rig.mirror.not_taken), len(rig.refused.all())) == (1, 1)
    assert await rig.mirror.forget_refused() == 2
    assert (rig.mirror.not_taken, rig.refused.all()) == ({}, [])
    rig.mirror.tell_whole()
    await rig.run(2)
    assert len(rig.mirror.not_taken) == 1
    await rig.close()


async def test_what_arrived_while_the_file_could_not_be_read_makes_the_record_in_it_of_no_use(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock, ref = FakeClock(), EntityRef("urn:ngsi-ld:Alert:hof:a", "Alert")
    before = RefusedRecords(RefusedFile(tmp_path / "refused.db"), clock)
    await before.keep([(ref, Piece("weeder-01", Rank.ALARM, 1.0, "{}"), "413")])
    await before.close()

    file = RefusedFile(tmp_path / "refused.db")
    after = RefusedRecords(file, clock)
    with monkeypatch.context() as locked:
        locked.setattr(file, "all", _locked)
        await after.settle()
        await after.arrived({ref})
    await after.settle()
    assert after.all() == []
    assert file.all() == []
    await after.close()


def _locked() -> list[Refused]:
    raise OutboxUnusable("refused.db: database is locked")
