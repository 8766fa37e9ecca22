"""The console's planner with a service: plans of it are checked, and whatever it does, a plan is made here."""

from __future__ import annotations

import asyncio
import math
import os
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import pytest
import shapely

from backend_clients.planner.client import PlannerClient, limited
from backend_clients.planner.messages import PlanPath
from backend_clients.service.connection import Service
from backend_clients.simulator.faulty_http import Fault
from hmi.cli.services import moved, of_another
from hmi.domain.family import Family
from hmi.domain.mission_plan import PlanRefused, PlanWish, Rows, Surroundings, TreatedArea, Treatment
from hmi.keeper.certificates import make_certificates
from hmi.planning.given_path import checked_mission
from hmi.planning.mission import machine_of, plan_mission
from hmi.planning_service.application import make_application
from hmi.planning_service.desk import PlanDesk
from hmi.planning_service.form import form_of, wish_of
from hmi.planning_service.planner import ServicePlanner
from hmi.planning_service.work import planned
from hmi.service_link import LinkState
from tests.hmi.missions.rig import FRAME, farm_map, lon_lat
from tests.hmi.missions.test_document import wish
from tests.hmi.planning_service.rig import HereProcess, ServiceRig, service_rig, until
from tests.hmi.presenters.robots import SHEET
from tests.served import served


@pytest.mark.slow
async def test_a_plan_of_the_service_is_the_plan_we_would_make_and_says_where_it_was_made() -> None:
    async with service_rig() as rig:
        heard: list[str] = []
        made = await rig.planner.plan(wish(), lambda _share, words: heard.append(words))
        own = plan_mission(wish())
        assert (made.sha256, made.document) == (own.sha256, own.document)
        place = made.statistics["planned_at"]
        assert place["where"] == "service"
        assert place["text"].endswith("checked here.")
        assert (heard[0], heard[-1]) == ("Asking the planner service", "Checking the plan")
        assert rig.local.planned == 0
        assert rig.link.is_well
        candidate = await rig.planner.candidate(wish())
        assert candidate.statistics["planned_at"]["where"] == "service"
        assert candidate.drawing["legs"]


def test_a_wish_survives_the_way_to_the_service_and_back() -> None:
    features = {one.id: one for one in farm_map()}
    around = Surroundings(((features["pylon-1"].geometry, 4.0),), ((features["road-1"].geometry, 6.0),))
    ditch = {"type": "LineString", "coordinates": lon_lat((-10, -30), (-10, 60))}  # the road leads over it
    around = replace(around, crossed=((ditch, 4.0),))
    area = TreatedArea(wish().parcel, 0.5)
    asked = wish(robot=SHEET, surroundings=around, home=tuple(lon_lat((-25, 10))[0]), returns_home=True,
                 treatment=Treatment((area,), 1.0), row_speed_mps=0.7, overlap=0.1)  # fmt: skip
    again, machine = wish_of(form_of(asked))
    own, other = plan_mission(asked), plan_mission(again, machine)
    assert own.document["segments"][-1]["kind"] == "exit"
    assert other.document["segments"] == own.document["segments"]
    names = {asked.name, asked.field_name, asked.robot_id, asked.mission_id}
    assert not any(name in form_of(asked).model_dump_json() for name in names)


def test_the_clearance_that_a_machine_keeps_is_a_part_of_what_the_service_keeps_off() -> None:
    zone = {"type": "Polygon", "coordinates": [lon_lat((-40, -40), (-30, -40), (-30, -30), (-40, -30), (-40, -40))]}
    flying = replace(SHEET, family=Family.UAV)
    asked = wish(robot=flying, surroundings=Surroundings(((zone, 0.0),), ()))
    kept = machine_of(asked).clearance_m
    assert kept > 0
    told = form_of(asked).obstacles
    area = shapely.transform(shapely.geometry.shape(told[0].geometry), FRAME.to_local)
    assert len(told) == 1
    assert area.area == pytest.approx(100 + 40 * kept + math.pi * kept**2, rel=0.01)


@pytest.mark.slow
def test_a_robot_that_backs_up_says_so_to_the_service_and_any_other_says_nothing_new() -> None:
    assert "reverse_mps" not in form_of(wish(robot=SHEET)).model_dump_json()
    backing = replace(SHEET, turning_radius_m=3.0, can_pivot=False, path_reverse_mps=0.5)
    asked = wish(robot=backing, width_m=2.0)
    again, machine = wish_of(form_of(asked))
    assert machine.reverse_mps == 0.5
    path = PlanPath.model_validate_json(planned(form_of(asked).model_dump_json().encode(), str(Path(os.devnull))))
    assert {one.is_backward for one in path.segments} == {False, True}
    assert all("is_backward" not in one.model_dump() for one in path.segments if not one.is_backward)
    own = checked_mission(asked, [one.model_dump() for one in path.segments], [])
    assert own.sha256 == plan_mission(asked).sha256
    assert plan_mission(again, machine).document["segments"] == own.document["segments"]


@pytest.mark.slow
def test_what_flies_says_so_and_is_planned_there_as_here() -> None:
    assert "family" not in form_of(wish(robot=SHEET)).model_dump_json()
    flying = replace(SHEET, family=Family.UAV, max_speed_mps=8.0, turning_radius_m=4.0, can_pivot=False)
    air = {"type": "Polygon", "coordinates": [lon_lat((-90, -90), (200, -90), (200, 200), (-90, 200), (-90, -90))]}
    home = tuple(lon_lat((-3, 1))[0])  # a short way, which it flies faster than a machine on the ground drives it
    asked = wish(robot=flying, width_m=4.0, home=home, surroundings=Surroundings((), ((air, 0.0),)))
    path = PlanPath.model_validate_json(planned(form_of(asked).model_dump_json().encode(), str(Path(os.devnull))))
    there = checked_mission(asked, [one.model_dump() for one in path.segments], list(path.notes))
    assert there.document["segments"] == plan_mission(asked).document["segments"]


@dataclass(frozen=True, slots=True)
class WiderWish(PlanWish):
    """A wish of a later version, for something the format has no word for."""

    moon_phase: str = "any"


async def test_a_wish_for_what_the_format_has_no_word_for_is_not_sent() -> None:
    usual = {one.name: getattr(wish(), one.name) for one in fields(PlanWish)}
    async with service_rig() as rig:
        made = await rig.planner.plan(WiderWish(**usual, moon_phase="full"))
        place = made.statistics["planned_at"]
        assert place["where"] == "here"
        assert "planner services know nothing of moon phase" in place["text"]
        assert rig.faulty.requests == 0
        assert (await rig.planner.plan(WiderWish(**usual))).statistics["planned_at"]["where"] == "service"


@pytest.mark.slow
async def test_a_field_that_says_how_far_its_rows_are_apart_is_planned_by_the_service_all_the_same() -> None:
    asked = replace(wish(), row_spacing_m=0.5)
    async with service_rig() as rig:
        made = await rig.planner.plan(asked)
        assert made.statistics["planned_at"]["where"] == "service"
        assert made.sha256 == plan_mission(asked).sha256, "it bears on recorded rows alone"
        recorded = replace(asked, rows=Rows.RECORDED_ROWS)
        with pytest.raises(ValueError, match=r"know nothing of rows along lines of the map or the field's edge$"):
            form_of(recorded)


FAULTS: list[tuple[dict[str, Any], str, LinkState]] = [
    ({"fault": Fault.FAIL}, "the planner service failed", LinkState.FAILING),
    ({"fault": Fault.TOO_LARGE}, "the planner service failed: 413", LinkState.OK),
    ({"fault": Fault.REFUSE}, "does not let us in", LinkState.REFUSED),
    ({"fault": Fault.NOT_JSON}, "not what the format promises", LinkState.OK),
    ({"fault": Fault.HUGE}, "more than", LinkState.OK),
    ({"fault": Fault.CUT}, "cannot be reached", LinkState.UNREACHABLE),
    ({"fault": Fault.HALF_OPEN}, "did not answer in 0.3 s", LinkState.SILENT),
    ({"delay_s": 5.0}, "did not answer in 0.3 s", LinkState.SILENT),
    ({"alter": of_another}, "answered for another wish", LinkState.OK),
    ({"alter": moved}, "The robot's outline would leave the field", LinkState.OK),
]


@pytest.mark.slow
@pytest.mark.parametrize(("faults", "words", "state"), FAULTS, ids=[str(n) for n in range(len(FAULTS))])
async def test_whatever_goes_wrong_the_plan_is_made_here_and_says_why(
    faults: dict[str, Any], words: str, state: LinkState
) -> None:
    async with service_rig(timeout_s=0.3 if state is LinkState.SILENT else 30.0) as rig:
        rig.link.well(0.1)
        rig.faulty.set(**faults)
        made = await rig.planner.plan(wish())
        place = made.statistics["planned_at"]
        assert place["where"] == "here"
        assert place["text"].startswith("Planned on this server: ")
        assert words in place["text"]
        assert made.sha256 == plan_mission(wish()).sha256
        assert rig.link.state is state
        assert rig.link.last_error is not None
        rig.faulty.set()


def refuses_in_odd_words(report: Any) -> Any:
    """Return a plan that failed, with words no screen should carry on."""
    problem = {"code": "x", "text": "No\x00 \x1b[31mway.\n" + "y" * 300}
    if "wish_sha256" not in report:
        return report
    return {**report, "state": "failed", "result": None, "problem": problem}


async def test_what_a_service_says_goes_on_as_plain_words_only() -> None:
    async with service_rig() as rig:
        rig.faulty.set(alter=refuses_in_odd_words)
        text = (await rig.planner.plan(wish())).statistics["planned_at"]["text"]
        assert text.startswith("Planned on this server: the planner service refused the wish: No [31mway.yyy")
        assert text.isprintable()
        assert len(text) < 300
        assert rig.link.last_error is None


@pytest.mark.slow
async def test_a_service_that_is_away_is_not_waited_for_again_and_comes_back_by_itself() -> None:
    async with service_rig() as rig:
        rig.faulty.set(fault=Fault.FAIL)
        await rig.planner.plan(wish())
        asked = rig.faulty.requests
        second = await rig.planner.plan(wish())
        assert "it is asked again by itself" in second.statistics["planned_at"]["text"]
        assert rig.faulty.requests == asked
        rig.faulty.set()
        rig.clock.advance(rig.link.again_in_s + 0.1)
        assert (await rig.planner.plan(wish())).statistics["planned_at"]["where"] == "service"


@pytest.mark.slow
async def test_answers_that_cannot_be_used_again_and_again_stop_the_asking() -> None:
    async with service_rig() as rig:
        rig.link.well(0.1)
        rig.faulty.set(alter=moved)
        for _ in range(3):
            await rig.planner.plan(wish())
        assert rig.link.state is LinkState.NOT_UNDERSTOOD
        asked = rig.faulty.requests
        await rig.planner.plan(wish())
        assert rig.faulty.requests == asked


async def test_cancelling_reaches_the_service_and_nothing_comes_late() -> None:
    async with service_rig() as rig:
        rig.process.held = asyncio.Event()
        begun = asyncio.Event()
        work = asyncio.create_task(rig.planner.candidate(wish(), lambda *_: begun.set()))
        await begun.wait()
        await until(lambda: rig.desk.waiting > 0)
        work.cancel()
        with pytest.raises(asyncio.CancelledError):
            await work
        await until(lambda: rig.desk.waiting == 0)
        assert rig.local.planned == 0
        assert rig.link.last_error is None


async def test_a_wish_that_no_planner_can_plan_is_refused_here_too() -> None:
    async with service_rig() as rig:
        with pytest.raises(PlanRefused):
            await rig.planner.plan(wish(width_m=39.0))
        with pytest.raises(PlanRefused, match="speed"):
            await rig.planner.plan(replace(wish(), row_speed_mps=9.0))
        assert rig.link.last_error is None


@pytest.mark.slow
async def test_a_certificate_that_is_not_ours_is_not_trusted_and_one_that_is_named_is(tmp_path: Path) -> None:
    made = make_certificates(["127.0.0.1"], tmp_path, days=2)
    desk = PlanDesk(process=HereProcess())
    async with served(make_application(desk), cert=made.cert, key=made.key) as url, service_rig() as rig:
        for ca, where in (("", "here"), (str(made.ca), "service")):
            client = PlannerClient(limited(Service(url, ca=ca)), 30.0)
            planner = ServicePlanner(rig.local, client, fresh(rig), rig.clock)  # type: ignore[arg-type]
            place = (await planner.plan(wish())).statistics["planned_at"]
            await client.close()
            assert place["where"] == where
            if where == "here":
                assert "certificate of the planner service is not trusted" in place["text"]


def fresh(rig: ServiceRig) -> Any:
    """Return a link that nothing happened to."""
    return type(rig.link)(rig.clock)
