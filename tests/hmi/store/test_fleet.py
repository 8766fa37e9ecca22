"""The fleet store tells what changed since when, and strangers never become operable by talking."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st

from hmi.clock import FakeClock
from hmi.domain.machine import Worksite
from hmi.domain.robot import Node, Stamp
from hmi.store.fleet import NODE_LIMIT, UNREGISTERED_KEPT_S, UNREGISTERED_LIMIT, FleetStore
from hmi.store.robot_record import Part
from tests.hmi.ingest.wire import Entry
from tests.hmi.presenters.robots import FAST, SAFE, SHEET, STATE

NODE = Node("driver", "started", None, None, 0, "", Stamp(0, 0))
SITE = Worksite(stop=3, area=(), obstacles=(), targets=(), stamp=Stamp(0, 0))


def store(*registered: str) -> tuple[FleetStore, FakeClock]:
    """Return a store with a registry on a fake clock."""
    clock = FakeClock()
    fleet = FleetStore(clock.mono_s, "farm")
    fleet.set_registry([Entry(i) for i in registered])
    return fleet, clock


def test_a_registered_robot_is_known_before_it_is_heard() -> None:
    fleet, _ = store("weeder-01")
    robot = fleet.robot("weeder-01")
    assert robot is not None
    assert robot.is_registered
    assert robot.name == "Weeder 01"
    assert not robot.link.is_online
    assert robot.telemetry is None


def test_only_what_changed_is_told() -> None:
    fleet, _ = store("weeder-01", "weeder-02")
    revision = fleet.revision
    fleet.put_telemetry("weeder-01", FAST)
    fleet.put_safety("weeder-01", SAFE)
    changes = fleet.since(revision)
    assert changes.robots == {"weeder-01": frozenset({Part.TELEMETRY, Part.SAFETY})}
    assert fleet.since(changes.revision).robots == {}


@given(
    steps=st.lists(st.tuples(st.sampled_from(["a1", "b1", "c1"]), st.sampled_from(["fast", "state", "safe"]))),
    asked=st.integers(0, 40),
)
def test_nothing_that_changed_after_a_revision_is_missed(steps: list[tuple[str, str]], asked: int) -> None:
    fleet, _ = store("a1", "b1", "c1")
    puts = {
        "fast": (Part.TELEMETRY, lambda i: fleet.put_telemetry(i, FAST)),
        "state": (Part.STATE, lambda i: fleet.put_state(i, STATE)),
        "safe": (Part.SAFETY, lambda i: fleet.put_safety(i, SAFE)),
    }
    base = fleet.revision
    expected: dict[str, set[Part]] = {}
    for robot_id, what in steps:
        part, put = puts[what]
        put(robot_id)
        if fleet.revision > base + asked:
            expected.setdefault(robot_id, set()).add(part)
    assert {i: set(p) for i, p in fleet.since(base + asked).robots.items()} == expected


def test_a_robot_once_read_never_changes() -> None:
    fleet, _ = store("weeder-01")
    fleet.put_telemetry("weeder-01", FAST)
    before = fleet.robot("weeder-01")
    fleet.put_telemetry("weeder-01", replace(FAST, cross_track_m=0.5))
    assert before is not None
    assert before.telemetry == FAST


def test_listeners_hear_of_a_batch_once_it_is_announced() -> None:
    fleet, _ = store("weeder-01")
    heard: list[int] = []
    end = fleet.subscribe(lambda: heard.append(fleet.revision))
    fleet.put_telemetry("weeder-01", FAST)
    fleet.put_state("weeder-01", STATE)
    assert heard == []
    fleet.announce()
    end()
    fleet.announce()
    assert heard == [fleet.revision]


def test_a_stranger_has_no_address_and_takes_its_name_from_its_factsheet() -> None:
    fleet, _ = store()
    fleet.admit("stranger-9")
    fleet.put_factsheet("stranger-9", SHEET)
    robot = fleet.robot("stranger-9")
    assert robot is not None
    assert not robot.is_registered
    assert robot.name == "Weeder"
    assert robot.farm_id == "farm"
    assert fleet.address("stranger-9") is None
    assert fleet.registered_ids() == ()


def test_a_stranger_that_is_accepted_keeps_what_was_heard() -> None:
    fleet, _ = store()
    fleet.admit("stranger-9")
    fleet.put_state("stranger-9", STATE)
    fleet.set_registry([Entry("stranger-9", name="Weeder 09", http_url="http://10.0.0.9", http_token="t")])
    robot = fleet.robot("stranger-9")
    assert robot is not None
    assert robot.is_registered
    assert robot.name == "Weeder 09"
    assert robot.state == STATE
    address = fleet.address("stranger-9")
    assert address is not None
    assert (address.http_url, address.token) == ("http://10.0.0.9", "t")


def test_a_robot_taken_out_of_the_registry_is_gone_and_told_so() -> None:
    fleet, _ = store("weeder-01")
    revision = fleet.revision
    fleet.set_registry([])
    assert fleet.robot("weeder-01") is None
    assert fleet.since(revision).removed == {"weeder-01"}
    fleet.set_registry([Entry("weeder-01")])
    assert fleet.since(revision).removed == frozenset()


def test_a_robot_accepted_again_is_what_it_said_it_is_and_nothing_live_of_before() -> None:
    fleet, _ = store("weeder-01")
    fleet.put_factsheet("weeder-01", SHEET)
    fleet.put_node("weeder-01", NODE)
    fleet.put_worksite("weeder-01", SITE)
    fleet.put_state("weeder-01", STATE)
    fleet.put_safety("weeder-01", replace(SAFE, latched=True))
    fleet.put_telemetry("weeder-01", FAST)
    fleet.put_heartbeat("weeder-01", boot="b", challenge="c", heard_s=0.0)
    fleet.set_registry([])
    revision = fleet.revision
    assert fleet.admit("weeder-01")
    stranger = fleet.robot("weeder-01")
    assert stranger is not None
    assert not stranger.is_registered
    assert (stranger.factsheet, stranger.nodes, stranger.worksite) == (SHEET, {NODE.name: NODE}, SITE)
    assert (stranger.state, stranger.safety, stranger.telemetry, stranger.body) == (None, None, None, None)
    assert (stranger.link.is_online, stranger.link.challenge, stranger.link.boot) == (False, None, None)
    assert fleet.since(revision).robots["weeder-01"] >= {Part.FACTSHEET, Part.NODES, Part.WORKSITE}
    fleet.set_registry([Entry("weeder-01")])
    robot = fleet.robot("weeder-01")
    assert robot is not None
    assert robot.is_registered
    assert robot.factsheet == SHEET


def test_a_robot_taken_out_and_accepted_while_it_is_silent_has_its_factsheet_and_its_farewell() -> None:
    fleet, _ = store("weeder-01")
    fleet.put_factsheet("weeder-01", SHEET)
    fleet.put_presence("weeder-01", is_online=False, is_shutdown=True)
    fleet.set_registry([])
    assert fleet.robots() == []
    fleet.set_registry([Entry("weeder-01")])
    robot = fleet.robot("weeder-01")
    assert robot is not None
    assert robot.factsheet == SHEET
    assert fleet.said_goodbye("weeder-01")
    fleet.put_factsheet("weeder-01", replace(SHEET, name="Another"))
    fleet.set_registry([])
    fleet.set_registry([Entry("weeder-01")])
    robot = fleet.robot("weeder-01")
    assert robot is not None
    assert robot.factsheet is not None
    assert robot.factsheet.name == "Another"


def test_a_robot_that_was_registered_gets_in_among_too_many_strangers() -> None:
    fleet, _ = store("weeder-01")
    fleet.set_registry([])
    for number in range(UNREGISTERED_LIMIT):
        assert fleet.admit(f"stranger-{number}")
    assert not fleet.admit("late-comer")
    assert fleet.admit("weeder-01")


def test_a_stranger_long_silent_makes_room_for_a_new_one() -> None:
    fleet, clock = store()
    for number in range(UNREGISTERED_LIMIT):
        assert fleet.admit(f"stranger-{number}")
    assert not fleet.admit("late-comer")
    clock.advance(UNREGISTERED_KEPT_S)
    assert fleet.admit("late-comer")
    assert len(fleet.robots()) == UNREGISTERED_LIMIT


def test_registered_robots_are_not_counted_as_strangers() -> None:
    fleet, _ = store(*[f"weeder-{n}" for n in range(UNREGISTERED_LIMIT + 5)])
    assert fleet.admit("stranger-1")


def test_a_robot_may_report_only_so_many_nodes() -> None:
    fleet, _ = store("weeder-01")
    for number in range(NODE_LIMIT + 20):
        fleet.put_node("weeder-01", Node(f"node-{number}", "started", None, None, 0, "", Stamp(0, 0)))
    robot = fleet.robot("weeder-01")
    assert robot is not None
    assert len(robot.nodes) == NODE_LIMIT


def test_the_largest_round_trip_of_the_last_minute_is_kept() -> None:
    fleet, clock = store("weeder-01")
    for rtt_s in (0.09, 0.14, 0.08):
        fleet.put_round_trip("weeder-01", rtt_s)
        clock.advance(25)
    robot = fleet.robot("weeder-01")
    assert robot is not None
    assert (robot.link.rtt_s, robot.link.rtt_max_s) == (0.08, 0.14)
    clock.advance(11)
    fleet.put_round_trip("weeder-01", 0.07)
    robot = fleet.robot("weeder-01")
    assert robot is not None
    assert robot.link.rtt_max_s == 0.08


def test_a_repeated_factsheet_changes_nothing() -> None:
    fleet, _ = store("weeder-01")
    fleet.put_factsheet("weeder-01", SHEET)
    revision = fleet.revision
    fleet.put_factsheet("weeder-01", replace(SHEET))
    assert fleet.revision == revision


def test_registered_robots_come_first_by_id() -> None:
    fleet, _ = store("weeder-02", "weeder-01")
    fleet.admit("alien-1")
    assert [r.id for r in fleet.robots()] == ["weeder-01", "weeder-02", "alien-1"]
