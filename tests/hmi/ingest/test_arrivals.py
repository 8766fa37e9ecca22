"""What robots sent and did not arrive, or arrived twice, is counted, and nothing else is."""

from __future__ import annotations

import random

from hypothesis import given
from hypothesis import strategies as st

from backend_clients.edge.fields import HEADER_IDS
from backend_clients.edge.topics import Up
from hmi.ingest import mailbox as mailbox_module
from hmi.ingest.arrivals import FAR_BACK, LATE_S, Count, Row
from tests.hmi.ingest.wire import FakeWireRobot, Rig

ID = "weeder-01"


def heard(rig: Rig, robot: FakeWireRobot, *numbers: int, boot: str | None = None) -> None:
    """Let states with these numbers arrive, one after another."""
    for number in numbers:
        rig.clock.advance(0.1)
        rig.say(robot.state(header_id=number, **({"boot": boot} if boot else {})))


def later(rig: Rig, seconds: float = LATE_S + 1) -> Count:
    """Return what is counted of states some time later."""
    rig.clock.advance(seconds)
    rig.edge.look_after()
    return rig.edge.arrivals.by_kind().get(Up.STATE, Count())


def told(count: Count) -> tuple[int, int, int, int]:
    """Return received, lost, twice, out of order."""
    return count.received, count.lost, count.twice, count.out_of_order


async def test_what_did_not_arrive_is_lost_after_some_seconds_and_counted_for_its_robot_and_kind() -> None:
    async with Rig(ID, "weeder-02") as rig:
        heard(rig, rig.robot(), 7, 8, 11, 12)
        heard(rig, rig.robot("weeder-02"), 1, 2)
        assert told(later(rig, LATE_S - 1)) == (6, 0, 0, 0)
        assert told(later(rig, 2)) == (6, 2, 0, 0)
        assert {robot: kinds[Up.STATE].lost for robot, kinds in rig.edge.arrivals.by_robot().items()} == {
            ID: 2,
            "weeder-02": 0,
        }


async def test_out_of_order_is_no_loss_and_a_repeat_is_counted_as_one() -> None:
    async with Rig(ID) as rig:
        heard(rig, rig.robot(), 1, 2, 5, 3, 4, 4, 6, 6)
        assert told(later(rig)) == (6, 0, 2, 2)


async def test_what_was_lost_and_comes_all_the_same_is_late_and_not_twice() -> None:
    async with Rig(ID) as rig:
        robot = rig.robot()
        heard(rig, robot, 1, 3)
        assert later(rig).lost == 1
        heard(rig, robot, 2)
        count = later(rig)
        assert (count.lost, count.late, count.twice, count.received) == (1, 1, 0, 3)


async def test_a_restart_and_a_wrap_around_are_no_loss() -> None:
    async with Rig(ID) as rig:
        robot = rig.robot()
        heard(rig, robot, HEADER_IDS - 2, HEADER_IDS - 1, 0, 1)
        heard(rig, robot, 0, 1, boot="boot-bbbb")
        heard(rig, robot, 2)  # of the last life
        heard(rig, robot, 2, 3, boot="boot-bbbb")
        assert told(later(rig)) == (9, 0, 0, 0)


async def test_a_restart_without_a_word_and_numbers_no_robot_can_have_reached_begin_anew() -> None:
    async with Rig(ID) as rig:
        robot = rig.robot()
        heard(rig, robot, FAR_BACK + 10, 0, 1, 2)
        heard(rig, robot, 10_000_000, 10_000_001)
        assert told(later(rig)) == (6, 0, 0, 0)


async def test_a_long_outage_of_the_way_is_counted_whole() -> None:
    async with Rig(ID) as rig:
        robot = rig.robot()
        heard(rig, robot, 1)
        rig.clock.advance(3 * 3600)
        heard(rig, robot, 21_602)
        assert later(rig).lost == 21_600


async def test_what_a_newer_one_replaced_here_and_what_had_no_room_is_no_loss_on_the_way() -> None:
    async with Rig(ID, fifo_limit=2) as rig:
        robot = rig.robot()
        heard(rig, robot, 1)
        for number in (2, 3, 4):
            rig.post(robot.state(header_id=number))
        for number in range(5):
            rig.post(robot.ack(header_id=number))
        rig.edge.drain()
        assert told(later(rig)) == (4, 0, 0, 0)
        assert rig.edge.tally.total["overflow"] == 3
        rig.say(robot.ack(header_id=5))
        later(rig)
        assert rig.edge.arrivals.by_kind()[Up.ACK].lost == 0


async def test_where_there_is_no_room_for_what_was_replaced_nothing_is_made_up(monkeypatch: object) -> None:
    was, mailbox_module.REPLACED_BYTES = mailbox_module.REPLACED_BYTES, 0
    try:
        async with Rig(ID) as rig:
            robot = rig.robot()
            heard(rig, robot, 1)
            for number in range(2, 50):
                rig.post(robot.state(header_id=number))
            rig.edge.drain()
            heard(rig, robot, 50)
            assert later(rig).lost == 0
    finally:
        mailbox_module.REPLACED_BYTES = was


async def test_robots_that_number_nothing_retained_copies_and_strangers_are_not_counted() -> None:
    async with Rig(ID) as rig:
        rig.say(rig.robot().state())
        rig.say(rig.robot().node(header_id=1), is_retained=True)
        rig.say(rig.robot("stranger-01").state(header_id=1))
        assert rig.edge.arrivals.by_kind() == {}


async def test_a_robot_that_is_taken_out_leaves_its_losses_in_the_total() -> None:
    async with Rig(ID) as rig:
        heard(rig, rig.robot(), 1, 3)
        assert later(rig).lost == 1
        rig.store.set_registry([])
        assert later(rig).lost == 1
        assert rig.edge.arrivals.by_robot() == {}


@given(st.integers(0, 2**32 - 1), st.lists(st.sampled_from(["one", "two", "lose", "swap"]), max_size=80), st.integers())
def test_each_number_is_received_or_lost_and_repeats_are_counted_apart(begin: int, fates: list[str], seed: int) -> None:
    rng, wire, twice, lost = random.Random(seed), [begin], 0, 0
    for ahead, fate in enumerate(fates, 1):
        number = (begin + ahead) % HEADER_IDS
        lost += fate == "lose"
        twice += fate == "two"
        wire += [number] * {"one": 1, "two": 2, "lose": 0, "swap": 1}[fate]
        if fate == "swap" and len(wire) > 2:
            place = rng.randrange(1, len(wire) - 1)
            wire[-1], wire[place] = wire[place], wire[-1]
    wire.append((begin + len(fates) + 1) % HEADER_IDS)
    row = Row()
    for at, number in enumerate(wire):
        row.take("boot-aaaa", number, at * 0.1)
    row.settle(float("inf"))
    assert (row.count.lost - row.count.late, row.count.twice) == (lost, twice)
    assert row.count.received == len(fates) + 2 - lost
