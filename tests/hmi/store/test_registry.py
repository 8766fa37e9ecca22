"""Robots, tablets and people on disk, and the files the STOP gateway reads."""

from __future__ import annotations

import json
import stat
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import pytest

from hmi.clock import FakeClock
from hmi.domain.robot import Family
from hmi.domain.role import Role
from hmi.store.database import Database
from hmi.store.devices import Devices
from hmi.store.errors import AlreadyExists, NotFound, StopListNotWritten
from hmi.store.farms import Farms
from hmi.store.robots import RegisteredRobot, Robots
from hmi.store.sessions import SessionRecords, StoredSession
from hmi.store.stop_list import StopList
from hmi.store.users import Users
from tests.hmi.store.conftest import FARM


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return the gateway's folder, not made yet."""
    return tmp_path / "stop"


@pytest.fixture
def stop_list(database: Database, folder: Path) -> StopList:
    """Return what writes the gateway's files."""
    return StopList(database, FARM, folder)


@pytest.fixture
def robots(database: Database, clock: FakeClock, stop_list: StopList) -> Robots:
    """Return the registry of the farm."""
    return Robots(database, FARM, clock, stop_list)


def weeder(clock: FakeClock, robot_id: str = "weeder-01") -> RegisteredRobot:
    """Return a robot to be registered."""
    return RegisteredRobot(
        robot_id, FARM, "Weeder 01", Family.WEEDER, "admin", clock.utc(), http_url="http://10.0.0.7:9000",
        http_token="t0ken", decel_mps2=1.2, contact_name="Jonas Weber", contact_phone="+49 1",
    )  # fmt: skip


def in_file(folder: Path, name: str) -> list[object]:
    """Return what the gateway reads."""
    read = json.loads((folder / name).read_text())
    assert isinstance(read, list)
    return read


def test_a_registered_robot_reaches_the_gateway(robots: Robots, clock: FakeClock, folder: Path) -> None:
    robots.add(weeder(clock))
    assert in_file(folder, "robots.json") == [
        {
            "id": "weeder-01", "name": "Weeder 01", "http_url": "http://10.0.0.7:9000", "token": "t0ken",
            "decel_mps2": 1.2, "ack_limit_s": 1.0, "standstill_limit_s": 3.0, "keep_out_m": 15.0,
            "own_keep_out_m": None, "contact_name": "Jonas Weber", "contact_phone": "+49 1",
        }
    ]  # fmt: skip
    assert stat.S_IMODE((folder / "robots.json").stat().st_mode) == 0o600
    assert sorted(path.name for path in folder.iterdir()) == ["revoked.json", "robots.json"]


def test_changes_and_removal_reach_the_gateway_and_listeners(robots: Robots, clock: FakeClock, folder: Path) -> None:
    heard: list[list[str]] = []
    robots.on_changed(lambda: heard.append([robot.name for robot in robots.all()]))
    added = robots.add(weeder(clock))
    robots.change(replace(added, name="Weeder 1 north", ack_limit_s=0.5))
    assert in_file(folder, "robots.json")[0]["name"] == "Weeder 1 north"  # type: ignore[index]
    robots.remove("weeder-01")
    assert in_file(folder, "robots.json") == []
    assert heard == [["Weeder 01"], ["Weeder 1 north"], []]
    assert robots.get("weeder-01") is None


def test_a_robot_is_registered_once_and_can_come_back(robots: Robots, clock: FakeClock) -> None:
    robots.add(weeder(clock))
    with pytest.raises(AlreadyExists):
        robots.add(weeder(clock))
    robots.remove("weeder-01")
    with pytest.raises(NotFound):
        robots.change(weeder(clock))
    robots.add(weeder(clock))
    assert robots.get("weeder-01") is not None


def test_the_registry_survives_a_restart(
    robots: Robots, clock: FakeClock, database: Database, stop_list: StopList, folder: Path
) -> None:
    added = robots.add(weeder(clock))
    (folder / "robots.json").unlink()
    again = Robots(database, FARM, clock, stop_list)
    again.load()
    assert again.all() == [added]
    assert len(in_file(folder, "robots.json")) == 1


def test_a_robot_of_another_farm_is_not_ours_and_not_in_our_list(
    robots: Robots, clock: FakeClock, database: Database, stop_list: StopList, folder: Path, tmp_path: Path
) -> None:
    Farms(database, clock).ensure("north", "North")
    Robots(database, "north", clock, StopList(database, "north", tmp_path / "north")).add(weeder(clock, "uav-09"))
    robots.load()
    assert robots.get("uav-09") is None
    assert robots.of_any_farm("uav-09") is not None
    assert in_file(folder, "robots.json") == []
    with pytest.raises(AlreadyExists):
        robots.add(weeder(clock, "uav-09"))
    with pytest.raises(NotFound):
        robots.remove("uav-09")


def test_a_list_that_cannot_be_written_is_told_and_written_later(
    robots: Robots, clock: FakeClock, folder: Path, stop_list: StopList
) -> None:
    folder.write_text("a file in the way")
    with pytest.raises(StopListNotWritten):
        robots.add(weeder(clock))
    assert robots.get("weeder-01") is not None
    assert not stop_list.is_written
    folder.unlink()
    stop_list.export()
    assert stop_list.is_written
    assert len(in_file(folder, "robots.json")) == 1


def test_a_revoked_tablet_is_in_the_gateways_list(
    database: Database, clock: FakeClock, stop_list: StopList, folder: Path
) -> None:
    devices = Devices(database, clock, stop_list)
    kept, lost = devices.enrol(FARM, "Tablet 3", "admin"), devices.enrol(FARM, "Tablet 4", "admin")
    devices.revoke(FARM, lost.id)
    assert in_file(folder, "revoked.json") == [lost.id]
    assert devices.is_revoked(lost.id)
    assert not devices.is_revoked(kept.id)
    again = Devices(database, clock, stop_list)
    again.load()
    assert again.is_revoked(lost.id)
    with pytest.raises(NotFound):
        devices.revoke("north", kept.id)


def test_browsers_of_somebody_switched_off_are_in_the_gateways_list(
    database: Database, clock: FakeClock, stop_list: StopList, folder: Path
) -> None:
    users, devices = Users(database, clock), Devices(database, clock, stop_list)
    tablet = devices.enrol(FARM, "Tablet 3", "admin")
    users.add("martha", FARM, "Martha Keller", Role.OPERATOR, "hash")
    for number, device_id in enumerate((tablet.id, "browser-1")):
        session = StoredSession(
            str(number), FARM, "martha", "Martha Keller", Role.OPERATOR, device_id, "", "", clock.utc() + timedelta(1)
        )
        SessionRecords(database).add(session, clock.utc())
    stop_list.export()
    assert in_file(folder, "revoked.json") == []
    users.change(FARM, "martha", is_active=False)
    stop_list.export()
    assert in_file(folder, "revoked.json") == ["browser-1"]


def test_people_of_another_farm_cannot_be_changed(database: Database, clock: FakeClock) -> None:
    users = Users(database, clock)
    users.add("martha", FARM, "Martha Keller", Role.OPERATOR, "hash")
    with pytest.raises(NotFound):
        users.change("north", "martha", role=Role.ADMIN)
    with pytest.raises(AlreadyExists):
        users.add("martha", FARM, "Another Martha", Role.VIEWER, "hash")
    assert [user.role for user in users.all(FARM)] == [Role.OPERATOR]


def test_hashes_are_not_shown_when_credentials_are_logged(database: Database, clock: FakeClock) -> None:
    users = Users(database, clock)
    users.add("martha", FARM, "Martha Keller", Role.OPERATOR, "$argon2id$secret")
    assert "secret" not in repr(users.credentials("martha"))


def test_the_gateway_asks_for_the_larger_distance_and_keeps_it_over_a_restart(
    database: Database, robots: Robots, stop_list: StopList, clock: FakeClock, folder: Path
) -> None:
    added = robots.add(weeder(clock))
    stop_list.learn_keep_out({"weeder-01": 20.0, "not-ours": 50.0})
    assert _keep_out(folder) == (20.0, 20.0)
    robots.change(replace(added, keep_out_m=30.0))
    StopList(database, FARM, folder).export()  # a machine that is off has said it before
    assert _keep_out(folder) == (30.0, 20.0)


def test_a_list_is_written_only_when_a_machine_says_something_new(
    robots: Robots, stop_list: StopList, clock: FakeClock, folder: Path
) -> None:
    robots.add(weeder(clock))
    stop_list.learn_keep_out({"weeder-01": 20.0})
    (folder / "robots.json").unlink()
    stop_list.learn_keep_out({"weeder-01": 20.0})
    assert not (folder / "robots.json").exists()


def _keep_out(folder: Path) -> tuple[float, float]:
    row = in_file(folder, "robots.json")[0]
    assert isinstance(row, dict)
    return row["keep_out_m"], row["own_keep_out_m"]
