"""The demo farm."""

from __future__ import annotations

import json
import stat
from datetime import UTC, datetime, timedelta
from pathlib import Path

import msgspec
import pytest
import shapely
from sqlalchemy import func, select

from backend_clients.edge.messages_down import Mission as Wire
from backend_clients.simulator.config import RobotConfig
from backend_clients.simulator.history import simulate_mission
from hmi.clock import FakeClock
from hmi.demo.catalogue import CATALOGUE, plan
from hmi.demo.farm import features
from hmi.demo.fleet import FULL, FleetSize, read_demo_fleet, write_demo_fleet
from hmi.demo.history import record_run
from hmi.demo.seed import AT_ONCE, DemoSeed, SeedParts
from hmi.domain.mission import MissionStatus
from hmi.domain.mission_document import renamed
from hmi.store.database import Database
from hmi.store.farms import Farms
from hmi.store.features import Features
from hmi.store.missions import Missions
from hmi.store.robots import Robots
from hmi.store.stop_list import StopList
from hmi.store.tables import EventRow, SampleRow

FARM = "farm"


class Installation:
    """An empty console with the demo's robots written down."""

    def __init__(self, folder: Path, url: str = "http://127.0.0.1:9000", size: FleetSize = "small") -> None:
        clock = FakeClock()
        self.database = Database(f"sqlite:///{folder / 'headland.db'}")
        self.database.migrate()
        Farms(self.database, clock).ensure(FARM, "Demo")
        write_demo_fleet(folder, url, size)
        self.features, self.missions = Features(self.database, clock), Missions(self.database, clock)
        self.robots = Robots(self.database, FARM, clock, StopList(self.database, FARM, folder / "stop"))
        self.robots.load()
        self.seed = DemoSeed(SeedParts(self.database, self.features, self.missions, self.robots, clock, FARM, folder))


def test_every_feature_has_a_kind_a_name_and_a_sound_geometry() -> None:
    ids = [one.id for one in features()]
    assert len(set(ids)) == len(ids)
    for one in features():
        assert one.kind
        assert one.name
        assert shapely.from_geojson(json.dumps(one.geometry)).is_valid, one.id


def test_a_robot_stands_in_its_bay_on_the_yard_and_not_in_a_wall() -> None:
    shapes = {one.id: shapely.from_geojson(json.dumps(one.geometry)) for one in features()}
    for robot in FULL:
        assert shapes[robot.home_id].distance(shapely.Point(robot.home)) == 0
        for one in features():
            if one.kind in ("building", "obstacle"):
                assert shapes[one.id].distance(shapely.Point(robot.home)) > 0


def test_the_fleet_file_starts_a_simulator_and_keeps_its_tokens_private(tmp_path: Path) -> None:
    path = write_demo_fleet(tmp_path, "http://127.0.0.1:9000/")
    first = read_demo_fleet(tmp_path)
    write_demo_fleet(tmp_path, "http://127.0.0.1:9001")
    second = read_demo_fleet(tmp_path)
    assert [row["token"] for row in first] == [row["token"] for row in second]
    assert second[0]["http_url"] == "http://127.0.0.1:9001/weeder-01"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    known = RobotConfig.__dataclass_fields__
    configs = [RobotConfig(**{k: v for k, v in row.items() if k in known}) for row in second]
    assert [config.id for config in configs] == [one.id for one in FULL]


@pytest.mark.parametrize("mission", CATALOGUE, ids=lambda one: one.id)
def test_every_mission_of_the_catalogue_starts_and_ends_at_its_robots_home(mission: object) -> None:
    planned = plan(mission)  # type: ignore[arg-type]
    wire = msgspec.convert(planned.document, Wire)
    # small sections turn on their own ground, so a part stays untreated and is told; anything else would be a fault
    assert all("stays untreated" in note for note in planned.statistics["notes"])
    assert (wire.segments[0].kind, wire.segments[-1].kind) == ("approach", "exit")
    assert wire.segments[0].points[0] == wire.home == wire.segments[-1].points[-1]


def test_a_simulated_weeder_drives_a_mission_to_its_end_and_stays_on_its_path() -> None:
    wire = msgspec.convert(plan(CATALOGUE[1]).document, Wire)
    samples = list(simulate_mission(wire, seed=3))
    last = samples[-1].state.order
    assert last is not None
    assert (last.status, last.row) == ("done", last.rows)
    assert last.area_done_m2 >= 0.98 * last.area_m2
    assert max(abs(s.telemetry.cross_track_m or 0.0) for s in samples) < 0.2


async def test_the_first_start_has_map_robots_and_short_missions_at_once(tmp_path: Path) -> None:
    demo = Installation(tmp_path)
    await demo.seed.at_once()
    assert {one.id for one in demo.features.all(FARM)} == {one.id for one in features()}
    assert [one.id for one in demo.robots.all()] == ["weeder-01", "weeder-02", "weeder-03"]
    stored = demo.missions.all_known(FARM)
    assert {one.id for one in stored} == {one.id for one in CATALOGUE[:AT_ONCE]}
    assert {one.status for one in stored} == {MissionStatus.VALIDATED}
    demo.database.close()


async def test_a_second_start_changes_nothing_but_addresses(tmp_path: Path) -> None:
    demo = Installation(tmp_path)
    await demo.seed.at_once()
    demo.missions.rename(FARM, "trial-strip", "My strip", "Pieter")
    demo.database.close()
    again = Installation(tmp_path, "http://127.0.0.1:9009")
    await again.seed.at_once()
    renamed_one = again.missions.known("trial-strip")
    assert renamed_one is not None
    assert renamed_one.name == "My strip"
    robot = again.robots.get("weeder-01")
    assert robot is not None
    assert robot.http_url == "http://127.0.0.1:9009/weeder-01"
    again.database.close()


def test_a_recorded_run_leaves_samples_and_events_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.nice", lambda _step: 0)  # the test's own process is not to be slowed for good
    demo = Installation(tmp_path)
    started = datetime(2026, 5, 3, 9, 0, tzinfo=UTC)
    document = renamed(plan(CATALOGUE[1]).document, mission_id="run-1")
    url = str(demo.database.url)
    for _ in range(2):  # the second time stands for a first start that was interrupted
        outcome = record_run(url, FARM, document, started, 9002)
    assert outcome.status == "done"
    assert outcome.row == outcome.rows
    with demo.database.read() as session:
        count, first, last = session.execute(select(func.count(), func.min(SampleRow.at), func.max(SampleRow.at))).one()
        events = session.scalar(select(func.count()).select_from(EventRow))
    duration_s = (outcome.ended - started).total_seconds()
    assert duration_s > 200
    assert count == pytest.approx(duration_s, rel=0.05)
    assert first - started < timedelta(seconds=5)
    assert outcome.ended - last < timedelta(seconds=5)
    assert events is not None
    assert events > 20
    demo.database.close()
