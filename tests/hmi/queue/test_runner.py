"""What the queue does by itself, and everything that keeps it from doing so."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta

import pytest

from hmi.commands import queue_runner
from hmi.commands.lease_service import LeaseOp
from hmi.commands.queue_book import EntryOrder
from hmi.commands.refusal import OrderRefused
from hmi.domain.mission import MissionStatus, Mover
from hmi.domain.mission_plan import MissionRefused
from hmi.domain.queue.entry import Entry
from hmi.domain.queue.facts import Facts
from hmi.domain.queue.repeat import Repeat, RepeatKind
from hmi.domain.queue.waiting import Verdict
from hmi.domain.robot import Mode, OrderStatus
from hmi.domain.role import Role
from hmi.store.errors import NotFound
from tests.hmi.commands.field import JONAS, person
from tests.hmi.queue.rig import EASY, MORNING, PIETER, QueueFarm

DAILY = Repeat(RepeatKind.DAILY)


async def test_the_queue_sends_its_first_mission_and_does_not_move_the_robot(farm: QueueFarm) -> None:
    first, second = await farm.add("wheat-1"), await farm.add("wheat-2")
    await farm.step(3)
    assert farm.weeder.holds == "wheat-1"
    assert farm.weeder.starts == []
    assert farm.status("wheat-1") == "accepted"
    assert farm.code(first) == "not_armed"
    assert farm.why(second) == "Waits for Wheat 1, before it in the queue."


async def test_an_armed_queue_drives_one_mission_after_the_other(farm: QueueFarm) -> None:
    await farm.add("wheat-1")
    await farm.add("wheat-2")
    await farm.step(2)
    await farm.arm()
    await farm.step(2)
    assert [o.mission_id for o in farm.weeder.starts] == ["wheat-1"]
    assert not farm.weeder.starts[0].is_supervised
    assert farm.weeder.starts[0].by == "Queue, armed by Pieter Bos until 11:00"
    farm.weeder.tell(OrderStatus.DONE)
    await farm.step(4)
    assert [o.mission_id for o in farm.weeder.starts] == ["wheat-1", "wheat-2"]
    farm.weeder.tell(OrderStatus.DONE)
    await farm.step(3)
    assert farm.queue.store.entries() == []
    assert [one.state.value for one in farm.queue.store.ended()] == ["done", "done"]


async def test_everybody_sees_that_the_queue_has_control(farm: QueueFarm) -> None:
    await farm.add("wheat-1")
    await farm.arm()
    lease = farm.desk.leases.of("weeder-01")
    assert lease is not None
    assert lease.holder.user_name == "Queue, armed by Pieter Bos until 11:00"
    await farm.step(60, stride_s=5)
    assert farm.desk.leases.of("weeder-01") == farm.desk.leases.of("weeder-01") is not None


async def test_an_attended_mission_is_sent_and_waits_for_the_person(farm: QueueFarm) -> None:
    entry, other = await farm.add("wheat-1", is_unattended=False), await farm.add("wheat-2")
    await farm.step(2)
    await farm.arm()
    await farm.step(30)
    assert farm.why(entry) == "Ready on Weeder 01. The person on site starts it with a slide."
    assert farm.code(other) == "not_first"
    assert farm.weeder.starts == []


async def test_an_entry_that_cannot_be_judged_holds_up_no_other_robot(
    farm: QueueFarm, monkeypatch: pytest.MonkeyPatch
) -> None:
    farm.put_robot("weeder-02", "Weeder 02")
    odd, good = await farm.add("wheat-1"), await farm.add("wheat-2", robot_id="weeder-02")
    await farm.step(2)
    await farm.arm()
    judge = queue_runner.why_waiting

    def judged(entry: Entry, facts: Facts) -> Verdict:
        if entry.id == odd.id:
            raise OverflowError("date value out of range")
        return judge(entry, facts)

    monkeypatch.setattr(queue_runner, "why_waiting", judged)
    await farm.step(3)
    assert farm.robot("weeder-02") is not None
    assert farm.code(good) == "not_armed", "its mission was sent and waits"
    assert farm.why(odd) == "Something is wrong with this queue; see the console's log."
    assert not farm.is_armed()
    assert farm.weeder.starts == []


async def test_arming_ends_at_its_time(farm: QueueFarm) -> None:
    await farm.add("wheat-1", earliest=MORNING + timedelta(minutes=30))
    await farm.arm(PIETER, 600.0)
    await farm.step(601, stride_s=8)
    assert not farm.is_armed()
    assert farm.disarmed() == "Its time was over at 10:10."
    assert farm.desk.leases.of("weeder-01") is None
    await farm.step(1300, stride_s=8)
    assert farm.weeder.starts == []


@pytest.mark.slow
@pytest.mark.parametrize("stop", ["gateway", "console"])
async def test_any_stop_of_the_robot_disarms_its_queue(farm: QueueFarm, stop: str) -> None:
    await farm.add("wheat-1")
    await farm.add("wheat-2")
    await farm.arm()
    await farm.step(3)
    if stop == "gateway":
        farm.press_stop("stop-1", "Vera Lang")
        await farm.look()
    else:
        farm.queue.stopped("weeder-01", "Vera Lang")
    assert farm.disarmed() == "Vera Lang pressed STOP."
    farm.weeder.presses.clear()
    farm.weeder.tell(OrderStatus.DONE)
    await farm.step(60, stride_s=5)
    assert len(farm.weeder.starts) == 1


async def test_stop_all_freezes_the_whole_queue_over_a_restart_until_a_person_releases_it(farm: QueueFarm) -> None:
    entry = await farm.add("wheat-1")
    await farm.arm()
    farm.queue.freeze.stop_all("stop-9", "Vera Lang")
    assert farm.disarmed() == "Vera Lang pressed STOP ALL."
    await farm.again()
    await farm.step(5)
    assert farm.why(entry) == "Frozen since STOP ALL by Vera Lang at 10:00. A person must release the queue."
    assert farm.weeder.holds is None
    with pytest.raises(OrderRefused, match="frozen"):
        await farm.arm()
    with pytest.raises(OrderRefused, match="Say why"):
        farm.queue.freeze.release(PIETER, " ", farm.ticks.issue().id)
    farm.queue.freeze.release(PIETER, "The dog is back on the lead", farm.ticks.issue().id)
    await farm.step(3)
    assert farm.weeder.holds == "wheat-1"
    assert not farm.is_armed()


async def test_a_press_on_several_robots_freezes_even_if_only_the_gateway_heard_it(farm: QueueFarm) -> None:
    farm.put_robot("weeder-02", "Weeder 02")
    await farm.add("wheat-1")
    farm.press_stop("stop-7", "Vera Lang", "weeder-01", "weeder-02")
    await farm.step(2)
    assert farm.queue.freeze.is_frozen
    farm.queue.freeze.release(PIETER, "All clear", farm.ticks.issue().id)
    await farm.step(2)
    assert not farm.queue.freeze.is_frozen  # the same press does not freeze again while robots still report it


@pytest.mark.parametrize("end", ["stopped", "killed"])
async def test_a_restart_of_the_console_disarms_everything(farm: QueueFarm, end: str) -> None:
    await farm.add("wheat-1", earliest=MORNING + timedelta(minutes=2))
    await farm.arm()
    await (farm.again() if end == "stopped" else farm.crash())
    assert not farm.is_armed()
    assert farm.disarmed() in ("The console was shut down.", "The console was restarted.")
    await farm.step(300, stride_s=8)
    assert farm.weeder.starts == []


async def test_a_robot_that_beats_but_does_not_say_what_it_does_is_not_started(farm: QueueFarm) -> None:
    entry = await farm.add("wheat-1", earliest=MORNING + timedelta(seconds=5))
    await farm.arm()
    farm.weeder.state_s = farm.clock.mono_s()
    await farm.step(20)
    assert farm.weeder.starts == []
    assert farm.code(entry) == "state_unknown"


@pytest.mark.parametrize("jump_s", [7200.0, -7200.0])
async def test_a_clock_that_jumps_disarms(farm: QueueFarm, jump_s: float) -> None:
    await farm.add("wheat-1", earliest=MORNING + timedelta(hours=2))
    await farm.arm(PIETER, 4 * 3600.0)
    await farm.step(2)
    farm.clock.jump_wall(jump_s)
    await farm.step(3)
    assert farm.disarmed() == "The console was held up, or its clock was set. Nothing starts late."
    assert farm.weeder.starts == []


async def test_a_console_that_was_frozen_for_a_minute_starts_nothing(farm: QueueFarm) -> None:
    await farm.add("wheat-1", earliest=MORNING + timedelta(seconds=30))
    await farm.arm()
    await farm.step(2)
    farm.clock.advance(60)
    farm.weeder.own_s += 60
    farm.weeder.beat()
    await farm.look()
    await farm.step(5)
    assert not farm.is_armed()
    assert farm.weeder.starts == []


async def test_any_change_of_the_queue_disarms_it(farm: QueueFarm) -> None:
    await farm.add("wheat-1", earliest=MORNING + timedelta(hours=1))
    await farm.arm()
    await farm.add("wheat-2")
    assert farm.disarmed() == "Pieter Bos changed the queue."
    await farm.step(5)
    assert farm.weeder.starts == []


async def test_a_queue_that_changed_since_it_was_shown_cannot_be_armed(farm: QueueFarm) -> None:
    await farm.add("wheat-1")
    seen = farm.queue.store.revision("weeder-01")
    await farm.add("wheat-2")
    with pytest.raises(OrderRefused, match="was changed"):
        await farm.queue.arming.arm(PIETER, {"weeder-01": seen}, 3600.0, farm.ticks.issue().id)


async def test_an_old_picture_arms_nothing(farm: QueueFarm) -> None:
    await farm.add("wheat-1")
    tick = farm.ticks.issue().id
    await farm.step(3)
    with pytest.raises(OrderRefused, match="stale_tick"):
        await farm.queue.arming.arm(PIETER, {"weeder-01": 1}, 3600.0, tick)


async def test_a_robot_that_may_not_run_alone_cannot_be_armed(farm: QueueFarm) -> None:
    farm.put_robot("weeder-02", "Weeder 02", is_unattended_allowed=False)
    entry = await farm.add("wheat-1", robot_id="weeder-02")
    await farm.step(3)
    assert farm.why(entry).startswith("Weeder 02 may not run without a person.")
    with pytest.raises(OrderRefused, match="may not run without a person"):
        await farm.arm(PIETER, 3600.0, "weeder-02")


async def test_a_supervised_mission_cannot_be_marked_to_start_by_itself(farm: QueueFarm) -> None:
    farm.put_mission("barley", "Barley", is_supervised=True)
    with pytest.raises(OrderRefused, match="Barley is supervised"):
        await farm.add("barley")


async def test_somebody_elses_control_is_not_taken_by_arming(farm: QueueFarm) -> None:
    await farm.add("wheat-1")
    farm.desk.leases.operate(JONAS, "weeder-01", LeaseOp.REQUEST, tick_id=farm.ticks.issue().id)
    with pytest.raises(OrderRefused, match="Jonas Weber has control"):
        await farm.arm()
    lease = farm.desk.leases.of("weeder-01")
    assert lease is not None
    assert lease.holder.user_name == "Jonas Weber"


async def test_asking_for_control_takes_it_from_the_queue_and_disarms(farm: QueueFarm) -> None:
    await farm.add("wheat-1", earliest=MORNING + timedelta(hours=1))
    await farm.arm()
    asked = farm.desk.leases.operate(JONAS, "weeder-01", LeaseOp.REQUEST, tick_id=farm.ticks.issue().id)
    assert asked.is_granted
    assert farm.disarmed() == "Jonas Weber took control."
    await farm.step(3)
    assert farm.weeder.starts == []


async def test_a_start_that_was_not_taken_is_never_repeated(farm: QueueFarm) -> None:
    await farm.add("wheat-1")
    await farm.step(2)
    farm.weeder.refuse_with = ("mission_too_far", "It is too far from the start.")
    await farm.arm()
    await farm.step(120, stride_s=8)
    assert len(farm.weeder.starts) == 1
    assert farm.disarmed() == "The start was not taken: It is too far from the start."


async def test_a_start_without_an_answer_is_never_repeated(farm: QueueFarm) -> None:
    await farm.add("wheat-1")
    await farm.step(2)
    await farm.arm()
    farm.weeder.is_silent = True
    await farm.step(120, stride_s=8)
    assert len(farm.weeder.starts) == 1
    assert not farm.is_armed()


async def test_a_mission_that_was_aborted_lets_nothing_follow(farm: QueueFarm) -> None:
    await farm.add("wheat-1")
    await farm.add("wheat-2")
    await farm.arm()
    await farm.step(3)
    farm.weeder.tell(OrderStatus.ABORTED)
    await farm.step(60, stride_s=5)
    assert farm.disarmed() == "Wheat 1: the mission was aborted."
    assert len(farm.weeder.starts) == 1


async def test_a_paused_mission_is_not_resumed_by_the_queue(farm: QueueFarm) -> None:
    entry = await farm.add("wheat-1")
    await farm.arm()
    await farm.step(3)
    farm.weeder.tell(OrderStatus.PAUSED, Mode.PAUSED)
    await farm.step(60, stride_s=5)
    assert farm.code(entry) == "paused"
    assert len(farm.weeder.orders) == 1


async def test_a_silent_robot_is_not_started(farm: QueueFarm) -> None:
    entry = await farm.add("wheat-1")
    await farm.step(2)
    await farm.arm()
    farm.weeder.heard_s = farm.clock.mono_s() - 3
    await farm.look()
    assert farm.code(entry) == "no_link"
    assert farm.weeder.starts == []


async def test_who_armed_and_lost_the_right_since_starts_nothing(farm: QueueFarm) -> None:
    await farm.add("wheat-1")
    await farm.arm()
    await farm.database.run(farm.kept.users.change, FARM_ID, "pieter", role=Role.VIEWER)
    await farm.step(5)
    assert farm.disarmed() == "Pieter Bos may not start robots any more."
    assert farm.weeder.starts == []


async def test_a_missed_time_is_not_made_up_for(farm: QueueFarm) -> None:
    entry = await farm.add("wheat-1", earliest=MORNING + timedelta(minutes=5))
    await farm.step(5 * 60 + 901, stride_s=8)
    await farm.arm()
    await farm.step(30)
    assert farm.code(entry) == "missed"
    assert farm.weeder.starts == []


async def test_a_repeating_job_that_missed_its_day_comes_the_next_day_and_never_in_a_burst(farm: QueueFarm) -> None:
    entry = await farm.add("wheat-1", earliest=MORNING + timedelta(minutes=5), repeat=DAILY)
    farm.clock.advance(3 * 86_400)
    await farm.step(2)
    [left] = farm.queue.store.entries()
    assert left.id == entry.id
    assert left.earliest == MORNING + timedelta(days=3, minutes=5)


async def test_a_repeating_job_comes_again_as_a_copy_of_its_mission(farm: QueueFarm) -> None:
    await farm.add("wheat-1", earliest=MORNING, repeat=DAILY)
    await farm.arm()
    await farm.step(3)
    farm.weeder.tell(OrderStatus.DONE)
    await farm.step(3)
    [entry] = farm.queue.store.entries()
    copy = farm.missions.known(entry.mission_id)
    assert copy is not None
    assert copy.name == "Wheat 1, Tue 16 Jun"
    assert copy.status.value == "queued"
    assert entry.earliest == MORNING + timedelta(days=1)
    assert farm.status("wheat-1") == "done"
    assert farm.is_armed()  # the same queue goes on: a person ordered it to repeat


async def test_a_mission_a_person_put_on_the_robot_is_not_replaced(farm: QueueFarm) -> None:
    await farm.desk.missions.send(PIETER, "weeder-01", "wheat-3")
    await farm.step(2)
    entry = await farm.add("wheat-1")
    await farm.arm()
    await farm.step(20)
    assert farm.code(entry) == "holds_other"
    assert farm.weeder.holds == "wheat-3"


async def test_a_mission_that_cannot_be_sent_is_tried_again_later(farm: QueueFarm) -> None:
    entry = await farm.add("wheat-1")
    farm.weeder.refuse_with = ("storage_full", "No room.")
    await farm.step(2)
    assert farm.why(entry) == "Not sent: No room. Tries again at 10:00:31."
    farm.weeder.refuse_with = None
    await farm.step(32)
    assert farm.weeder.holds == "wheat-1"


async def test_a_person_may_disarm_without_being_an_operator(farm: QueueFarm) -> None:
    await farm.add("wheat-1", earliest=MORNING + timedelta(hours=1))
    await farm.arm()
    farm.queue.arming.disarm(person("Vera Lang", Role.VIEWER), ["weeder-01"])
    assert farm.disarmed() == "Vera Lang disarmed it."


FARM_ID = "farm"


async def test_a_mission_is_sent_once_while_the_robot_takes_its_time_to_tell(farm: QueueFarm) -> None:
    await farm.add("wheat-1")
    farm.clock.advance(1)
    farm.weeder.own_s += 1
    farm.weeder.beat()
    await farm.look()
    held, farm.weeder.mission = farm.weeder.mission, None
    await farm.step(3)
    assert farm.kept.audit.outcomes("mission") == ["accepted"]
    farm.weeder.mission = held
    await farm.step(2)
    assert farm.status("wheat-1") == "accepted"


async def test_a_mission_taken_out_of_the_queue_can_be_deleted_and_one_in_it_cannot(farm: QueueFarm) -> None:
    await farm.add("wheat-1")
    entry = await farm.add("wheat-2")
    planner = person("Piet Plan", Role.PLANNER)
    with pytest.raises(MissionRefused, match="Take it out there first"):
        await farm.book.delete(planner, "wheat-2")
    await farm.queue.book.remove(PIETER, entry.id)
    await farm.book.delete(planner, "wheat-2")
    assert farm.missions.known("wheat-2") is None


async def test_what_a_person_changes_while_the_queue_writes_is_not_overwritten(farm: QueueFarm) -> None:
    entry = await farm.add("wheat-1")
    windy = replace(EASY, wind_below_mps=4.0)
    await farm.queue.book.change(PIETER, entry.id, EntryOrder(is_unattended=True, conditions=windy))
    # the queue notes a start with what it read before
    farm.queue.store.write(amended={entry.id: {"started_at": MORNING}})
    kept = farm.queue.store.get(entry.id)
    assert (kept.conditions.wind_below_mps, kept.started_at) == (4.0, MORNING)
    await farm.queue.book.remove(PIETER, entry.id)
    with pytest.raises(NotFound):
        farm.queue.store.write(amended={entry.id: {"started_at": MORNING}})


async def test_a_mission_left_in_line_without_a_place_is_given_back_at_the_start(farm: QueueFarm) -> None:
    farm.missions.move(FARM_ID, "wheat-1", MissionStatus.QUEUED, Mover.PERSON, "Pieter Bos")
    await farm.crash()
    assert farm.status("wheat-1") == "validated"
