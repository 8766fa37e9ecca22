"""Many at once: bursts, floods, a lost broker, a storm of reconnects. One cause stays one line."""

from __future__ import annotations

import random

import pytest

from backend_clients.edge import messages_up as up
from hmi.domain.alarm.alarm import CONSOLE, AlarmKey
from hmi.domain.alarm.conditions import MAX_AT_SOURCE, Change, Turn
from hmi.domain.alarm.finding import NOTHING, Finding
from hmi.domain.alarm.live_alarm import What
from hmi.ingest.supervision.watch import ROBOTS_A_STEP
from hmi.store.alarms import MAX_ALARMS
from tests.hmi.alarms.rig import MARTHA, AlarmRig

FLEET = tuple(f"weeder-{number:04d}" for number in range(300))
BROKER = (Finding("broker-lost", "Not connected."),)


@pytest.mark.slow
async def test_a_lost_broker_is_one_alarm_and_not_hundreds_of_lost_links() -> None:
    async with AlarmRig(*FLEET) as rig:
        rig.run(2, *FLEET)
        rig.watch.report(CONSOLE, "console", BROKER)
        rig.run(12)
        assert rig.states() == {"broker-lost.console": "unacknowledged"}
        rig.watch.report(CONSOLE, "console", NOTHING)
        rig.run(7, *FLEET)
        assert rig.states() == {"broker-lost.console": "returned"}
        assert len(rig.steps) == 2


async def test_a_robot_that_does_not_come_back_with_the_broker_is_told_then() -> None:
    async with AlarmRig("weeder-01", "weeder-02") as rig:
        rig.run(2, "weeder-01", "weeder-02")
        rig.watch.report(CONSOLE, "console", BROKER)
        rig.run(20)
        rig.watch.report(CONSOLE, "console", NOTHING)
        rig.run(12, "weeder-02")
        assert rig.states() == {"broker-lost.console": "returned", "link-lost.weeder-01": "unacknowledged"}


async def test_a_link_lost_before_the_broker_is_kept_silent_and_speaks_again_afterwards() -> None:
    async with AlarmRig("weeder-01", "weeder-02") as rig:
        rig.run(2, "weeder-01", "weeder-02")
        rig.run(8, "weeder-02")
        assert rig.states() == {"link-lost.weeder-01": "unacknowledged"}
        rig.watch.report(CONSOLE, "console", BROKER)
        rig.run(5)
        assert rig.states()["link-lost.weeder-01"] == "suppressed"
        rig.watch.report(CONSOLE, "console", NOTHING)
        rig.run(12, "weeder-02")
        assert rig.states()["link-lost.weeder-01"] == "unacknowledged"


@pytest.mark.slow
async def test_robots_that_all_fall_silent_at_once_are_one_alarm_about_the_network() -> None:
    async with AlarmRig(*FLEET[:100]) as rig:
        rig.run(3, *FLEET[:100])
        rig.run(20)
        assert rig.states() == {"all-silent.console": "unacknowledged"}
        rig.run(15, *FLEET[:100])
        assert rig.states() == {"all-silent.console": "returned"}


async def test_when_the_network_is_back_those_still_silent_are_told_one_by_one() -> None:
    fleet = FLEET[:10]
    async with AlarmRig(*fleet) as rig:
        rig.run(3, *fleet)
        rig.run(10)
        assert rig.states() == {"all-silent.console": "unacknowledged"}
        rig.run(12, *fleet[:3])  # fewer than half of them, and the network carries them
        assert rig.states()["all-silent.console"] == "returned"
        assert {one for one in rig.states() if one != "all-silent.console"} == {f"link-lost.{one}" for one in fleet[3:]}
        rig.run(6, *fleet[:3], *fleet[4:])
        assert {rig.states()[f"link-lost.{one}"] for one in fleet[4:]} == {"returned"}


async def test_robots_that_went_off_together_and_stay_off_hide_no_loss_of_those_at_work() -> None:
    shed, field = FLEET[:10], FLEET[10:12]
    async with AlarmRig(*shed, *field) as rig:
        rig.run(3, *shed)
        rig.run(70, *field)  # the shed's switch was thrown; two others work, too few to prove a network
        assert rig.states() == {"all-silent.console": "unacknowledged"}
        rig.run(12, field[0])
        assert rig.states()["all-silent.console"] == "returned"
        assert rig.states()[f"link-lost.{field[1]}"] == "unacknowledged"


async def test_robots_taken_out_of_the_registry_are_not_waited_for() -> None:
    async with AlarmRig(*FLEET[:4]) as rig:
        rig.run(3, *FLEET[:4])
        rig.run(10)
        rig.store.set_registry([])
        rig.run(8)
        assert rig.states() == {"all-silent.console": "returned"}


async def test_two_of_many_robots_that_fall_silent_are_two_alarms() -> None:
    async with AlarmRig(*FLEET[:10]) as rig:
        rig.run(3, *FLEET[:10])
        rig.run(8, *FLEET[:8])
        assert set(rig.states()) == {f"link-lost.{one}" for one in FLEET[8:10]}


@pytest.mark.slow
async def test_a_storm_of_reconnects_raises_nothing_new_and_chatters_instead_of_repeating() -> None:
    async with AlarmRig(*FLEET[:50]) as rig:
        rig.run(3, *FLEET[:50])
        for _ in range(6):
            rig.run(6, *FLEET[:25])  # half of them fall silent and come back, six times in a minute and a half
            rig.run(6, *FLEET[:50])
        raised = [step for step in rig.steps if step.what is What.RAISED]
        assert {step.live.alarm.key.source for step in raised} == set(FLEET[25:50])
        assert len(rig.alarms.all()) == 25
        assert all(one.alarm.key.code == "link-lost" for one in rig.alarms.all())


async def test_five_hundred_alarms_in_ten_seconds_stand_under_what_came_first_and_are_called_a_flood() -> None:
    async with AlarmRig() as rig:
        story = []
        for number in range(125):
            source, begun_s = f"weeder-{number:03d}", rig.clock.mono_s() + number * 0.08
            for code, after_s in (
                ("link-lost", 0.0),
                ("values-old", 0.4),
                ("stop-not-confirmed", 0.9),
                ("stalled", 1.5),
            ):
                story.append((source, code, begun_s + after_s))
        rig.clock.advance(12)
        random.Random(7).shuffle(story)  # they are noticed in any order
        for source, code, since_s in story:
            rig.alarms.apply([Change(Turn.COMES, AlarmKey(code, source), Finding(code, since_s=since_s))])
        flood = rig.alarms.flood()
        assert flood is not None
        assert flood[1] == 500
        assert len(rig.alarms.all()) == 500
        for one in rig.alarms.all():
            assert one.first == f"link-lost.{one.alarm.key.source}"
            assert one.group == 4
            assert (one.place == 1) == (one.alarm.key.code == "link-lost")
        rig.clock.advance(601)
        rig.round()
        assert rig.alarms.flood() is None


async def test_ten_thousand_messages_of_a_raging_robot_leave_its_newest_state_and_little_else() -> None:
    async with AlarmRig("weeder-01") as rig:
        rig.run(1, "weeder-01")
        robot = rig.wire()
        for number in range(10_000):
            fault = up.Fault(code=f"rage-{number % 700}", level="high", text=f"Rage {number}.", hint="")
            rig.post(robot.state(faults=[fault]))
        rig.edge.drain()
        assert [one.alarm.text for one in rig.alarms.all() if one.alarm.is_active] == ["Rage 9999."]
        assert len(rig.alarms.all()) <= MAX_AT_SOURCE
        assert len(rig.steps) <= 4


async def test_a_robot_that_invents_codes_without_end_fills_neither_list_nor_memory() -> None:
    async with AlarmRig("weeder-01") as rig:
        rig.run(1, "weeder-01")
        for number in range(2000):
            event = rig.wire().event(event_id=f"event-{number:06d}", kind="alarm_raised", name=f"rage-{number}",
                                     text="Rage.", data={"code": f"rage-{number}", "level": "critical"})  # fmt: skip
            rig.edge.listeners.on_event = [rig.watch.see_event]
            rig.say(event)
        assert len(rig.alarms.all()) <= MAX_AT_SOURCE


async def test_a_robot_full_of_faults_leaves_room_for_a_stop_that_is_not_confirmed_and_says_what_it_left_out() -> None:
    async with AlarmRig("weeder-01") as rig:
        rig.run(1, "weeder-01")
        faults = [up.Fault(code=f"rage-{number}", level="high", text="Rage.", hint="") for number in range(64)]
        rig.say(rig.wire().state(faults=faults))
        rig.say(rig.wire().node(name="planner", state="failure", text="exit 139"))
        rig.watch.report("weeder-01", "stop", (Finding("stop-not-confirmed", "Martha pressed STOP."),))
        rig.run(8)
        assert {"stop-not-confirmed.weeder-01", "link-lost.weeder-01"} < rig.states().keys()
        assert "node-failed.weeder-01.planner" not in rig.states()
        assert rig.conditions.dropped == 1
        urgent = up.Fault(code="fire", level="critical", text="It burns.", hint="")
        rig.say(rig.wire().state(faults=[*faults[:63], urgent]))
        assert "robot-fault.weeder-01.fire" in rig.states()


@pytest.mark.slow
async def test_the_list_ends_somewhere_and_counts_what_found_no_room() -> None:
    async with AlarmRig() as rig:
        for number in range(MAX_ALARMS + 5):
            rig.alarms.apply([Change(Turn.COMES, AlarmKey("link-lost", f"r-{number}"), Finding("link-lost"))])
        assert len(rig.alarms.all()) == MAX_ALARMS
        assert rig.alarms.dropped == 5
        for code, source in (("stop-not-confirmed", "r-1"), ("disk-full", CONSOLE)):
            rig.alarms.apply([Change(Turn.COMES, AlarmKey(code, source), Finding(code))])
            assert rig.alarms.find(AlarmKey(code, source).id) is not None
        for seen in ("r-1", "r-2", "r-3"):
            rig.alarms.acknowledge(f"link-lost.{seen}", MARTHA)
        for gone in ("r-1", "r-2", "r-3", f"r-{MAX_ALARMS}"):  # the last of them was never listed
            rig.alarms.apply([Change(Turn.GOES, AlarmKey("link-lost", gone), Finding("link-lost"))])
        rig.round()
        assert rig.alarms.find(f"link-lost.r-{MAX_ALARMS}") is None
        assert rig.alarms.find(f"link-lost.r-{MAX_ALARMS + 1}") is not None
        assert len(rig.alarms.all()) == MAX_ALARMS
        assert rig.alarms.dropped == 5


async def test_an_alarm_that_comes_and_goes_all_the_time_is_held_until_it_was_quiet() -> None:
    async with AlarmRig("weeder-01") as rig:
        rig.run(1, "weeder-01")
        nozzle = up.Fault(code="nozzle", level="low", text="Nozzle is blocked.", hint="")
        for _ in range(20):
            rig.say(rig.wire().state(faults=[nozzle]))
            rig.run(1, "weeder-01")
            rig.say(rig.wire().state())
            rig.run(1, "weeder-01")
        assert rig.one("robot-fault.weeder-01.nozzle").is_chattering
        assert sum(step.what is What.RAISED for step in rig.steps) == 3
        rig.run(62, "weeder-01")
        assert rig.states() == {"robot-fault.weeder-01.nozzle": "returned"}
        assert not rig.one("robot-fault.weeder-01.nozzle").is_chattering


async def test_a_round_over_hundreds_of_robots_lets_others_have_the_loop_and_misses_no_alarm() -> None:
    many = [f"weeder-{n:03d}" for n in range(2 * ROBOTS_A_STEP + 50)]
    async with AlarmRig(*many) as rig:
        for robot_id in many:
            rig.beat(robot_id)
        rig.clock.advance(60.0)
        rig.edge.look_after()
        steps = sum(1 for _ in rig.watch.sweeping())
        assert steps == 2
        rig.clock.advance(10.0)
        for _ in rig.watch.sweeping():
            pass
        assert rig.alarms.all(), "they are silent"
