"""The map over REST: drafts, transactions, operations, checks, publishing, versions."""

from __future__ import annotations

import json
from typing import Any

import httpx
import pytest

from hmi.commands.plan_wish import PlanOrder
from hmi.domain.role import Role
from hmi.store.features import Feature
from hmi.store.map_tables import MapVersionRow
from tests.hmi.maps.conftest import MapRig
from tests.hmi.missions.rig import FARM, OTHER_FARM, lon_lat, parcel_geometry


def parcel(feature_id: str, x_m: float, *, side_m: float = 40.0, **own: Any) -> dict[str, Any]:
    """Return a square parcel, metres east of the farm's middle."""
    corners = lon_lat((x_m, 100), (x_m + side_m, 100), (x_m + side_m, 140), (x_m, 140), (x_m, 100))
    properties = {"id": feature_id, "kind": "parcel", "name": feature_id.title(), **own}
    return {
        "type": "Feature", "id": feature_id, "properties": properties,
        "geometry": {"type": "Polygon", "coordinates": [corners]},
    }  # fmt: skip


async def opened(client: httpx.AsyncClient) -> dict[str, dict[str, Any]]:
    """Begin a draft; return its features by id."""
    draft = (await client.post("/map/draft", json={})).json()
    return {one["id"]: one for one in draft["features"]["features"]}


def one_change(ref: str, before: Any, after: Any, label: str = "A change") -> dict[str, Any]:
    """Return a transaction of one feature."""
    return {"id": ref, "label": label, "changes": [{"id": (before or after)["id"], "before": before, "after": after}]}


async def without_bow_tie(client: httpx.AsyncClient) -> None:
    """Take out the field that crosses itself and keeps the map from being published."""
    there = await opened(client)
    answer = await client.post("/map/draft/transactions", json=one_change("ref-bowtie", there["bow-tie"], None))
    assert answer.status_code == 200, answer.text


async def test_what_was_there_before_is_version_1_and_nothing_is_a_draft_yet(rig: MapRig) -> None:
    async with rig.browser(Role.VIEWER) as client:
        whole = (await client.get("/map")).json()
    assert (whole["version"], whole["draft"]) == (1, None)
    assert {one["id"] for one in whole["features"]["features"]} >= {"field-1", "road-1", "home-1"}


async def test_a_planner_changes_takes_back_does_again_and_publishes(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await without_bow_tie(client)
        new = parcel("west", -200, crop="Maize")
        answer = (
            await client.post("/map/draft/transactions", json=one_change("ref-west", None, new, "Drew West"))
        ).json()
        [stored] = answer["changes"]
        assert stored["after"]["properties"]["crop"] == "Maize"
        assert answer["draft"]["undo"] == "Drew West"
        assert answer["draft"]["log"][0]["names"] == [new["properties"]["name"]]
        taken = (await client.post("/map/draft/undo")).json()
        assert taken["changes"] == [{"id": "west", "before": stored["after"], "after": None}]
        assert taken["draft"]["redo"] == "Drew West"
        again = (await client.post("/map/draft/redo")).json()
        assert again["changes"] == [stored]
        diff = (await client.get("/map/draft/diff")).json()
        assert (diff["base_version"], {(d["id"], d["what"]) for d in diff["differences"]}) == (
            1, {("bow-tie", "removed"), ("west", "added")},
        )  # fmt: skip
        published = (await client.post("/map/draft/publish", json={"note": "West  added"})).json()
        assert (published["version"], published["note"]) == (2, "West added")
        whole = (await client.get("/map")).json()
        assert (whole["version"], whole["draft"]) == (2, None)
        assert "west" in {one["id"] for one in whole["features"]["features"]}
    assert [entry.outcome for entry in rig.audit.entries] == ["published"]
    assert rig.events[-1] == {"kind": "map", "what": "published", "version": 2}
    assert "west" in {one.id for one in rig.features.all("farm")}


async def test_a_blocking_finding_keeps_the_map_back_and_its_fix_is_an_operation(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await opened(client)
        checks = (await client.get("/map/draft/checks")).json()
        assert checks["blocks"] >= 1
        [crossing] = [one for one in checks["findings"] if one["feature_id"] == "bow-tie" and one["level"] == 2]
        refused = await client.post("/map/draft/publish", json={})
        assert refused.status_code == 409
        assert refused.json()["code"] == "blocked"
        fix = crossing["fix"]
        body = {"id": "ref-untangle", "op": fix["op"], "features": fix["features"], "args": fix["args"]}
        fixed = await client.post("/map/draft/operations", json=body)
        assert fixed.status_code == 200, fixed.text
        assert (await client.post("/map/draft/operations", json=body)).json()["changes"] == fixed.json()["changes"]
        assert (await client.get("/map/draft/checks")).json()["blocks"] == 0
        assert (await client.post("/map/draft/publish", json={})).status_code == 200


async def test_what_the_editor_saw_must_be_there(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        there = await opened(client)
        field = there["field-1"]
        old = {**field, "properties": {**field["properties"], "name": "Something older"}}
        refused = await client.post("/map/draft/transactions", json=one_change("ref-00001", old, None))
        assert (refused.status_code, refused.json()["code"], refused.json()["ids"]) == (409, "changed", ["field-1"])


async def test_one_person_edits_and_a_supervisor_may_take_over(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as planner, rig.browser(Role.SUPERVISOR) as supervisor:
        await opened(planner)
        refused = await supervisor.post("/map/draft", json={})
        assert (refused.status_code, refused.json()["by"]) == (423, "Planner Person")
        assert "Planner Person edits this map" in refused.json()["text"]
        shown = (await supervisor.get("/map")).json()["draft"]
        assert (shown["is_mine"], shown["editor"]["name"]) == (False, "Planner Person")
        taken = (await supervisor.post("/map/draft", json={"take": True})).json()
        assert taken["is_mine"] is True
        late = await planner.post("/map/draft/transactions", json=one_change("ref-00001", None, parcel("west", -200)))
        assert late.status_code == 423
        assert (await planner.post("/map/draft", json={"take": True})).status_code == 403


async def test_a_shrunken_map_is_published_only_when_that_is_meant(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        there = await opened(client)
        gone = [{"id": key, "before": raw, "after": None} for key, raw in there.items()]
        body = {"id": "ref-00001", "label": "All gone", "changes": gone}
        assert (await client.post("/map/draft/transactions", json=body)).status_code == 200
        refused = await client.post("/map/draft/publish", json={})
        assert (refused.status_code, refused.json()["code"]) == (409, "shrinks")
        assert "0 features" in refused.json()["text"]
        assert (await client.post("/map/draft/publish", json={"is_shrinking_ok": True})).status_code == 200


async def test_a_field_dragged_to_almost_nothing_is_published_only_when_that_is_meant(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        there = await opened(client)
        field, bow_tie = there["field-1"], there["bow-tie"]
        tiny = parcel("field-1", 0, side_m=10)["geometry"]
        changes = [
            {
                "id": "bow-tie",
                "before": bow_tie,
                "after": {**bow_tie, "geometry": parcel("b", 60, side_m=10)["geometry"]},
            },
            {"id": "field-1", "before": field, "after": {**field, "geometry": tiny}},
        ]
        body = {"id": "ref-00001", "label": "Dragged", "changes": changes}
        assert (await client.post("/map/draft/transactions", json=body)).status_code == 200
        refused = await client.post("/map/draft/publish", json={})
        assert (refused.status_code, refused.json()["code"]) == (409, "shrinks")
        assert "have 800 m²" in refused.json()["text"]
        assert (await client.post("/map/draft/publish", json={"is_shrinking_ok": True})).status_code == 200


@pytest.mark.slow
async def test_an_older_version_comes_back_as_a_draft(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await without_bow_tie(client)
        await client.post("/map/draft/publish", json={"note": "No bow tie", "is_shrinking_ok": True})
        versions = (await client.get("/map/versions")).json()["versions"]
        assert [one["version"] for one in versions] == [2, 1]
        draft = (await client.post("/map/versions/1/restore")).json()
        assert "bow-tie" in {one["id"] for one in draft["features"]["features"]}
        assert draft["undo"] == "Back to version 1"
        assert (await client.post("/map/versions/9/restore")).status_code == 404


async def test_a_name_is_as_long_as_a_robot_and_the_database_take_it(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await without_bow_tie(client)
        long = parcel("long", -200, name="L" * 81)
        answer = await client.post("/map/draft/transactions", json=one_change("ref-long", None, long))
        assert answer.status_code == 422
        assert answer.json()["text"].endswith("Its name has 81 letters, a name has at most 80. Shorten it.")
        fits = parcel("long", -200, name="L" * 80)
        answer = await client.post("/map/draft/transactions", json=one_change("ref-fits", None, fits))
        assert answer.status_code == 200


async def test_a_field_with_a_longer_name_of_before_is_still_changed_published_and_planned(rig: MapRig) -> None:
    name = "Das Feld hinter der dritten Hecke links, " * 3
    rig.features.put([Feature("old", FARM, "parcel", name, parcel_geometry(), {"row_bearing_deg": 90.0})])
    async with rig.browser(Role.PLANNER) as client:
        await without_bow_tie(client)
        there = (await opened(client))["old"]
        after = {**there, "properties": {**there["properties"], "crop": "Maize"}}
        answer = await client.post("/map/draft/transactions", json=one_change("ref-crop", there, after))
        assert answer.status_code == 200, answer.text
        answer = await client.post("/map/draft/publish", json={})
        assert answer.status_code == 200, answer.text
    mission = await rig.book.plan(rig.person(Role.PLANNER), PlanOrder("old", "weeder-01", 3.0))
    assert mission.field_name == name[:80]


def barn(**own: Any) -> dict[str, Any]:
    """Return a building."""
    one = parcel("barn", -200)
    return {**one, "properties": {"id": "barn", "kind": "building", "name": "Barn", **own}}


@pytest.mark.parametrize("height", [0, -1, 300.5, "12", True])
async def test_a_height_that_is_none_is_refused_in_words(rig: MapRig, height: Any) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await opened(client)
        answer = await client.post("/map/draft/transactions", json=one_change("ref-barn", None, barn(height_m=height)))
    assert (answer.status_code, answer.json()["code"]) == (422, "bad_height_m")
    assert answer.json()["text"].startswith("Barn: Height is ")
    assert answer.json()["text"].endswith("Give a number above 0, at most 300 m.")


async def test_a_height_is_published_told_in_the_diff_and_kept_in_its_history(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await without_bow_tie(client)
        low, high = barn(height_m=8), barn(height_m=12.5)
        await client.post("/map/draft/transactions", json=one_change("ref-low-1", None, low))
        await client.post("/map/draft/publish", json={"is_shrinking_ok": True})
        there = (await opened(client))["barn"]
        answer = await client.post("/map/draft/transactions", json=one_change("ref-high-1", there, high))
        assert answer.status_code == 200, answer.text
        diff = (await client.get("/map/draft/diff")).json()["differences"]
        assert [one["text"] for one in diff] == ["Height 8.00 to 12.50 m"]
        await client.post("/map/draft/publish", json={"is_shrinking_ok": True})
        [past] = [one for one in (await client.get("/map/features/barn/history")).json()["entries"] if one["before"]]
        assert (past["label"], past["before"], past["after"]) == ("Height", 8, 12.5)
        file = await client.get("/map/export?format=geojson")
    assert [f["properties"].get("height_m") for f in file.json()["features"] if f["id"] == "barn"] == [12.5]


async def test_a_map_of_before_with_some_other_height_in_it_is_still_changed_checked_and_exported(rig: MapRig) -> None:
    rig.features.put([Feature("old", FARM, "building", "Old barn", parcel_geometry(), {"height_m": "two floors"})])
    async with rig.browser(Role.PLANNER) as client:
        there = (await opened(client))["old"]
        after = {**there, "properties": {**there["properties"], "category": "Barn"}}
        answer = await client.post("/map/draft/transactions", json=one_change("ref-use-1", there, after))
        assert answer.status_code == 200, answer.text
        for path in ("/map/draft/checks", "/map/draft/diff", "/map/export?format=kml"):
            assert (await client.get(path)).status_code == 200, path
        wrong = {**after, "properties": {**after["properties"], "height_m": "three floors"}}
        answer = await client.post("/map/draft/transactions", json=one_change("ref-floors", after, wrong))
        assert answer.status_code == 422


async def test_a_discarded_draft_changes_nothing(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await without_bow_tie(client)
        assert (await client.delete("/map/draft")).status_code == 204
        whole = (await client.get("/map")).json()
        assert whole["draft"] is None
        assert "bow-tie" in {one["id"] for one in whole["features"]["features"]}
        assert (await client.delete("/map/draft")).status_code == 404


@pytest.mark.parametrize(
    ("change", "status"),
    [
        ({"kind": "rocket"}, 422),
        ({"row_spacing_m": -1}, 422),
        ({"id": "another"}, 422),
    ],
)
async def test_what_is_no_feature_is_refused_with_a_sentence(rig: MapRig, change: dict[str, Any], status: int) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await opened(client)
        new = parcel("west", -200)
        new = {**new, "properties": {**new["properties"], **change}}
        answer = await client.post("/map/draft/transactions", json=one_change("ref-00001", None, new))
        assert answer.status_code == status
        assert answer.json()["text"].endswith(".")


@pytest.mark.parametrize("role", [Role.VIEWER, Role.OPERATOR])
async def test_who_may_not_edit_only_looks(rig: MapRig, role: Role) -> None:
    async with rig.browser(role) as client:
        assert (await client.get("/map")).status_code == 200
        assert (await client.get("/map/draft/checks")).status_code == 200
        for path, body in {
            "/map/draft": {},
            "/map/draft/undo": {},
            "/map/draft/publish": {},
            "/map/versions/1/restore": {},
            "/map/draft/transactions": one_change("ref-00001", None, parcel("west", -200)),
            "/map/draft/operations": {"id": "ref-00001", "op": "clean", "features": ["field-1"], "args": {}},
        }.items():
            assert (await client.post(path, json=body)).status_code == 403, path
        assert (await client.delete("/map/draft")).status_code == 403


async def test_another_farm_has_its_own_map(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client, rig.browser(Role.PLANNER, OTHER_FARM) as other:
        await opened(client)
        whole = (await other.get("/map")).json()
        assert (whole["version"], whole["draft"], whole["features"]["features"]) == (0, None, [])


async def test_a_file_is_read_looked_at_and_taken_in_one_step(rig: MapRig) -> None:
    far = parcel("field-1", -200, crop="Maize")
    bad = {"type": "Feature", "properties": {"name": "Nothing"}, "geometry": None}
    file = json.dumps({"type": "FeatureCollection", "features": [far, bad]}).encode()
    async with rig.browser(Role.PLANNER) as client:
        read = await client.post("/map/imports?name=farm.geojson", content=file)
        assert read.status_code == 201, read.text
        found = read.json()
        [item], [skipped] = found["items"], found["skipped"]
        assert (found["format"], item["kind"], round(item["area_m2"])) == ("geojson", "parcel", 1600)
        assert skipped["why"].endswith(".")
        await opened(client)
        body = {"id": "ref-import", "items": [item["n"]], "kinds": {}}
        taken = (await client.post(f"/map/imports/{found['id']}/take", json=body)).json()
        [change] = taken["changes"]
        assert (change["id"], change["before"]) == ("field-1-2", None), "the map has a field-1 already"
        assert change["after"]["properties"]["crop"] == "Maize"
        assert taken["draft"]["undo"] == "Imported 1 feature, farm.geojson"
        undone = (await client.post("/map/draft/undo")).json()
        assert [one["after"] for one in undone["changes"]] == [None]
        assert (await client.post("/map/imports/none/take", json={**body, "id": "ref-00002"})).status_code == 404


async def test_a_bad_file_is_one_sentence(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        answer = await client.post("/map/imports?name=farm.kml", content=b"<kml>")
    assert answer.status_code == 422
    assert answer.json()["text"].endswith(".")


@pytest.mark.parametrize("file_format", ["geojson", "kml", "kmz", "shapefile", "isoxml", "gpx", "fiware"])
async def test_the_map_goes_out_as_a_file_and_comes_back(rig: MapRig, file_format: str) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await without_bow_tie(client)
        answer = await client.get(f"/map/export?format={file_format}&of=draft")
        assert answer.status_code == 200, answer.text
        name = answer.headers["content-disposition"].split('"')[1]
        read = await client.post(f"/map/imports?name={name}", content=answer.content)
        assert read.status_code == 201, read.text
        assert "Home field" in {item["name"] for item in read.json()["items"]}


async def test_a_draft_says_for_how_long_its_lock_holds_still(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as planner, rig.browser(Role.VIEWER) as viewer:
        assert (await planner.post("/map/draft", json={})).json()["left_s"] == 1800
        rig.clock.advance(600)
        assert (await viewer.get("/map")).json()["draft"]["left_s"] == 1200
        rig.clock.advance(7200)
        assert (await viewer.get("/map")).json()["draft"]["left_s"] == 0


async def test_a_draft_on_an_older_version_is_told_what_was_published_meanwhile(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await without_bow_tie(client)
        whole = (await client.get("/map/draft/diff")).json()
        assert (whole["base_version"], whole["newest_version"], whole["meanwhile"]) == (1, 1, [])
        there = rig.maps.features_of(FARM, 1)
        there["field-1"]["properties"]["crop"] = "Oats"
        row = MapVersionRow(farm_id=FARM, number=2, by="Ben", note="Oats", published_at=rig.clock.utc(), features=there)
        with rig.database.write() as session:  # by another way than through this draft
            session.add(row)
        whole = (await client.get("/map/draft/diff")).json()
        assert (whole["base_version"], whole["newest_version"]) == (1, 2)
        assert [(one["id"], one["what"]) for one in whole["differences"]] == [("bow-tie", "removed")]
        assert [(one["id"], one["text"]) for one in whole["meanwhile"]] == [("field-1", "Crop set to Oats")]
        refused = await client.post("/map/draft/publish", json={"is_shrinking_ok": True})
        assert (refused.status_code, refused.json()["code"]) == (409, "outdated")
