"""Clips around STOPs and alarms, pictures of missions: what is held open, what is cut, and nothing when all is well."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from hmi.commands.camera_ports import Clip
from hmi.domain.alarm.alarm import Alarm, AlarmKey
from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.alarm.live_alarm import LiveAlarm, Step, What
from hmi.domain.alarm.priority import Priority
from hmi.domain.picture import Picture, PictureKind
from hmi.domain.robot import Mode, OrderStatus
from hmi.store.pictures import PictureFilter
from tests.hmi.commands.field import FARM
from tests.hmi.pictures.conftest import MakeRig
from tests.hmi.pictures.jpeg import picture
from tests.hmi.pictures.rig import WEEDER, PictureRig

FRONT, REAR = (WEEDER, "front"), (WEEDER, "rear")
TYPES = dict(catalogue())
LATE = "Recorded from 45 s before it."
VIDEO = b"\x00\x00\x00\x18ftypmp42" + b"v" * 500


def alarm(
    rig: PictureRig, code: str = "link-lost", *, what: What = What.RAISED, level: Priority | None = None,
    detail: str = "",
) -> Step:  # fmt: skip
    """Return a step of an alarm of the weeder."""
    key = AlarmKey(code, WEEDER, detail)
    one = replace(Alarm(key, is_latching=False), text="Nothing heard for 4 s.", priority=level)
    return Step(what, LiveAlarm(one, TYPES[code], rig.clock.mono_s()), rig.clock.utc())


async def pictures(rig: PictureRig, *kinds: PictureKind) -> list[Picture]:
    """Return what was kept, newest first, once all that was begun is done."""
    await rig.settled()
    return await rig.records.database.run(rig.records.pictures.some, FARM, PictureFilter(kinds=kinds), 100)


async def test_nothing_is_asked_of_the_camera_process_while_nothing_happens(make_rig: MakeRig) -> None:
    rig = await make_rig(record_cameras="watched")
    rig.stand(row=3, speed_mps=1.0)
    rig.latch()
    await rig.seconds(120)
    assert (rig.cameras.told, rig.cameras.cut, rig.cameras.asked) == ([], [], [])


async def test_what_somebody_looks_at_keeps_its_last_minute_for_as_long(make_rig: MakeRig) -> None:
    rig = await make_rig(record_cameras="watched")
    rig.cameras.watching = [REAR]
    await rig.seconds(3)
    assert rig.cameras.held == (REAR,)
    rig.cameras.watching = []
    await rig.seconds(3)
    assert rig.cameras.held == ()


async def test_a_stop_opens_one_camera_and_leaves_a_clip_of_each_that_was_recording(make_rig: MakeRig) -> None:
    rig = await make_rig(record_cameras="watched")
    rig.cameras.kept = {FRONT: VIDEO, REAR: VIDEO}
    rig.stand(row=3)
    pressed_s, pressed = rig.clock.mono_s(), rig.clock.utc()
    rig.recorder.stopped(WEEDER, "Martha Keller")
    await rig.recorder.round()
    assert rig.cameras.held == (FRONT,)
    await rig.seconds(16)
    assert rig.cameras.held == ()
    assert sorted(rig.cameras.cut) == [
        (WEEDER, "front", pressed_s - 60, pressed_s + 15), (WEEDER, "rear", pressed_s - 60, pressed_s + 15)
    ]  # fmt: skip
    clips = await pictures(rig)
    assert sorted(one.camera for one in clips) == ["front", "rear"]
    for one in clips:
        assert (one.kind, one.text, one.duration_s) == (PictureKind.CLIP, f"Martha Keller pressed STOP. {LATE}", 60.0)
        assert (one.captured_at - pressed).total_seconds() == pytest.approx(-45.0, abs=0.01)
        assert (one.moment.row, one.moment.mission_name, one.moment.lat_deg) == (3, "Home field, all rows", 51.5)
    assert {event["what"] for event in rig.events} == {"kept"}


async def test_a_clip_of_a_camera_that_tells_no_time_says_so(rig: PictureRig) -> None:
    rig.cameras.kept, rig.cameras.is_dated = {FRONT: VIDEO}, False
    rig.recorder.stopped(WEEDER, "Martha Keller")
    await rig.seconds(20)
    (clip,) = await pictures(rig)
    assert clip.text.endswith("The camera tells no time: times are of arrival.")


async def test_a_clip_over_a_change_of_its_source_is_two_clips_that_say_so(rig: PictureRig) -> None:
    rig.cameras.kept = {FRONT: VIDEO}
    rig.cameras.changed_s = rig.clock.mono_s() - 20.0
    rig.recorder.stopped(WEEDER, "Martha Keller")
    await rig.seconds(20)
    new, old = sorted(await pictures(rig), key=lambda one: one.captured_at, reverse=True)
    assert "source was changed 20 s before it: this is the new one." in new.text
    assert old.text.startswith("Martha Keller pressed STOP. This is from the camera's source before it was changed.")
    assert (old.cause, new.cause) == ("stop", "stop")
    assert (old.captured_at.timestamp() + (old.duration_s or 0)) < new.captured_at.timestamp()


async def test_press_and_the_robots_word_for_it_are_one_incident_that_is_found_by_the_press(rig: PictureRig) -> None:
    rig.cameras.kept = {FRONT: VIDEO}
    rig.latch()
    rig.recorder.stopped(WEEDER, "Martha Keller")
    await rig.seconds(1)
    rig.latch("stop-0001")
    await rig.seconds(20)
    (clip,) = await pictures(rig)
    assert clip.cause == "stop stop.stop-0001"
    assert clip.text == "Martha Keller pressed STOP. Recorded from 44 s before it."
    found = await rig.records.database.run(rig.records.pictures.some, FARM, PictureFilter(cause="stop.stop-0001"), 9)
    assert [one.id for one in found] == [clip.id]
    none = await rig.records.database.run(rig.records.pictures.some, FARM, PictureFilter(cause="stop.stop-000"), 9)
    assert none == []


async def test_a_stop_at_the_machine_leaves_a_clip_and_one_that_was_there_before_does_not(rig: PictureRig) -> None:
    rig.cameras.kept = {FRONT: VIDEO}
    rig.latch(hardware=True)
    await rig.seconds(20)
    assert rig.cameras.cut == []
    rig.latch()
    rig.latch(hardware=True)
    await rig.seconds(20)
    (clip,) = await pictures(rig)
    assert clip.text == f"The STOP button on the machine. {LATE}"


async def test_alarms_that_come_together_make_one_clip_that_names_them(rig: PictureRig) -> None:
    rig.cameras.kept = {FRONT: VIDEO}
    rig.recorder.alarm(alarm(rig))
    await rig.seconds(10)
    rig.recorder.alarm(alarm(rig, "disk-full"))
    rig.recorder.alarm(alarm(rig, what=What.ACKNOWLEDGED))
    await rig.seconds(10)
    assert rig.cameras.cut == []
    await rig.seconds(6)
    (clip,) = await pictures(rig)
    assert clip.cause == f"alarm.link-lost.{WEEDER} alarm.disk-full.{WEEDER}"
    assert clip.text.count("Nothing heard for 4 s.") == 2


@pytest.mark.parametrize("level", [Priority.MEDIUM, Priority.HIGH])
async def test_a_stop_after_many_alarms_is_in_its_clip_with_what_it_led_to(rig: PictureRig, level: Priority) -> None:
    rig.cameras.kept = {FRONT: VIDEO}
    began_s = rig.clock.mono_s()
    for number in range(9):
        rig.recorder.alarm(alarm(rig, "node-failed", level=level, detail=f"n-{number}"))
    await rig.seconds(14)
    rig.recorder.stopped(WEEDER, "Martha Keller")
    rig.latch()
    rig.latch("stop-4711")
    await rig.seconds(16)
    (clip,) = await pictures(rig)
    assert "Martha Keller pressed STOP." in clip.text
    assert "stop.stop-4711" in clip.cause.split()
    assert clip.cause.startswith(f"alarm.node-failed.{WEEDER}.n-0 ")
    assert (WEEDER, "front", began_s - 60, began_s + 14 + 15) in rig.cameras.cut


async def test_an_incident_that_goes_on_is_cut_before_the_camera_process_forgets_its_beginning(rig: PictureRig) -> None:
    rig.cameras.kept = {FRONT: VIDEO}
    for number in range(20):
        rig.latch()
        rig.latch(f"stop-{number:04}")
        await rig.seconds(5)
    await rig.seconds(20)
    assert len(await pictures(rig)) == 3
    assert all(to - begin <= 105 for _robot, _camera, begin, to in rig.cameras.cut)


@pytest.mark.parametrize(("level", "is_opened"), [(Priority.HIGH, True), (Priority.MEDIUM, False)])
async def test_only_urgent_alarms_open_a_camera_that_nobody_watches(
    make_rig: MakeRig, level: Priority, *, is_opened: bool
) -> None:
    rig = await make_rig(record_cameras="watched")
    rig.recorder.alarm(alarm(rig, level=level))
    await rig.seconds(2)
    assert (rig.cameras.held == (FRONT,)) is is_opened
    await rig.seconds(20)
    assert [one[1] for one in rig.cameras.cut] == ["front", "rear"]


async def test_a_robot_that_drives_keeps_its_last_minute_until_it_stands(make_rig: MakeRig) -> None:
    rig = await make_rig(record_cameras="driving")
    rig.stand(speed_mps=0.8)
    await rig.recorder.round()
    assert rig.cameras.held == (FRONT,)
    rig.stand()
    await rig.recorder.round()
    assert rig.cameras.held == ()


async def test_no_more_cameras_are_held_than_allowed_and_incidents_come_first(make_rig: MakeRig) -> None:
    rig = await make_rig(record_cameras="driving", record_most=2)
    weeder = rig.fleet.robots[WEEDER]
    for number in range(5):
        rig.fleet.robots[f"w{number}"] = replace(weeder, id=f"w{number}")
        rig.stand(speed_mps=1.0)
        rig.recorder.see(replace(rig.fleet.robots[WEEDER], id=f"w{number}"))
        rig.clock.advance(1)
    assert rig.recorder.wanted() == (FRONT, ("w0", "front"))
    rig.recorder.stopped("w4", "Martha Keller")
    assert rig.recorder.wanted() == (("w4", "front"), FRONT)


@pytest.mark.parametrize(("is_demo", "most"), [(False, 16), (True, 4)])
async def test_a_whole_fleet_keeps_what_leads_to_a_stop_without_any_setting(
    make_rig: MakeRig, most: int, *, is_demo: bool
) -> None:
    rig = await make_rig(record_cameras="driving", demo=is_demo)
    rig.stand(speed_mps=1.0)
    weeder = rig.fleet.robots[WEEDER]
    for number in range(20):
        rig.fleet.robots[f"w{number}"] = replace(weeder, id=f"w{number}")
        rig.recorder.see(replace(rig.fleet.robots[WEEDER], id=f"w{number}"))
    assert len(rig.recorder.wanted()) == most


async def test_who_is_driven_by_hand_is_held_before_those_that_drive_longer(make_rig: MakeRig) -> None:
    rig = await make_rig(record_cameras="driving", record_most=1)
    rig.stand(speed_mps=1.0)
    rig.recorder.see(rig.fleet.robots[WEEDER])
    rig.clock.advance(1)
    state = rig.fleet.robots[WEEDER].state
    assert state is not None
    other = replace(rig.fleet.robots[WEEDER], id="w1", state=replace(state, mode=Mode.MANUAL))
    rig.fleet.robots["w1"] = other
    rig.recorder.see(other)
    assert rig.recorder.wanted() == (("w1", "front"),)
    rig.recorder.see(replace(other, state=state))
    assert rig.recorder.wanted() == (FRONT,)


@pytest.mark.parametrize(
    ("begins_s", "told"),
    [
        (0.0, ""),
        (40.0, " Recorded from 20 s before it."),
        (63.0, " Recorded from 3 s after it."),
    ],
)
async def test_a_clip_that_begins_late_says_from_when_it_is(
    rig: PictureRig, monkeypatch: pytest.MonkeyPatch, begins_s: float, told: str
) -> None:
    rig.cameras.kept = {FRONT: VIDEO}
    plain = rig.cameras.clip

    async def late(robot_id: str, camera: str, from_s: float, to_s: float, path: Path) -> Clip:
        return replace(await plain(robot_id, camera, from_s, to_s, path), begins_s=from_s + begins_s)

    monkeypatch.setattr(rig.cameras, "clip", late)
    rig.recorder.stopped(WEEDER, "Martha Keller")
    await rig.seconds(20)
    (clip,) = await pictures(rig)
    assert clip.text == f"Martha Keller pressed STOP.{told}"


@pytest.mark.parametrize(
    ("ends_s", "told"),
    [
        (0.0, ""),
        (-4.0, ""),
        (-7.0, " Recorded until 8 s after it."),
        (-40.0, " Recorded until 25 s before it."),
    ],
)
async def test_a_clip_that_ends_early_says_until_when_it_is(
    rig: PictureRig, monkeypatch: pytest.MonkeyPatch, ends_s: float, told: str
) -> None:
    rig.cameras.kept = {FRONT: VIDEO}
    plain = rig.cameras.clip

    async def short(robot_id: str, camera: str, from_s: float, to_s: float, path: Path) -> Clip:
        clip = await plain(robot_id, camera, from_s, to_s, path)
        return replace(clip, begins_s=from_s, ends_s=to_s + ends_s)

    monkeypatch.setattr(rig.cameras, "clip", short)
    rig.recorder.stopped(WEEDER, "Martha Keller")
    await rig.seconds(20)
    (clip,) = await pictures(rig)
    assert clip.text == f"Martha Keller pressed STOP.{told}"


async def test_a_camera_process_that_comes_back_is_told_again(rig: PictureRig) -> None:
    rig.stand(speed_mps=1.0)
    rig.cameras.is_away = True
    await rig.seconds(3)
    rig.cameras.is_away = False
    await rig.seconds(1)
    assert rig.cameras.held == (FRONT,)
    rig.cameras.held = ()
    await rig.seconds(11)
    assert rig.cameras.held == (FRONT,)


async def test_below_the_floor_of_the_disk_no_camera_is_held(rig: PictureRig) -> None:
    rig.stand(speed_mps=1.0)
    await rig.seconds(1)
    rig.free_bytes = 0
    await rig.shelf.sweep()
    await rig.seconds(1)
    assert rig.cameras.held == ()


async def test_off_records_nothing_whatever_happens(make_rig: MakeRig) -> None:
    rig = await make_rig(record_cameras="off")
    rig.stand(speed_mps=1.0)
    rig.recorder.stopped(WEEDER, "Martha Keller")
    rig.recorder.alarm(alarm(rig))
    await rig.seconds(30)
    assert (rig.cameras.told, rig.cameras.cut) == ([], [])


@pytest.mark.parametrize(
    "spoil", [lambda rig: rig.cameras.kept.clear(), lambda rig: setattr(rig.cameras, "is_away", True)]
)
async def test_a_clip_that_cannot_be_had_leaves_nothing_behind(
    rig: PictureRig, spoil: Callable[[PictureRig], None]
) -> None:
    rig.cameras.kept = {FRONT: VIDEO}
    rig.recorder.stopped(WEEDER, "Martha Keller")
    spoil(rig)
    await rig.seconds(20)
    assert await pictures(rig) == []
    assert not list((rig.folder / "pictures/incoming").iterdir())


async def test_the_end_of_each_row_leaves_a_picture_of_that_row_and_its_mission(rig: PictureRig) -> None:
    rig.show()
    for row in (1, 2, 2, 3):
        rig.stand(row=row)
        await rig.settled()
        rig.clock.advance(30)
    rig.stand(row=3, status=OrderStatus.DONE)
    found = await pictures(rig, PictureKind.MISSION)
    assert [one.text for one in found] == ["End of the mission.", "End of row 2.", "End of row 1."]
    assert [one.moment.row for one in found] == [3, 2, 1]
    assert {(one.moment.mission_id, one.moment.mission_name) for one in found} == {("m-1", "Home field, all rows")}


async def test_short_rows_do_not_leave_a_picture_every_second(rig: PictureRig) -> None:
    rig.show()
    for row in range(1, 60):
        rig.stand(row=row)
        await pictures(rig)
        rig.clock.advance(2)
    assert len(await pictures(rig, PictureKind.MISSION)) == 6


async def test_every_few_minutes_instead_of_rows(make_rig: MakeRig) -> None:
    rig = await make_rig(mission_pictures="minutes", mission_picture_minutes=5)
    rig.show()
    for _ in range(60):
        rig.stand(row=1)
        await pictures(rig)
        rig.clock.advance(10)
    assert len(await pictures(rig, PictureKind.MISSION)) == 2


async def test_pictures_of_missions_open_no_camera_where_only_watched_ones_are_kept(make_rig: MakeRig) -> None:
    rig = await make_rig(record_cameras="watched")
    rig.show(data=picture())
    rig.stand(row=1)
    rig.stand(row=2)
    await pictures(rig)
    assert rig.cameras.asked == [(*FRONT, None)]
    rig.cameras.age_s = 30.0
    rig.clock.advance(60)
    rig.stand(row=3)
    assert len(await pictures(rig, PictureKind.MISSION)) == 1


@pytest.mark.slow
async def test_a_clip_that_takes_for_ever_does_not_keep_the_console_from_ending(rig: PictureRig) -> None:
    never = asyncio.Event()

    async def clip(*_args: object) -> Clip:
        await never.wait()
        raise AssertionError

    rig.cameras.clip = clip  # type: ignore[method-assign]
    rig.recorder.stopped(WEEDER, "Martha Keller")
    for _ in range(17):
        rig.clock.advance(1)
        await rig.recorder.round()
    async with asyncio.timeout(2.5):
        await rig.recorder.stop()
