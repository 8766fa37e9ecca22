"""What is taken from files of others as what somebody chose: rows find their field, attributes fit the kind."""

from __future__ import annotations

import json
from typing import Any

import httpx
import pytest

from hmi.domain.role import Role
from tests.hmi.maps.conftest import MapRig
from tests.hmi.maps.test_files_again import drawn
from tests.hmi.maps.test_rest import opened, parcel, without_bow_tie
from tests.hmi.missions.rig import lon_lat


def line(name: str, *places: tuple[float, float], **own: Any) -> dict[str, Any]:
    """Return a line of another program, metres from the farm's middle."""
    geometry = {"type": "LineString", "coordinates": lon_lat(*places)}
    return {"type": "Feature", "properties": {"name": name, **own}, "geometry": geometry}


def point(name: str, **own: Any) -> dict[str, Any]:
    """Return a point of another program."""
    [place] = lon_lat((-195, 105))
    return {
        "type": "Feature",
        "properties": {"name": name, **own},
        "geometry": {"type": "Point", "coordinates": place},
    }


def field(name: str, x_m: float) -> dict[str, Any]:
    """Return a square field of another program."""
    return {"type": "Feature", "properties": {"name": name}, "geometry": parcel("x", x_m)["geometry"]}


def packed(*features: dict[str, Any]) -> bytes:
    """Return a GeoJSON file."""
    return json.dumps({"type": "FeatureCollection", "features": features}).encode()


async def taken(
    client: httpx.AsyncClient, name: str, data: bytes, kinds: dict[str, str] | None = None, *leave: int
) -> dict[str, dict[str, Any]]:
    """Take a file over; return the properties of what came in, by its new ids."""
    read = (await client.post(f"/map/imports?name={name}", content=data)).json()
    items = [one["n"] for one in read["items"] if one["n"] not in leave]
    body = {"id": "ref-taken", "items": items, "kinds": kinds or {}}
    answer = await client.post(f"/map/imports/{read['id']}/take", json=body)
    assert answer.status_code == 200, answer.text
    return {one["id"]: one["after"]["properties"] for one in answer.json()["changes"]}


async def test_rows_of_a_file_belong_to_the_parcel_that_holds_most_of_them(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await drawn(client, [parcel("north", -200)])
        lines = [
            line("guidance line 1", (-210, 120), (-170, 120)),
            line("guidance line 2", (-170, 125), (-110, 125)),
            line("guidance line 3", (-60, 120), (-50, 120)),
        ]
        back = await taken(client, "rows.geojson", packed(field("West", -160), *lines))
        assert [back[key].get("parcel_id") for key in back] == [None, "north", "west", None]


async def test_rows_whose_field_the_map_does_not_know_find_one(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await drawn(client, [parcel("north", -200)])
        properties = {"id": "ab", "kind": "rows", "name": "A-B", "type": "a-b", "parcel_id": "elsewhere"}
        rows = {**line("A-B", (-190, 120), (-170, 120)), "id": "ab", "properties": properties}
        assert (await taken(client, "rows.geojson", packed(rows)))["ab"]["parcel_id"] == "north"


def task_data() -> bytes:
    """Return task data of two fields that share ground; the line of the second lies more in the first."""

    def places(*corners: tuple[float, float]) -> str:
        return "".join(f'<PNT A="2" C="{lat}" D="{lon}"/>' for lon, lat in lon_lat(*corners))

    def pln(x_m: float) -> str:
        edge = places((x_m, 100), (x_m + 40, 100), (x_m + 40, 140), (x_m, 140))
        return f'<PLN A="1"><LSG A="1">{edge}</LSG></PLN>'

    ab = places((-195, 120), (-160, 120))
    ggp = f'<GGP A="GGP1" B="Line"><GPN A="GPN1" B="Line" C="1"><LSG A="5">{ab}</LSG></GPN></GGP>'
    fields = f'<PFD A="PFD1" C="First">{pln(-200)}</PFD><PFD A="PFD2" C="Second">{pln(-180)}{ggp}</PFD>'
    return f'<ISO11783_TaskData VersionMajor="4">{fields}</ISO11783_TaskData>'.encode()


async def test_guidance_of_task_data_belongs_to_its_own_field(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await without_bow_tie(client)
        assert (await taken(client, "TASKDATA.XML", task_data()))["line"]["parcel_id"] == "second"


async def test_guidance_taken_without_its_own_field_belongs_to_the_one_it_lies_in(rig: MapRig) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await without_bow_tie(client)
        assert (await taken(client, "TASKDATA.XML", task_data(), {}, 1))["line"]["parcel_id"] == "first"


@pytest.mark.parametrize(
    ("shape", "kind", "kept"),
    [
        (point("Gate 1", kind="gate"), "obstacle", {"radius_m": 1.0}),
        (point("Oak", type="tree"), "home", {"type_as_given": "tree"}),
        (line("Track", (-195, 120), (-170, 120), type="track"), "rows", {"type_as_given": "track"}),
    ],
)
async def test_a_kind_chosen_by_hand_is_taken_with_attributes_that_fit_it(
    rig: MapRig, shape: dict[str, Any], kind: str, kept: dict[str, Any]
) -> None:
    async with rig.browser(Role.PLANNER) as client:
        await drawn(client, [parcel("north", -200)])
        [properties] = (await taken(client, "one.geojson", packed(shape), {"0": kind})).values()
        assert properties["kind"] == kind
        assert kept.items() <= properties.items()
        assert "type" not in properties
        assert len(await opened(client)) > 1
