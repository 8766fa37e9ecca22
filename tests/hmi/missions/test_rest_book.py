"""Changing the rest, resuming later, starting fresh: rights, what is kept, and what only a read-back confirms."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import pytest

from hmi.commands.mission_rest import MissionRests, RestOrder
from hmi.commands.mission_send import MissionSender
from hmi.commands.refusal import STALE_TICK, OrderRefused
from hmi.commands.rest_sources import RestParts
from hmi.commands.start_rules import MissionStartRules
from hmi.domain.command import Acknowledgement, OrderFailed, Outcome
from hmi.domain.mission import MissionStatus, Mover
from hmi.domain.mission_document import mission_sha256
from hmi.domain.mission_plan import MissionRefused
from hmi.domain.mission_rest import PlannedRest, RestWish
from hmi.domain.robot import Hold, Mode, Order, OrderStatus, Robot
from hmi.domain.role import Role
from hmi.planning.rest import plan_rest
from hmi.security.errors import NotAllowed
from hmi.store.checklists import Checklists
from hmi.store.maps import Maps
from hmi.store.mission_revisions import MissionRevisions
from hmi.store.mission_tracking import MissionTracking
from tests.hmi.missions.rig import FARM, FRAME, Rig, order
from tests.hmi.missions.test_map_watch import publish
from tests.hmi.missions.test_store import put, through

S = MissionStatus
UNDER_WAY = ((S.SENT, Mover.PERSON), (S.ACCEPTED, Mover.ROBOT), (S.RUNNING, Mover.ROBOT))


@dataclass
class Wire:
    """A gate that lets everything through, a lease for the test, and a robot that reads back what it is sent."""

    rig: Rig
    holder: str = ""
    answer: str = "ok"
    is_late: bool = False
    sent: list[dict[str, Any]] = field(default_factory=list)

    def right(self, session: Any, permission: Any, robot_id: str) -> Robot:
        self.rig.authorize(session, permission, robot_id)
        robot = self.rig.fleet.robot(robot_id)
        assert robot is not None
        return robot

    def decided_now(self, tick_id: str) -> None:
        if self.is_late:
            raise OrderRefused(STALE_TICK, "Look again, then repeat.")

    def challenge(self, robot: Robot) -> str:
        return "challenge"

    def safety(self, robot: Robot) -> Any:
        return SimpleNamespace(standstill=True)

    def of(self, robot_id: str) -> Any:
        return SimpleNamespace(holder=SimpleNamespace(user_name="Jonas Weber")) if self.holder else None

    def holds(self, session_id: str, robot_id: str) -> Any:
        return self.of(robot_id) if self.holder == session_id else None

    def control(self, actor: Any, robot: Robot) -> Any:
        return SimpleNamespace(token=7)

    def next_seq(self, lease: Any) -> int:
        return 3

    async def upload_mission(self, robot_id: str, document: dict[str, Any]) -> Acknowledgement:
        self.sent.append(document)
        if self.answer == "silent":
            raise OrderFailed("no_answer", "The robot did not answer.", is_outcome_known=False)
        is_ok = self.answer == "ok"
        sha256 = mission_sha256(document) if is_ok else None
        text = "" if is_ok else "The robot is past the place where the new path begins."
        return Acknowledgement(robot_id, "mission", "m-1", is_ok, self.answer, text, None, sha256, None)

    async def submit(self, actor: Any, request: Any) -> Any:
        return SimpleNamespace(is_accepted=True)

    async def rest(self, wish: RestWish) -> PlannedRest:
        return plan_rest(wish)


class Desk:
    """A mission on a robot in its second row, and the book of rests."""

    def __init__(self, rig: Rig, mission_id: str = "") -> None:
        self.rig, self.wire, self.id = rig, Wire(rig), mission_id or "m-1"
        if not mission_id:
            put(rig)
        through(rig, self.id, *UNDER_WAY)
        self.revisions = MissionRevisions(rig.missions, rig.database, rig.clock)
        wire: Any = self.wire
        self.sender = MissionSender(wire, rig.book, wire, rig.audit, lambda _event: None)
        self.rests = MissionRests(
            RestParts(
                missions=rig.missions,
                revisions=self.revisions,
                features=rig.features,
                maps=Maps(rig.database, rig.clock),
                database=rig.database,
                fleet=rig.fleet,
                planner=wire,
                gate=wire,
                leases=wire,
                sender=self.sender,
                commands=wire,
                authorize=rig.authorize,
                clock=rig.clock,
            )
        )
        self.supervisor = rig.person(Role.SUPERVISOR)
        self.reports(OrderStatus.RUNNING)

    @property
    def row_2(self) -> int:
        segments = self.rig.missions.document(FARM, self.id)["segments"]
        return next(i for i, one in enumerate(segments) if one["row"] == 2)

    def reports(self, status: OrderStatus, mode: Mode = Mode.AUTO, hold: str = "") -> Robot:
        known = self.rig.missions.known(self.id)
        assert known is not None
        said: Order = replace(
            order(self.id, known.sha256, status), segment=self.row_2, segment_s_m=5.0, row=2, area_done_m2=60.0
        )
        robot = self.rig.fleet.report("weeder-01", said, self.rig.clock.mono_s())
        assert robot.state is not None
        state = replace(robot.state, mode=mode, hold=Hold(hold, "", "", "") if hold else None)
        self.rig.fleet.robots["weeder-01"] = replace(robot, state=state)
        lon, lat = FRAME.to_lon_lat([(20.0, 12.0)])[0]
        self.rig.fleet.place("weeder-01", float(lat), float(lon))
        return self.rig.fleet.robots["weeder-01"]

    def row(self, number: int) -> int:
        segments = self.rig.missions.document(FARM, self.id)["segments"]
        return next(i for i, one in enumerate(segments) if one["row"] == number)

    async def change(self, **more: Any) -> PlannedRest:
        return await self.rests.preview(self.supervisor, self.id, RestOrder("change", **more))

    async def follow(self) -> None:
        tracking = MissionTracking(self.rig.missions, self.rig.database, FARM, revisions=self.revisions)
        robot = self.rig.fleet.robots["weeder-01"]
        tracking.see(robot)
        await tracking.settle()

    @property
    def mission(self) -> Any:
        return self.rig.missions.known(self.id)

    def log(self) -> list[tuple[str, str]]:
        return [(entry.by, entry.why) for entry in self.rig.missions.log(FARM, self.id)]


@pytest.fixture
def desk(rig: Rig) -> Desk:
    return Desk(rig)


async def test_a_new_rest_that_was_read_back_is_the_missions_own(desk: Desk) -> None:
    planned = await desk.change(leave_out=(desk.row(4),))
    sent = await desk.rests.send(desk.supervisor, "m-1", planned.sha256, "tick")
    assert sent.outcome is Outcome.ACCEPTED
    assert (desk.mission.sha256, desk.mission.revision, desk.mission.status) == (planned.sha256, 2, S.RUNNING)
    assert desk.mission.pending_sha256 == ""
    assert 4 not in {one["row"] for one in desk.rig.missions.document(FARM, "m-1")["segments"]}
    assert ("Supervisor Person", "The rest was changed: Row 4 left out.") in desk.log()


async def test_only_a_robot_that_drives_gets_the_proof_of_who_has_control(desk: Desk) -> None:
    planned = await desk.change(leave_out=(desk.row(4),))
    await desk.rests.send(desk.supervisor, "m-1", planned.sha256, "tick")
    proof = {"lease_token": 7, "lease_seq": 3, "challenge": "challenge", "ttl_ms": 2000}
    assert desk.wire.sent[-1]["proof"] == proof
    assert "proof" not in desk.rig.missions.document(FARM, "m-1")
    desk.reports(OrderStatus.PAUSED, Mode.PAUSED)
    await desk.follow()
    planned = await desk.change(leave_out=(desk.row(3),))
    await desk.rests.send(desk.supervisor, "m-1", planned.sha256, "tick")
    assert "proof" not in desk.wire.sent[-1]


async def test_a_robot_that_drives_is_not_redirected_late_because_the_disk_was_slow(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    planned = await desk.change(leave_out=(desk.row(4),))
    propose = desk.revisions.propose

    def slow(*arguments: Any) -> None:
        propose(*arguments)
        desk.wire.is_late = True

    monkeypatch.setattr(desk.revisions, "propose", slow)
    sent = await desk.rests.send(desk.supervisor, "m-1", planned.sha256, "tick")
    assert (sent.outcome, sent.code) == (Outcome.REJECTED, STALE_TICK)
    assert desk.wire.sent == []
    assert desk.mission.pending_sha256 == ""


async def test_who_may_plan_and_not_drive_does_not_redirect_a_robot_that_drives(desk: Desk) -> None:
    planned = await desk.change(leave_out=(desk.row(4),))
    with pytest.raises(NotAllowed):
        await desk.rests.send(desk.rig.person(Role.PLANNER), "m-1", planned.sha256, "tick")
    assert desk.wire.sent == []


async def test_what_was_sent_without_an_answer_counts_only_when_the_robot_reports_it(desk: Desk) -> None:
    planned = await desk.change(leave_out=(desk.row(4),))
    before = desk.mission.sha256
    desk.wire.answer = "silent"
    sent = await desk.rests.send(desk.supervisor, "m-1", planned.sha256, "tick")
    assert sent.outcome is Outcome.UNKNOWN
    assert (desk.mission.sha256, desk.mission.pending_sha256) == (before, planned.sha256)
    desk.rig.fleet.report("weeder-01", order("m-1", planned.sha256, OrderStatus.RUNNING), 1.0)
    await desk.follow()
    assert (desk.mission.sha256, desk.mission.pending_sha256) == (planned.sha256, "")


async def test_a_refused_rest_changes_nothing(desk: Desk) -> None:
    planned = await desk.change(leave_out=(desk.row(4),))
    before = desk.mission.sha256
    desk.wire.answer = "update_too_late"
    sent = await desk.rests.send(desk.supervisor, "m-1", planned.sha256, "tick")
    assert (sent.outcome, sent.code) == (Outcome.REJECTED, "update_too_late")
    assert (desk.mission.sha256, desk.mission.pending_sha256, desk.mission.revision) == (before, "", 1)


async def test_a_whole_mission_that_is_refused_is_not_waited_for_and_the_log_names_who_sent_it(desk: Desk) -> None:
    desk.reports(OrderStatus.ABORTED, Mode.IDLE)
    await desk.follow()
    desk.wire.answer = "update_too_late"
    sent = await desk.sender.send(desk.supervisor, "weeder-01", "m-1", is_fresh=True)
    assert sent.outcome is Outcome.REJECTED
    assert (desk.mission.status, desk.mission.pending_sha256) == (S.ABORTED, "")
    assert desk.log()[-2:] == [
        ("Supervisor Person", "Sending: The whole mission again, from its first row."),
        ("Supervisor Person", "Not changed: The robot is past the place where the new path begins."),
    ]


async def test_what_may_be_on_the_robot_is_waited_for_though_the_next_one_does_not_go_out(desk: Desk) -> None:
    desk.rig.missions.change(FARM, "m-1", lambda _s, one, doc: (replace(one, map_version=1), doc), "Pieter", "")
    Maps(desk.rig.database, desk.rig.clock).published(FARM)
    desk.reports(OrderStatus.ABORTED, Mode.IDLE)
    await desk.follow()
    desk.wire.answer = "silent"
    await desk.rests.fresh(desk.supervisor, "m-1", "tick")
    waited_for = desk.mission.pending_sha256
    assert waited_for
    publish(desk.rig, "stone", 32, 27)
    sent = await desk.rests.fresh(desk.supervisor, "m-1", "tick")
    assert (sent.outcome, sent.code) == (Outcome.REJECTED, "map_changed")
    assert desk.mission.pending_sha256 == waited_for


async def test_only_what_was_shown_is_sent(desk: Desk) -> None:
    with pytest.raises(MissionRefused, match="Look at the new rest first"):
        await desk.rests.send(desk.supervisor, "m-1", "f" * 64, "tick")
    assert desk.wire.sent == []


async def test_an_operator_changes_the_rest_only_while_in_control(desk: Desk) -> None:
    operator = desk.rig.person(Role.OPERATOR)
    with pytest.raises(MissionRefused, match="Take control of Weeder 01 first"):
        await desk.rests.preview(operator, "m-1", RestOrder("change"))
    desk.wire.holder = operator.session_id
    assert (await desk.rests.preview(operator, "m-1", RestOrder("change"))).sha256
    with pytest.raises(NotAllowed):
        await desk.rests.preview(desk.rig.person(Role.VIEWER), "m-1", RestOrder("change"))


async def test_somebody_elses_robot_is_left_alone(desk: Desk) -> None:
    desk.wire.holder = "another browser"
    with pytest.raises(MissionRefused, match="Jonas Weber has control"):
        await desk.change()


async def test_a_paused_robot_that_was_moved_is_brought_back_first(desk: Desk) -> None:
    desk.reports(OrderStatus.PAUSED, Mode.PAUSED, "moved_while_paused")
    with pytest.raises(MissionRefused, match="Resume later"):
        await desk.change()


async def test_an_interrupted_mission_is_taken_up_again_even_when_the_robot_forgot_it(desk: Desk) -> None:
    desk.reports(OrderStatus.ABORTED, Mode.IDLE)
    await desk.follow()
    assert desk.mission.status is S.ABORTED
    desk.rig.fleet.report("weeder-01", None, 2.0)
    idle = desk.rig.fleet.robots["weeder-01"]
    assert idle.state is not None
    desk.rig.fleet.robots["weeder-01"] = replace(idle, state=replace(idle.state, mode=Mode.IDLE))
    view = await desk.rests.left(desk.supervisor, "m-1")
    assert (view.is_live, view.pieces[0].row, view.pieces[0].is_present) == (False, 2, True)
    planned = await desk.rests.preview(desk.supervisor, "m-1", RestOrder("later"))
    assert planned.difference["way_m"] > 3
    sent = await desk.rests.send(desk.supervisor, "m-1", planned.sha256, "tick")
    assert sent.outcome is Outcome.ACCEPTED
    assert (desk.mission.status, desk.mission.sha256) == (S.PAUSED, planned.sha256)


async def test_an_interrupted_mission_under_another_name_is_taken_up_again_all_the_same(desk: Desk) -> None:
    desk.reports(OrderStatus.ABORTED, Mode.IDLE)
    await desk.follow()
    held = desk.mission.sha256
    await desk.rig.book.rename(desk.supervisor, "m-1", "North, second half")
    assert (desk.mission.name, desk.mission.sha256) == ("North, second half", held)
    assert (await desk.rests.left(desk.supervisor, "m-1")).progress is not None
    planned = await desk.rests.preview(desk.supervisor, "m-1", RestOrder("later"))
    assert planned.document["continues"]["base_sha256"] == held
    assert planned.document["name"] == "North, second half"
    await desk.rests.fresh(desk.supervisor, "m-1", "tick")
    assert desk.wire.sent[-1]["name"] == "North, second half"


async def test_an_interrupted_mission_is_not_given_to_a_robot_that_knows_nothing_of_it(desk: Desk) -> None:
    desk.reports(OrderStatus.ABORTED, Mode.IDLE)
    await desk.follow()
    with pytest.raises(MissionRefused, match=r"interrupted on weeder-01.* Copy it for another robot\.") as caught:
        await desk.rig.book.change(desk.supervisor, "m-1", robot_id="weeder-02")
    assert caught.value.code == "has_progress"
    await desk.rig.book.change(desk.supervisor, "m-1", robot_id="weeder-01", is_supervised=False)
    assert (await desk.rests.preview(desk.supervisor, "m-1", RestOrder("later"))).difference["way_m"] > 3


async def test_an_ended_mission_with_nothing_to_resume_is_given_to_another_robot(desk: Desk) -> None:
    desk.reports(OrderStatus.DONE, Mode.IDLE)
    await desk.follow()
    await desk.rig.book.change(desk.supervisor, "m-1", robot_id="weeder-02")
    assert desk.rig.missions.document(FARM, "m-1")["robot"] == "weeder-02"


async def test_the_robots_word_counts_before_the_stored_state_follows(desk: Desk) -> None:
    desk.reports(OrderStatus.ABORTED, Mode.IDLE)
    assert desk.mission.status is S.RUNNING
    planned = await desk.rests.preview(desk.supervisor, "m-1", RestOrder("later"))
    assert planned.difference["way_m"] > 3


async def test_starting_fresh_sends_the_whole_mission_and_forgets_what_was_done(desk: Desk) -> None:
    planned = await desk.change(leave_out=(desk.row(4),))
    await desk.rests.send(desk.supervisor, "m-1", planned.sha256, "tick")
    desk.reports(OrderStatus.PAUSED, Mode.PAUSED, "paused")
    await desk.follow()
    sent = await desk.rests.fresh(desk.supervisor, "m-1", "tick")
    assert sent.outcome is Outcome.ACCEPTED
    document = desk.rig.missions.document(FARM, "m-1")
    assert "continues" not in document
    assert 4 in {one["row"] for one in document["segments"]}
    assert (document["revision"], desk.mission.revision, desk.mission.progress) == (3, 3, None)
    assert desk.mission.status is S.SENT
    assert any("Forgotten: row 2" in why for _, why in desk.log())


async def test_a_running_mission_does_not_start_fresh(desk: Desk) -> None:
    with pytest.raises(MissionRefused, match="Pause it first"):
        await desk.rests.fresh(desk.supervisor, "m-1", "tick")


async def test_a_mission_that_did_nothing_has_nothing_to_resume(desk: Desk) -> None:
    through(desk.rig, "m-1", (S.ABORTED, Mover.ROBOT))
    desk.rig.fleet.report("weeder-01", None, 2.0)
    with pytest.raises(MissionRefused, match="Start it fresh"):
        await desk.rests.preview(desk.supervisor, "m-1", RestOrder("later"))


def test_a_start_needs_the_stored_document_and_the_list(desk: Desk) -> None:
    lists = Checklists(desk.rig.database, desk.rig.clock)
    rules = MissionStartRules(desk.rig.missions, lists, lambda: True, lambda _robot_id: False)
    robot = desk.reports(OrderStatus.LOADED, Mode.IDLE)
    assert robot.state is not None
    said = robot.state.order
    assert said is not None
    other = replace(said, sha256="e" * 64)
    with pytest.raises(Exception, match="not read back"):
        rules.check(desk.supervisor, robot, other, None)
    with pytest.raises(Exception, match="Tick the list"):
        rules.check(desk.supervisor, robot, said, None)
    without = MissionStartRules(desk.rig.missions, lists, lambda: False, lambda _robot_id: False)
    without.check(desk.supervisor, robot, said, None)


@pytest.mark.parametrize(
    ("status", "mode", "forgotten"),
    [
        (OrderStatus.RUNNING, Mode.AUTO, False),
        (OrderStatus.PAUSED, Mode.PAUSED, True),
        (OrderStatus.ABORTED, Mode.IDLE, True),
        (OrderStatus.DONE, Mode.IDLE, False),
    ],
)
async def test_interrupted_work_is_named_before_it_is_forgotten(
    desk: Desk, status: OrderStatus, mode: Mode, forgotten: bool
) -> None:
    await desk.follow()
    desk.reports(status, mode)
    await desk.follow()
    assert bool(desk.rig.book.forgets(FARM, "m-1")) is forgotten
    assert desk.rig.book.forgets("farm-2", "m-1") == ""


async def test_a_paused_mission_is_not_sent_as_if_it_began_anew(desk: Desk) -> None:
    await desk.follow()
    desk.reports(OrderStatus.PAUSED, Mode.PAUSED)
    await desk.follow()
    with pytest.raises(OrderRefused, match="Start it fresh"):
        await desk.rig.book.stored(FARM, "m-1", "weeder-01")
