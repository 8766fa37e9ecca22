"""Row orders compared in one call."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import numpy as np
import pytest
import shapely

from hmi.api.candidates import candidate_stream
from hmi.commands.mission_book import MissionBook, MissionParts
from hmi.commands.plan_wish import PlanOrder
from hmi.domain.mission_plan import Candidate, Pattern, PlannedMission, PlanRefused, PlanWish, Tell, nobody
from hmi.domain.role import Role
from hmi.planning.mission import plan_candidate
from hmi.planning.worker import PlanningProcess
from hmi.planning_service.place import made_here
from hmi.store.features import Feature
from hmi.store.maps import Maps
from tests.hmi.missions.rig import FARM, FRAME, HerePlanner, Rig, lon_lat, parcel_geometry
from tests.hmi.missions.test_document import wish

PLAN = {"field_id": "field-1", "robot_id": "weeder-01", "width_m": 3.0}


async def compared(rig: Rig, **changes: Any) -> list[dict[str, Any]]:
    """Return the lines of a comparison."""
    async with rig.client(Role.PLANNER) as client:
        answer = await client.post("/missions/candidates", json={**PLAN, **changes})
    assert answer.status_code == 200, answer.text
    return [json.loads(line) for line in answer.text.splitlines()]


@pytest.mark.slow
async def test_every_row_order_comes_with_numbers_and_a_drawing_the_wished_one_first(rig: Rig) -> None:
    first, *found, last = await compared(rig, pattern="spiral")
    assert set(first["patterns"]) == {pattern.value for pattern in Pattern}
    assert last == {"state": "done"}
    assert found[0]["pattern"] == "spiral"
    assert {one["pattern"] for one in found} == {pattern.value for pattern in Pattern}
    for one in found:
        if one["state"] == "same":
            continue
        assert one["statistics"]["pattern"] == one["pattern"]
        assert one["statistics"]["reserve_share"] >= 0.15
        legs = one["drawing"]["legs"]
        assert legs[-1]["t"][1] == pytest.approx(one["statistics"]["duration_s"], abs=0.2)
        assert sum(leg["row"] > 0 for leg in legs) == one["statistics"]["rows"]


@pytest.mark.slow
async def test_nothing_is_stored_by_comparing(rig: Rig) -> None:
    await compared(rig)
    assert rig.book.list(rig.person(Role.PLANNER)) == []


@pytest.mark.slow
async def test_the_ground_of_the_drawing_adds_up_to_the_field(rig: Rig) -> None:
    drawing = next(one for one in await compared(rig) if one.get("state") == "planned")["drawing"]

    def area(polygons: list[list[list[list[float]]]]) -> float:
        return sum(shapely.Polygon(rings[0], rings[1:]).area for rings in polygons)

    ground = drawing["ground"]
    whole = area([drawing["places"]["parcel"]]) - area(drawing["places"]["obstacles"])
    assert area(ground["worked"]) + area(ground["missed"]) == pytest.approx(whole, rel=0.01)


class Picky(HerePlanner):
    """Plans only row by row."""

    async def candidate(self, wish: PlanWish, tell: Tell = nobody) -> Candidate:
        """Return the plan or refuse."""
        if wish.pattern is not Pattern.ROW_BY_ROW:
            raise PlanRefused("turn_does_not_fit", "The turn does not fit.", "headland_passes")
        return plan_candidate(wish)


async def test_one_order_that_cannot_be_driven_does_not_hide_the_others(rig: Rig) -> None:
    book = with_planner(rig, Picky())
    stream = await book.candidates(rig.person(Role.PLANNER), PlanOrder("field-1", "weeder-01", 3.0))
    answers = [one async for one in stream]
    refused = {one.pattern: one.refusal.text for one in answers if one.refusal}
    assert set(refused) == set(Pattern) - {Pattern.ROW_BY_ROW}
    assert set(refused.values()) == {"The turn does not fit."}
    assert [one.pattern for one in answers if one.candidate] == [Pattern.ROW_BY_ROW]


class Slow:
    """Never ends, and notes when it is given up."""

    def __init__(self) -> None:
        self.has_begun = asyncio.Event()
        self.is_given_up = False

    async def plan(self, wish: PlanWish, tell: Tell = nobody) -> PlannedMission:
        """Not asked here."""
        raise NotImplementedError

    async def candidate(self, wish: PlanWish, tell: Tell = nobody) -> Candidate:
        """Wait for ever."""
        self.has_begun.set()
        try:
            await asyncio.Event().wait()
        except asyncio.CancelledError:
            self.is_given_up = True
            raise
        raise AssertionError


class Telling(Picky):
    """Tells how far it is, and where it planned."""

    async def candidate(self, wish: PlanWish, tell: Tell = nobody) -> Candidate:
        """Return the plan or refuse."""
        tell(0.4, "Row 4 of 10")
        return made_here(await super().candidate(wish), "the planner service did not answer in 5 s")

    async def plan(self, wish: PlanWish, tell: Tell = nobody) -> PlannedMission:
        """Return the plan."""
        return made_here(await super().plan(wish), "the planner service did not answer in 5 s")


async def test_how_far_a_planner_is_comes_before_its_answer_in_every_order(rig: Rig) -> None:
    book = with_planner(rig, Telling())
    stream = await book.candidates(rig.person(Role.PLANNER), PlanOrder("field-1", "weeder-01", 3.0))
    lines = [json.loads(line) async for line in candidate_stream(stream).body_iterator if isinstance(line, bytes)]
    told = [(one["pattern"], one["state"]) for one in lines if "pattern" in one]
    assert told[::2] == [(pattern, "progress") for pattern, _ in told[::2]]
    assert [pattern for pattern, _ in told[::2]] == [pattern for pattern, _ in told[1::2]]
    assert {state for _, state in told[1::2]} == {"planned", "refused"}
    step = next(one for one in lines if one["state"] == "progress")
    assert (step["share"], step["text"]) == (0.4, "Row 4 of 10")


@pytest.mark.slow
async def test_where_a_mission_was_planned_stands_in_its_record_and_in_the_audit(rig: Rig) -> None:
    book = with_planner(rig, Telling())
    mission = await book.plan(rig.person(Role.PLANNER), PlanOrder("field-1", "weeder-01", 3.0))
    text = "Planned on this server: the planner service did not answer in 5 s."
    assert mission.statistics["planned_at"] == {"where": "here", "text": text}
    (entry,) = await book.log(rig.person(Role.PLANNER), mission.id)
    assert entry.why == text
    assert rig.audit.entries[-1].data["planned_at"] == "here"
    own = await rig.book.plan(rig.person(Role.PLANNER), PlanOrder("field-1", "weeder-01", 3.0))
    assert "planned_at" not in own.statistics
    assert (await book.log(rig.person(Role.PLANNER), own.id))[0].why == "Planned."


async def test_leaving_gives_the_planning_up(rig: Rig) -> None:
    planner = Slow()
    book = with_planner(rig, planner)
    answers = await book.candidates(rig.person(Role.PLANNER), PlanOrder("field-1", "weeder-01", 3.0))
    reading = asyncio.create_task(anext(answers))  # type: ignore[arg-type]
    await planner.has_begun.wait()
    reading.cancel()
    await asyncio.gather(reading, return_exceptions=True)
    assert planner.is_given_up


@pytest.mark.slow
async def test_a_cancelled_candidate_frees_the_process_for_the_next() -> None:
    planner = PlanningProcess()
    try:
        work = asyncio.create_task(planner.candidate(wish(width_m=0.06)))
        await asyncio.sleep(0)
        work.cancel()
        await asyncio.gather(work, return_exceptions=True)
        assert (await planner.candidate(wish())).statistics["rows"] > 5
    finally:
        await asyncio.to_thread(planner.close)


def with_planner(rig: Rig, planner: Any) -> MissionBook:
    """Return a book that plans with this."""
    return MissionBook(
        MissionParts(
            rig.missions,
            rig.features,
            rig.database,
            rig.fleet,
            planner,
            rig.audit,
            rig.authorize,
            rig.clock,
            Maps(rig.database, rig.clock),
        )
    )


@pytest.mark.parametrize(
    ("change", "status", "code"),
    [
        ({"pattern": "zigzag"}, 422, "invalid"),
        ({"overlap": 0.9}, 422, "invalid"),
        ({"treatments": [{"dose": 1.0}]}, 422, "invalid"),
        ({"treatments": [{"dose": 3.0, "feature_id": "field-1"}]}, 422, "invalid"),
        ({"treatments": [{"dose": 0.0, "feature_id": "nowhere"}]}, 404, "not_found"),
        ({"treatments": [{"dose": 0.0, "feature_id": "pylon-1"}]}, 422, "bad_treatment"),
        ({"field_id": "nowhere"}, 404, "not_found"),
    ],
)
async def test_what_makes_no_sense_is_refused_before_anything_is_planned(
    rig: Rig, change: dict[str, Any], status: int, code: str
) -> None:
    async with rig.client(Role.PLANNER) as client:
        answer = await client.post("/missions/candidates", json={**PLAN, **change})
    assert (answer.status_code, answer.json()["code"]) == (status, code)


async def test_a_speed_the_machine_cannot_drive_is_said_for_each_order(rig: Rig) -> None:
    lines = await compared(rig, row_speed_mps=9.0)
    assert {(one["code"], one["field"]) for one in lines if one.get("state") == "refused"} == {
        ("bad_speed", "row_speed_mps")
    }


async def test_comparing_needs_the_right_to_plan(rig: Rig) -> None:
    async with rig.client(Role.OPERATOR) as client:
        assert (await client.post("/missions/candidates", json=PLAN)).status_code == 403


async def test_a_treatment_area_of_the_map_reaches_the_robots_document(rig: Rig) -> None:
    corners = lon_lat((0, 0), (40, 0), (40, 14), (0, 14), (0, 0))
    rig.features.put(
        [Feature("wet", FARM, "treatment", "Wet corner", {"type": "Polygon", "coordinates": [corners]}, {"dose": 0.5})]
    )
    areas = [{"feature_id": "wet", "dose": 0.5}]
    async with rig.client(Role.PLANNER) as client:
        made = (await client.post("/missions/plan", json={**PLAN, "row_bearing_deg": 0.0, "treatments": areas})).json()
        document = (await client.get(f"/missions/{made['id']}/document")).json()
        offered = (await client.get("/fields")).json()["areas"]
    doses = {segment.get("dose", 1.0) for segment in document["segments"] if segment["tool_on"]}
    assert doses == {1.0, 0.5}
    assert [(one["id"], one["kind"]) for one in offered] == [("wet", "treatment")]


async def test_an_area_drawn_for_one_plan_is_no_part_of_the_map_and_goes_with_the_missions_geometry(rig: Rig) -> None:
    corners = lon_lat((0, 0), (40, 0), (40, 14), (0, 14), (0, 0))
    area = {"geometry": {"type": "Polygon", "coordinates": [corners]}, "dose": 0.0}
    async with rig.client(Role.PLANNER) as client:
        made = (await client.post("/missions/plan", json={**PLAN, "row_bearing_deg": 0.0, "treatments": [area]})).json()
        shown = (await client.get(f"/missions/{made['id']}/map.geojson")).json()
        offered = (await client.get("/fields")).json()["areas"]
    assert offered == []
    assert "treatment" not in made["statistics"]
    doses = [one for one in shown["features"] if one["properties"]["kind"] == "dose"]
    assert [(one["properties"]["dose"], one["geometry"]) for one in doses] == [(0.0, area["geometry"])]


@pytest.mark.slow
async def test_a_place_of_the_drawing_is_known_on_earth_to_a_centimetre(rig: Rig) -> None:
    drawing = next(one for one in await compared(rig) if one.get("state") == "planned")["drawing"]
    frame = drawing["frame"]
    corners = drawing["places"]["parcel"][0][:-1]
    degrees = np.array(frame["lon_lat"]) + (np.array(corners) - frame["xy_m"]) @ np.array(frame["degrees_per_m"]).T
    wanted = np.array(parcel_geometry()["coordinates"][0][:-1])
    for place in degrees:
        nearest = min(FRAME.to_local(wanted), key=lambda one: float(np.hypot(*(one - FRAME.to_local([place])[0]))))
        assert np.hypot(*(nearest - FRAME.to_local([place])[0])) < 0.02
