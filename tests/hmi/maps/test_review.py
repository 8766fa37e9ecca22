"""Looking at the map over REST: previews, history, walks, imports under way, and what a format cannot carry."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import httpx
import pytest

from hmi.domain.role import Role
from hmi.map_files.imported import Imported
from hmi.map_files.progress import Progress, Report
from hmi.map_files.reader import read_map
from tests.hmi.maps.conftest import MapRig
from tests.hmi.maps.test_rest import one_change, opened, parcel, without_bow_tie
from tests.hmi.missions.rig import OTHER_FARM, lon_lat


async def publish(client: httpx.AsyncClient, note: str = "") -> None:
    answer = await client.post("/map/draft/publish", json={"note": note, "is_shrinking_ok": True})
    assert answer.status_code == 200, answer.text


async def test_a_preview_tells_what_comes_out_and_changes_nothing(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        before = await opened(client)
        body = {"op": "buffer", "features": ["field-1"], "args": {"distance_m": -2}}
        found = (await client.post("/map/draft/preview", json=body)).json()
        assert found["effect"]["area_after_m2"] < found["effect"]["area_before_m2"]
        [change] = found["changes"]
        assert (change["id"], change["after"]["geometry"]["type"], found["refused"]) == ("field-1", "Polygon", None)
        assert await opened(client) == before


async def test_a_preview_that_does_not_fit_says_why(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await opened(client)
        body = {"op": "buffer", "features": ["field-1"], "args": {"distance_m": -900}}
        found = (await client.post("/map/draft/preview", json=body)).json()
        assert (found["refused"]["code"], found["effect"], found["changes"]) == ("vanishes", None, [])
    async with rig.browser(Role.OPERATOR) as client:
        assert (await client.post("/map/draft/preview", json=body)).status_code == 403


async def test_what_changed_about_a_parcel_is_read_from_the_published_maps(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await without_bow_tie(client)
        there = await opened(client)
        field = there["field-1"]
        sown = {**field, "properties": {**field["properties"], "crop": "Oats", "valid_from": {"crop": "2026-04-02"}}}
        await client.post("/map/draft/transactions", json=one_change("ref-00002", field, sown))
        await publish(client, "Oats sown")
        there = await opened(client)
        grown = {**there["field-1"], "properties": {**there["field-1"]["properties"], "status": "BBCH 12"}}
        await client.post("/map/draft/transactions", json=one_change("ref-00003", there["field-1"], grown))
        await publish(client)
    async with rig.browser(Role.VIEWER) as client:
        entries = (await client.get("/map/features/field-1/history")).json()["entries"]
        assert (await client.get("/map/features/never/history")).status_code == 404
    stage, crop = entries[:2]
    assert (stage["label"], stage["before"], stage["after"], stage["version"]) == ("Growth stage", None, "BBCH 12", 3)
    assert (crop["key"], crop["after"], crop["version"], crop["by"]) == ("crop", "Oats", 2, "Planner Person")
    assert (crop["valid_from"], crop["note"]) == ("2026-04-02", "Oats sown")
    async with rig.browser(Role.PLANNER, OTHER_FARM) as other:
        assert (await other.get("/map/features/field-1/history")).status_code == 404


async def test_a_parcel_too_narrow_for_the_chosen_robot_is_found(rig: MapRig) -> None:
    rig.widths["weeder-01"] = 3.2
    narrow = parcel("narrow", -200)
    corners = lon_lat((-200, 100), (-198, 100), (-198, 180), (-200, 180), (-200, 100))
    narrow["geometry"]["coordinates"] = [corners]
    async with rig.browser(Role.PLANNER) as client:
        await opened(client)
        await client.post("/map/draft/transactions", json=one_change("ref-00001", None, narrow))
        codes = [one["code"] for one in (await client.get("/map/draft/checks")).json()["findings"]]
        assert "too_narrow" not in codes
        found = (await client.get("/map/draft/checks?robot=weeder-01")).json()["findings"]
    assert [one["feature_id"] for one in found if one["code"] == "too_narrow"] == ["narrow"]


def walked(*places: tuple[float, float], accuracy_m: float = 0.02) -> list[dict[str, float]]:
    """Return positions, metres from the farm's middle, a minute apart."""
    return [
        {"lon": lon, "lat": lat, "accuracy_m": accuracy_m, "at_s": 60.0 * n}
        for n, (lon, lat) in enumerate(lon_lat(*places))
    ]


async def test_positions_walked_come_back_as_an_outline_weighed_by_accuracy(rig: MapRig) -> None:
    points = walked((0, 0), (50, 0), (100, 0), (100, 60), (0, 60))
    async with rig.browser(Role.PLANNER) as client:
        found = (await client.post("/map/walks", json={"points": points})).json()
        assert (len(found["coordinates"]), found["kept"], found["accuracy_m"]) == (5, 5, 0.02)
        few = await client.post("/map/walks", json={"points": points[:2]})
        assert (few.status_code, few.json()["code"]) == (422, "too_few_points")
    async with rig.browser(Role.VIEWER) as client:
        assert (await client.post("/map/walks", json={"points": points})).status_code == 403


class SlowReader:
    """Tells that it is half done, then waits to be let go or given up."""

    def __init__(self) -> None:
        self.is_half = asyncio.Event()
        self.may_go_on = asyncio.Event()
        self.was_given_up = False

    async def read(self, data: bytes, name: str, on_progress: Report | None = None) -> Imported:
        if on_progress is not None:
            on_progress(Progress(0.5, 120))
        self.is_half.set()
        try:
            await self.may_go_on.wait()
        except asyncio.CancelledError:
            self.was_given_up = True
            raise
        return read_map(data, name)


FILE = json.dumps({"type": "FeatureCollection", "features": [parcel("far", -200)]}).encode()


async def test_an_import_says_how_far_it_is_and_is_given_up_on_demand(rig: MapRig) -> None:
    slow = SlowReader()
    rig.read_with(slow)
    async with rig.browser(Role.PLANNER) as client, rig.browser(Role.PLANNER, OTHER_FARM) as other:
        asked = asyncio.create_task(client.post("/map/imports?name=a.geojson&ref=ref-import-1", content=FILE))
        await slow.is_half.wait()
        assert (await client.get("/map/imports/ref-import-1/progress")).json() == {"share": 0.5, "shapes": 120}
        assert (await other.get("/map/imports/ref-import-1/progress")).status_code == 404
        assert (await other.delete("/map/imports/ref-import-1")).status_code == 404
        assert (await client.delete("/map/imports/ref-import-1")).status_code == 204
        answer = await asked
        assert (answer.status_code, answer.json()["code"], slow.was_given_up) == (422, "cancelled", True)
        assert (await client.get("/map/imports/ref-import-1/progress")).status_code == 404


async def test_an_import_that_nobody_waits_for_any_more_is_given_up(rig: MapRig) -> None:
    slow = SlowReader()
    exchange = rig.read_with(slow)
    work = asyncio.create_task(exchange.read(rig.person(Role.PLANNER), FILE, "a.geojson"))
    await slow.is_half.wait()
    work.cancel()
    with pytest.raises(asyncio.CancelledError):
        await work
    await asyncio.sleep(0)
    assert slow.was_given_up


async def test_a_read_file_can_be_listed_without_its_shapes_and_forgotten(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        found = (await client.post("/map/imports?name=a.geojson&geometry=false", content=FILE)).json()
        assert "geometry" not in found["items"][0]
        assert round(found["items"][0]["area_m2"]) == 1600
        await opened(client)
        assert (await client.delete(f"/map/imports/{found['id']}")).status_code == 204
        body: dict[str, Any] = {"id": "ref-import", "items": [0], "kinds": {}}
        assert (await client.post(f"/map/imports/{found['id']}/take", json=body)).status_code == 404


async def test_what_a_format_cannot_carry_is_told_before_the_export(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        for name in ("geojson", "kml", "kmz", "shapefile", "isoxml", "gpx"):
            assert (await client.get(f"/map/export/losses?format={name}")).json() == {"left_out": [], "cut": []}
        lost = (await client.get("/map/export/losses?format=fiware")).json()["left_out"]
    assert lost, "FIWARE has no model for a home"
