"""A farm that goes out as a file and is taken in again: every feature with its id, and rows with their field."""

from __future__ import annotations

import json
from typing import Any

import httpx
import pytest

from hmi.domain.role import Role
from tests.hmi.maps.conftest import MapRig
from tests.hmi.maps.test_rest import opened, parcel, without_bow_tie
from tests.hmi.missions.rig import OTHER_FARM, lon_lat

FORMATS = ["geojson", "kml", "kmz", "shapefile", "isoxml", "gpx"]
LONG_ID = "a-field-that-somebody-gave-the-longest-id-that-there-can-be-64_x"
LONG_NAME = "Das Feld hinter der dritten Hecke, wie es der Großvater genannt hat – Älmhult, N"  # as long as may be


def rows(feature_id: str, parcel_id: str, y_m: float = 120.0) -> dict[str, Any]:
    """Return an A-B line that names its field."""
    properties = {"id": feature_id, "kind": "rows", "name": "A-B", "type": "a-b", "parcel_id": parcel_id}
    line = {"type": "LineString", "coordinates": lon_lat((-190, y_m), (-170, y_m))}
    return {"type": "Feature", "id": feature_id, "properties": properties, "geometry": line}


FARM = [parcel("north_2", -200, crop="Maize"), rows("ab_1", "north_2"), parcel(LONG_ID, -300),
        {**(named := parcel("named", -400)), "properties": {**named["properties"], "name": LONG_NAME}}]  # fmt: skip

OWN = [one["id"] for one in FARM]


async def drawn(client: httpx.AsyncClient, features: list[dict[str, Any]]) -> None:
    """Put features into a fresh draft of sound ones."""
    await without_bow_tie(client)
    changes = [{"id": one["id"], "before": None, "after": one} for one in features]
    answer = await client.post(
        "/map/draft/transactions", json={"id": "ref-drawn", "label": "Drawn", "changes": changes}
    )
    assert answer.status_code == 200, answer.text


async def exported(client: httpx.AsyncClient, file_format: str) -> tuple[str, bytes]:
    """Return name and bytes of the draft as a file."""
    answer = await client.get(f"/map/export?format={file_format}&of=draft")
    assert answer.status_code == 200, answer.text
    return answer.headers["content-disposition"].split('"')[1], answer.content


async def taken(client: httpx.AsyncClient, name: str, data: bytes, ref: str = "ref-taken") -> dict[str, dict[str, Any]]:
    """Take a whole file over; return what came in, by its new ids."""
    read = (await client.post(f"/map/imports?name={name}", content=data)).json()
    body = {"id": ref, "items": [one["n"] for one in read["items"]], "kinds": {}}
    answer = await client.post(f"/map/imports/{read['id']}/take", json=body)
    assert answer.status_code == 200, answer.text
    return {one["id"]: one["after"] for one in answer.json()["changes"]}


@pytest.mark.parametrize("file_format", FORMATS)
async def test_a_farm_comes_back_into_an_empty_map_as_it_was(rig: MapRig, file_format: str) -> None:
    async with rig.browser(Role.PLANNER) as client, rig.browser(Role.PLANNER, OTHER_FARM) as other:
        await drawn(client, FARM)
        there = await opened(client)
        assert await opened(other) == {}
        await taken(other, *await exported(client, file_format))
        back = await opened(other)
        assert back.keys() == there.keys()
        assert {key: back[key] for key in OWN} == {key: there[key] for key in OWN}


async def test_fiware_keeps_the_ids_it_has_a_model_for(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client, rig.browser(Role.PLANNER, OTHER_FARM) as other:
        await drawn(client, FARM)
        there = await opened(client)
        await opened(other)
        back = await taken(other, *await exported(client, "fiware"))
        assert [back[key] for key in OWN if key != "ab_1"] == [there[key] for key in OWN if key != "ab_1"]


@pytest.mark.parametrize("file_format", FORMATS)
async def test_rows_taken_beside_their_originals_stay_with_the_field_they_came_with(
    rig: MapRig, file_format: str
) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await drawn(client, FARM)
        back = await taken(client, *await exported(client, file_format))
        assert back["ab_1-2"]["properties"]["parcel_id"] == "north_2-2"
        assert (await opened(client))["ab_1"]["properties"]["parcel_id"] == "north_2"
        gone = {"id": "ref-gone", "op": "remove", "features": ["north_2"], "args": {}}
        assert (await client.post("/map/draft/operations", json=gone)).status_code == 200
        left = await opened(client)
        assert {"north_2", "ab_1"}.isdisjoint(left)
        assert {"north_2-2", "ab_1-2"} <= left.keys(), "the rows of the other field stay"


async def test_rows_taken_without_their_field_keep_the_one_that_the_map_has(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await drawn(client, FARM)
        file = json.dumps({"type": "FeatureCollection", "features": [rows("ab_1", "north_2")]}).encode()
        back = await taken(client, "rows.geojson", file)
        assert back["ab_1-2"]["properties"]["parcel_id"] == "north_2"


async def test_fields_of_one_name_and_no_id_are_numbered(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await drawn(client, [parcel("pasture-3", -500)])
        plain = [{**parcel("x", 50.0 * n), "id": None, "properties": {"name": "Pasture"}} for n in range(1, 4)]
        file = json.dumps({"type": "FeatureCollection", "features": plain}).encode()
        assert list(await taken(client, "grass.geojson", file)) == ["pasture", "pasture-2", "pasture-4"]
