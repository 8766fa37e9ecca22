"""The demo farm."""

from __future__ import annotations

import json
import stat
from collections import Counter
from datetime import UTC, datetime, timedelta
from pathlib import Path

import msgspec
import pytest
import shapely
from sqlalchemy import func, select

from backend_clients.edge.codec import mission_hash
from backend_clients.edge.messages_down import Mission as Wire
from backend_clients.simulator.cameras.painter import Painter
from backend_clients.simulator.cameras.scenery import Scenery, scene_of
from backend_clients.simulator.config import RobotConfig
from backend_clients.simulator.enu import EnuFrame
from backend_clients.simulator.history import simulate_mission
from hmi.clock import FakeClock
from hmi.demo.catalogue import CATALOGUE, plan
from hmi.demo.crowd import fleet_rows, lean_jobs, lean_rows
from hmi.demo.farm import feature, features
from hmi.demo.fleet import FULL, FleetSize, read_demo_fleet, robot, write_demo_fleet
from hmi.demo.history import record_run
from hmi.demo.jobs import jobs_of
from hmi.demo.scenery import map_features
from hmi.demo.seed import AT_ONCE, DemoSeed, SeedParts
from hmi.demo.work import TASKS, planned_work
from hmi.domain.mission import MissionStatus
from hmi.domain.mission_document import drives_backward, renamed
from hmi.domain.robot import Family
from hmi.store.database import Database
from hmi.store.farms import Farms
from hmi.store.features import Features
from hmi.store.missions import Missions
from hmi.store.robots import RegisteredRobot, Robots
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
    yards = shapely.union_all([shapes[one.id] for one in features() if one.kind == "road"])
    for machine in FULL:
        assert shapes[machine.home_id].distance(shapely.Point(machine.home)) == 0
        assert yards.covers(shapely.Point(machine.home))
        for one in features():
            if one.kind in ("building", "obstacle"):
                assert shapes[one.id].distance(shapely.Point(machine.home)) > 0
    assert len({machine.home for machine in FULL}) == len(FULL)


def test_the_farm_has_six_named_parcels_and_more_a_no_entry_area_gates_and_obstacles() -> None:
    near = [one for one in features() if one.properties["site"] == "polder"]
    kinds = Counter(one.kind for one in near)
    assert kinds["parcel"] >= 6
    assert kinds["home"] == 2 + 14 + 4 + 4
    assert min(kinds[kind] for kind in ("no-go", "gate", "obstacle", "building", "water", "hedge")) >= 1
    crops = {one.properties["crop"] for one in near if one.kind == "parcel"}
    assert len(crops) >= 5


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


@pytest.mark.slow
async def test_a_full_fleet_has_its_work_from_the_first_moment(tmp_path: Path) -> None:
    demo = Installation(tmp_path, size="full")
    await demo.seed.at_once()
    assert {one.id for one in demo.robots.all()} == {one.id for one in FULL}
    assert {one.family for one in demo.robots.all()} == {Family.WEEDER, Family.PLANTER, Family.UAV}
    jobs = jobs_of(read_demo_fleet(tmp_path))
    for robot_id, job in jobs.items():
        stored = demo.missions.known(job.mission.mission_id)
        assert stored is not None
        assert (stored.robot_id, stored.sha256) == (robot_id, mission_hash(job.mission))
        assert not stored.is_supervised
    assert not {"weeder-01", "weeder-02"} & jobs.keys()
    assert len(jobs) == 17
    assert {one.id for one in demo.robots.all() if one.is_unattended_allowed} == jobs.keys()
    demo.database.close()


def test_the_shipped_work_lies_in_its_fields_and_begins_at_home() -> None:
    for task in TASKS:
        planned = planned_work()[task.mission_id]
        wire = msgspec.convert(planned.document, Wire)
        frame = EnuFrame(wire.datum.lat_deg, wire.datum.lon_deg)
        assert wire.home == pytest.approx(frame.to_enu(*reversed(robot(task.robot_id).home)), abs=0.01)
        assert wire.segments[0].points[0] == wire.home == wire.segments[-1].points[-1]
        field = shapely.from_geojson(json.dumps(feature(task.field_id).geometry))
        parcel = shapely.Polygon(wire.parcel[0])
        assert field.buffer(1e-7).covers(parcel), task
        plane = shapely.Polygon([frame.to_enu(lat, lon) for lon, lat in wire.parcel[0]])
        for segment in wire.segments:
            assert not segment.tool_on or plane.buffer(0.1).covers(shapely.LineString(segment.points)), task


def test_no_work_of_a_ground_robot_crosses_what_must_not_be_entered() -> None:
    for task in TASKS:
        wire = msgspec.convert(planned_work()[task.mission_id].document, Wire)
        frame = EnuFrame(wire.datum.lat_deg, wire.datum.lon_deg)
        if robot(task.robot_id).family is Family.UAV:
            continue
        path = shapely.union_all([shapely.LineString(one.points) for one in wire.segments])
        for one in features():
            if one.kind in ("no-go", "building") and one.properties["site"] == "polder":
                ground = shapely.Polygon([frame.to_enu(lat, lon) for lon, lat in one.geometry["coordinates"][0]])
                assert not ground.intersects(path), (task, one.id)


def test_a_crowd_of_any_size_stands_on_the_farm_with_ids_of_its_own() -> None:
    rows = fleet_rows(20, 5, 4)
    assert len({row["id"] for row in rows}) == len(rows) == 29
    assert len({(row["x_m"], row["y_m"]) for row in rows}) == 29
    lean = lean_rows(1000)
    assert len({(row["x_m"], row["y_m"]) for row in lean}) == 1000
    assert len(lean_jobs(lean)) == 1000


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
    registered = again.robots.get("weeder-01")
    assert registered is not None
    assert registered.http_url == "http://127.0.0.1:9009/weeder-01"
    again.database.close()


@pytest.mark.slow
async def test_a_smaller_demo_takes_out_the_robots_it_does_not_run_and_no_others(tmp_path: Path) -> None:
    full = Installation(tmp_path, size="full")
    await full.seed.at_once()
    full.robots.add(RegisteredRobot("weeder-90", FARM, "Ours", Family.WEEDER, "admin", FakeClock().utc()))
    full.robots.remove("weeder-16")
    full.robots.add(RegisteredRobot("weeder-16", FARM, "Ours too", Family.WEEDER, "admin", FakeClock().utc()))
    full.database.close()
    small = Installation(tmp_path)
    await small.seed.at_once()
    assert {one.id for one in small.robots.all()} == {
        "weeder-01", "weeder-02", "weeder-03", "weeder-16", "weeder-90"
    }  # fmt: skip
    small.database.close()
    again = Installation(tmp_path, size="full")
    await again.seed.at_once()
    assert len(again.robots.all()) == 25
    again.database.close()


@pytest.mark.slow
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


def test_one_field_has_a_guide_line_and_recorded_rows_to_try() -> None:
    field = feature("kromme-akker")
    outline = shapely.from_geojson(json.dumps(field.geometry))
    drawn = {one.properties["type"]: one for one in features() if one.properties.get("parcel_id") == field.id}
    assert drawn.keys() == {"curve", "recorded"}
    for one in drawn.values():
        assert outline.covers(shapely.from_geojson(json.dumps(one.geometry)))


def test_planters_back_up_in_their_turns_and_nobody_else_does() -> None:
    backing = {task.robot_id for task in TASKS if drives_backward(planned_work()[task.mission_id].document)}
    assert backing == {"planter-01", "planter-02", "planter-03"}


def test_every_robot_of_the_demo_has_a_scene_for_its_cameras_with_the_fields_around_it() -> None:
    scenery = Scenery(map_features())
    for row in fleet_rows(1, 1, 1):
        config = RobotConfig(
            row["id"], row["name"], "secret", family=row["family"],
            datum_lat_deg=row["datum_lat_deg"], datum_lon_deg=row["datum_lon_deg"],
        )  # fmt: skip
        scene = scene_of(scenery, config, None)
        assert sum(one.kind == "field" for one in scene.grounds) >= 5
        assert any(one.kind == "road" for one in scene.grounds)
        painter = Painter()
        painter.keep(scene)
        assert scene.solids
