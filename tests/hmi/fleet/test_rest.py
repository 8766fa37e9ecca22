"""The fleet by REST: group orders, groups, saved views, hand-over, wall screens."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import httpx

from hmi.commands.lease_service import LeaseOp
from hmi.commands.refusal import OrderRefused
from hmi.domain.role import Role
from hmi.store.duty import Duties
from tests.hmi.commands.field import FARM, JONAS
from tests.hmi.fleet.conftest import FleetConsole

BOTH = ["weeder-01", "weeder-02"]


async def order(console: FleetConsole, client: httpx.AsyncClient, action: str, **more: Any) -> httpx.Response:
    """Send an order to both robots on a fresh picture."""
    return await client.post(
        "/fleet/actions", json={"action": action, "robots": BOTH, "tick": console.field.tick(), **more}
    )


async def test_a_group_order_answers_for_each_robot(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    console.field.robots["weeder-02"].refuse_with = ("busy", "It is busy.")
    answer = (await order(console, martha, "pause")).json()
    assert (answer["accepted"], answer["total"]) == (1, 2)
    assert answer["results"] == [
        {"robot": "weeder-01", "outcome": "accepted", "code": "ok", "text": ""},
        {"robot": "weeder-02", "outcome": "rejected", "code": "busy", "text": "It is busy."},
    ]


async def test_an_order_that_needs_control_answers_who_has_it_at_each_robot(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    console.field.desk.leases.operate(JONAS, "weeder-02", LeaseOp.REQUEST, tick_id=console.field.tick())
    results = (await order(console, martha, "return_home")).json()["results"]
    assert [one["outcome"] for one in results] == ["accepted", "rejected"]
    owners = [one["owner"] for one in results]
    holders = [lease.holder for robot in BOTH if (lease := console.field.desk.leases.of(robot)) is not None]
    assert [one["session"] for one in owners] == [holder.session_id for holder in holders]
    assert owners[1]["name"] == "Jonas Weber"


async def test_what_starts_machines_cannot_be_asked_of_several(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    for action in ("start", "resume", "drive_open"):
        assert (await order(console, martha, action)).status_code == 422


async def test_a_viewer_may_not_order_and_reads_who_may(console: FleetConsole) -> None:
    viewer = await console.browser(Role.VIEWER)
    answer = await order(console, viewer, "pause")
    assert (answer.status_code, answer.json()["text"]) == (403, "Pausing needs the operator role.")
    assert (await viewer.get("/fleet/kpis")).status_code == 200
    assert (await console.client().get("/fleet/kpis")).status_code == 401


async def test_a_mission_goes_to_robots_one_by_one(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    sent = await martha.post("/fleet/mission", json={"mission_id": "field-1", "robots": ["weeder-01"]})
    assert sent.json()["results"][0]["outcome"] == "accepted"
    each = await martha.post("/fleet/mission", json={"pairs": [{"robot": "weeder-02", "mission_id": "none"}]})
    assert each.json()["results"][0]["code"] == "unknown_mission"
    assert (await martha.post("/fleet/mission", json={"robots": BOTH})).status_code == 422


async def test_groups_belong_to_the_farm(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    made = (await martha.post("/fleet/groups", json={"name": "North", "robots": BOTH})).json()
    assert (await martha.post("/fleet/groups", json={"name": "North", "robots": BOTH})).status_code == 409
    viewer = await console.browser(Role.VIEWER, browser="2")
    assert (await viewer.get("/fleet/groups")).json()["groups"] == [made]
    assert (await viewer.delete(f"/fleet/groups/{made['id']}")).status_code == 403
    changed = await martha.put(f"/fleet/groups/{made['id']}", json={"name": "South", "robots": ["weeder-02"]})
    assert changed.json()["robots"] == ["weeder-02"]
    assert (await martha.delete(f"/fleet/groups/{made['id']}")).status_code == 204
    assert (await martha.delete(f"/fleet/groups/{made['id']}")).status_code == 404
    assert [one.outcome for one in await console.written("fleet")] == ["saved", "changed", "deleted"]


async def test_a_view_is_its_persons_own_and_saving_it_again_replaces_it(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    for sort in ("name", "group"):
        saved = await martha.post("/fleet/views", json={"name": "Mine", "filter": {"sort": sort, "mine": True}})
        assert saved.status_code == 201
    (view,) = (await martha.get("/fleet/views")).json()["views"]
    assert view["filter"] == {"sort": "group", "mine": True}
    anna = await console.browser(Role.SUPERVISOR, browser="2")
    assert (await anna.get("/fleet/views")).json()["views"] == []
    assert (await anna.delete(f"/fleet/views/{view['id']}")).status_code == 404
    assert (await martha.delete(f"/fleet/views/{view['id']}")).status_code == 204


async def test_a_hand_over_changes_nothing_until_the_other_takes_it(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    await console.session(Role.DISPATCHER, browser="9")
    dora = await console.browser(Role.DISPATCHER, browser="3")
    taken = await martha.post("/fleet/duty/handover", json={"robots": BOTH, "to_user": "operator"})
    assert taken.json()["duty"]["weeder-01"]["name"] == "Martha Keller"
    offered = await martha.post(
        "/fleet/duty/handover", json={"robots": BOTH, "to_user": "dispatcher", "note": "07 pulls left"}
    )
    assert offered.json()["duty"]["weeder-01"]["user"] == "operator"
    assert offered.json()["duty"]["weeder-01"]["offer"]["note"] == "07 pulls left"
    who = console.duty.responsible_for("weeder-01")
    assert who is not None
    assert who.user_name == "Martha Keller"
    assert (await martha.post("/fleet/duty/accept", json={"robots": BOTH})).status_code == 409
    accepted = await dora.post("/fleet/duty/accept", json={"robots": BOTH})
    assert accepted.json()["duty"]["weeder-02"] == {
        "user": "dispatcher",
        "name": "Dispatcher",
        "since": accepted.json()["duty"]["weeder-02"]["since"],
        "note": "07 pulls left",
        "offer": None,
    }
    book = (await dora.get("/fleet/duty")).json()["book"]
    assert [(line["what"], line["by"], line["to"]) for line in book] == [
        ("accepted", "Dispatcher", "Dispatcher"),
        ("offered", "Martha Keller", "Dispatcher"),
        ("taken", "Martha Keller", "Martha Keller"),
    ]
    assert [one.outcome for one in await console.written("duty")] == ["taken", "offered", "accepted"]
    again = Duties(console.database, FARM, console.field.clock)
    again.load()
    assert again.of("weeder-01").user_name == "Dispatcher"


async def test_nobody_takes_what_somebody_else_answers_for_but_a_supervisor(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    dora = await console.browser(Role.DISPATCHER, browser="2")
    anna = await console.browser(Role.SUPERVISOR, browser="3")
    await martha.put("/fleet/duty/weeder-01", json={"user": "operator"})
    refused = await dora.put("/fleet/duty/weeder-01", json={"user": "dispatcher"})
    assert (refused.status_code, refused.json()["text"]) == (
        409,
        "Martha Keller is responsible for Weeder 01. Ask for a hand-over.",
    )
    assert (await anna.put("/fleet/duty/weeder-01", json={"user": "supervisor"})).status_code == 200
    assert (await anna.put("/fleet/duty/weeder-01", json={"user": None})).status_code == 200
    assert console.duty.responsible_for("weeder-01") is None


async def test_an_offer_can_be_declined_and_withdrawn(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    anna = await console.browser(Role.SUPERVISOR, browser="2")
    await martha.put("/fleet/duty/weeder-01", json={"user": "operator"})
    for who, what in ((anna, "declined"), (martha, "withdrawn")):
        await martha.put("/fleet/duty/weeder-01", json={"user": "supervisor"})
        left = (await who.post("/fleet/duty/decline", json={"robots": ["weeder-01"]})).json()
        assert (left["duty"]["weeder-01"]["name"], left["duty"]["weeder-01"]["offer"]) == ("Martha Keller", None)
        assert (await martha.get("/fleet/duty")).json()["book"][0]["what"] == what


async def test_who_offered_a_robot_that_is_not_theirs_withdraws_the_offer_and_nobody_else_does(
    console: FleetConsole,
) -> None:
    martha = await console.browser(Role.OPERATOR)
    dora = await console.browser(Role.DISPATCHER, browser="2")
    anna = await console.browser(Role.SUPERVISOR, browser="3")
    await martha.put("/fleet/duty/weeder-02", json={"user": "operator"})
    for robot, responsible in (("weeder-01", ""), ("weeder-02", "operator")):  # nobody's, and somebody else's
        offered = await anna.put(f"/fleet/duty/{robot}", json={"user": "dispatcher"})
        assert offered.json()["duty"][robot]["offer"]["by_id"] == "supervisor"
        again = Duties(console.database, FARM, console.field.clock)
        again.load()
        assert again.of(robot).offered_by_id == "supervisor"
        if not responsible:
            assert (await martha.post("/fleet/duty/decline", json={"robots": [robot]})).status_code == 409
        left = (await anna.post("/fleet/duty/decline", json={"robots": [robot]})).json()
        assert (left["duty"][robot]["user"], left["duty"][robot]["offer"]) == (responsible, None)
        assert (await dora.get("/fleet/duty")).json()["book"][0]["what"] == "withdrawn"


async def test_responsibility_is_offered_to_people_who_may_operate_only(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    await console.session(Role.VIEWER, browser="2")
    people = (await martha.get("/fleet/duty")).json()["people"]
    assert [one["id"] for one in people] == ["operator"]
    assert (await martha.put("/fleet/duty/weeder-01", json={"user": "viewer"})).status_code == 409


async def test_a_wall_screen_watches_and_stops_and_does_nothing_else(console: FleetConsole) -> None:
    anna = await console.browser(Role.SUPERVISOR)
    made = (await anna.post("/fleet/walls", json={"name": "Barn"})).json()
    opened = await console.client().post("/fleet/walls/open", json={"key": made["key"]})
    assert opened.json()["name"] == "Barn"
    assert made["key"] in opened.headers["set-cookie"]
    session = console.sessions.get(made["id"])
    assert session is not None
    wall = console.client(made["key"], session)
    console.field.wait(90 * 86_400)
    assert console.sessions.sweep() >= 0
    await console.sessions.reconcile()
    assert (await wall.get("/fleet/groups")).status_code == 200
    assert (await wall.post("/stop", json={"stop_id": "stop-00000001", "robots": BOTH})).status_code == 202
    assert (await order(console, wall, "pause")).status_code == 403
    assert (await wall.post("/fleet/walls", json={"name": "Another"})).status_code == 403
    assert (await wall.put("/fleet/duty/weeder-01", json={"user": "operator"})).status_code in (403, 409)


async def test_a_revoked_wall_screen_goes_dark_at_once_and_stays_dark_after_a_restart(console: FleetConsole) -> None:
    anna = await console.browser(Role.SUPERVISOR)
    made = (await anna.post("/fleet/walls", json={"name": "Barn"})).json()
    gone: list[str] = []
    console.sessions.on_ended(lambda session, text: gone.append(f"{session.user_name}: {text}"))
    assert (await anna.delete(f"/fleet/walls/{made['id']}")).status_code == 204
    revoked = json.loads((console.stop_folder / "revoked.json").read_text("utf-8"))
    assert revoked == [f"wall-{made['id'][:12]}"], "its STOP token is worth nothing any more"
    assert gone == ["Wall Barn: This wall screen was taken out."]
    await console.walls.load()
    assert console.sessions.get(made["id"]) is None
    refused = await console.client().post("/fleet/walls/open", json={"key": made["key"]})
    assert refused.status_code == 401
    (listed,) = (await anna.get("/fleet/walls")).json()["walls"]
    assert listed["revoked_at"] is not None
    assert "key" not in listed
    assert [one.outcome for one in await console.written("wall")] == ["made", "revoked"]


async def test_a_wall_screen_is_open_again_after_a_restart(console: FleetConsole) -> None:
    anna = await console.browser(Role.SUPERVISOR)
    made = (await anna.post("/fleet/walls", json={"name": "Barn"})).json()
    console.sessions.dismiss_wall(made["id"], "")
    await console.walls.load()
    assert console.sessions.lookup(made["key"]) is not None


async def test_only_supervisors_make_wall_screens(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    assert (await martha.post("/fleet/walls", json={"name": "Barn"})).status_code == 403
    assert (await martha.get("/fleet/walls")).status_code == 403


async def test_who_is_switched_off_or_may_not_operate_any_more_answers_for_no_robot(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    await console.session(Role.DISPATCHER, browser="9")
    anna = await console.browser(Role.SUPERVISOR, browser="2")
    await martha.put("/fleet/duty/weeder-01", json={"user": "operator"})
    await anna.put("/fleet/duty/weeder-02", json={"user": "supervisor"})
    await anna.post("/fleet/duty/handover", json={"robots": ["weeder-02"], "to_user": "dispatcher"})
    console.field.events.clear()
    await console.accounts.change("operator", by="Ada", is_active=False)
    await console.accounts.change("dispatcher", by="Ada", role=Role.VIEWER)
    assert console.duty.responsible_for("weeder-01") is None
    seen = (await anna.get("/fleet/duty")).json()
    assert seen["duty"].keys() == {"weeder-02"}
    assert (seen["duty"]["weeder-02"]["name"], seen["duty"]["weeder-02"]["offer"]) == ("Anna Ostermeier", None)
    assert [(line["what"], line["by"], line["robots"]) for line in seen["book"][:2]] == [
        ("withdrawn", "Ada", ["weeder-02"]),
        ("released", "Ada", ["weeder-01"]),
    ]
    assert seen["book"][1]["note"] == "Martha Keller does not operate robots here any more."
    assert [one["what"] for one in console.field.events if one["kind"] == "duty"] == ["released", "withdrawn"]


async def test_what_is_offered_by_somebody_who_is_gone_can_still_be_taken(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    anna = await console.browser(Role.SUPERVISOR, browser="2")
    await martha.put("/fleet/duty/weeder-01", json={"user": "operator"})
    await martha.post("/fleet/duty/handover", json={"robots": ["weeder-01"], "to_user": "supervisor"})
    await console.accounts.change("operator", by="Ada", is_active=False)
    assert console.duty.responsible_for("weeder-01") is None
    accepted = await anna.post("/fleet/duty/accept", json={"robots": ["weeder-01"]})
    assert accepted.json()["duty"]["weeder-01"]["user"] == "supervisor"


async def test_a_robot_that_was_taken_out_and_comes_back_is_nobodys(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    await martha.post("/fleet/duty/handover", json={"robots": BOTH, "to_user": "operator"})
    await console.duty.let_go(robots={"weeder-01"})  # it is there again before anybody looked
    assert console.duty.responsible_for("weeder-01") is None
    await console.database.run(console.registry.remove, "weeder-02")
    await console.duty.let_go()
    again = Duties(console.database, FARM, console.field.clock)
    again.load()
    assert again.all() == []


async def test_of_two_who_take_a_robot_at_once_one_is_responsible_and_the_other_reads_who(
    console: FleetConsole,
) -> None:
    _cookie, martha = await console.session(Role.OPERATOR)
    _cookie, dora = await console.session(Role.DISPATCHER, browser="9")
    first, second = await asyncio.gather(
        console.duty.take(martha, BOTH), console.duty.take(dora, BOTH), return_exceptions=True
    )
    assert isinstance(first, list)
    assert isinstance(second, OrderRefused)
    assert second.text == "Martha Keller is responsible for Weeder 01. Ask for a hand-over."
    assert [line.by for line in await console.duty.book(dora)] == ["Martha Keller"]


async def test_an_offer_that_is_withdrawn_is_not_accepted_in_the_same_moment(console: FleetConsole) -> None:
    _cookie, martha = await console.session(Role.OPERATOR)
    _cookie, anna = await console.session(Role.SUPERVISOR, browser="2")
    await console.duty.take(martha, BOTH)
    await console.duty.hand_over(martha, BOTH, "supervisor", "")
    _kept, late = await asyncio.gather(
        console.duty.decline(martha, BOTH), console.duty.accept(anna, BOTH), return_exceptions=True
    )
    assert isinstance(late, OrderRefused)
    assert console.duty.responsible_for("weeder-01").user_id == "operator"  # type: ignore[union-attr]


async def test_who_is_switched_off_while_asking_becomes_responsible_for_nothing(console: FleetConsole) -> None:
    _cookie, martha = await console.session(Role.OPERATOR)
    _cookie, anna = await console.session(Role.SUPERVISOR, browser="2")
    await console.duty.take(anna, ["weeder-02"])
    await console.duty.hand_over(anna, ["weeder-02"], "operator", "")
    await console.accounts.change("operator", by="Ada", is_active=False)
    for late in (
        console.duty.take(martha, ["weeder-01"]),
        console.duty.hand_over(martha, ["weeder-01"], "supervisor", ""),
    ):
        (answer,) = await asyncio.gather(late, return_exceptions=True)
        assert isinstance(answer, OrderRefused)
        assert answer.text == "You may not operate robots here any more."
    assert console.duty.responsible_for("weeder-01") is None
    assert [one.offered_to for one in console.duty.all(anna)] == [""]


async def test_a_robot_that_lost_its_person_is_told_of_until_somebody_takes_it(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    anna = await console.browser(Role.SUPERVISOR, browser="2")

    async def freed() -> set[str]:
        return set((await anna.get("/fleet/duty")).json()["freed"])

    await martha.post("/fleet/duty/release", json={"robots": ["weeder-02"]})  # was nobody's before, too
    assert await freed() == set()
    await martha.post("/fleet/duty/handover", json={"robots": BOTH, "to_user": "operator"})
    console.field.events.clear()
    await martha.post("/fleet/duty/release", json={"robots": ["weeder-01"]})
    await console.accounts.change("operator", by="Ada", is_active=False)
    told = [one for one in console.field.events if one["kind"] == "duty"]
    assert [(one["what"], one["robots"], one["by_id"], one["from_users"]) for one in told] == [
        ("released", ["weeder-01"], "operator", ["operator"]),
        ("released", ["weeder-02"], "", ["operator"]),
    ]
    assert await freed() == {"weeder-01", "weeder-02"}
    console.field.events.clear()
    await anna.post("/fleet/duty/handover", json={"robots": ["weeder-01"], "to_user": "supervisor"})
    assert await freed() == {"weeder-02"}
    assert [one["from_users"] for one in console.field.events if one["kind"] == "duty"] == [[]]


async def test_who_lost_robots_to_a_supervisor_is_named_to_every_page(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    anna = await console.browser(Role.SUPERVISOR, browser="2")
    await martha.put("/fleet/duty/weeder-01", json={"user": "operator"})
    console.field.events.clear()
    await anna.post("/fleet/duty/handover", json={"robots": BOTH, "to_user": "supervisor"})
    [told] = [one for one in console.field.events if one["kind"] == "duty"]
    assert (told["what"], told["by_id"], told["from_users"]) == ("taken", "supervisor", ["operator"])
    assert told["names"] == ["Weeder 01", "Weeder 02"]


async def test_a_robot_given_up_twice_is_told_of_all_the_same_and_one_taken_out_no_more(console: FleetConsole) -> None:
    martha = await console.browser(Role.OPERATOR)
    anna = await console.browser(Role.SUPERVISOR, browser="2")
    await martha.post("/fleet/duty/handover", json={"robots": BOTH, "to_user": "operator"})
    await martha.post("/fleet/duty/release", json={"robots": BOTH})
    before = (await anna.get("/fleet/duty")).json()["freed"]
    console.field.clock.advance(5)
    await martha.post("/fleet/duty/release", json={"robots": BOTH})
    assert (await anna.get("/fleet/duty")).json()["freed"] == before
    assert before.keys() == set(BOTH)
    await console.duty.let_go(robots={"weeder-01"})  # it is there again before anybody looked
    assert (await anna.get("/fleet/duty")).json()["freed"].keys() == {"weeder-02"}
