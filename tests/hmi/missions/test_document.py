"""The wire document: the same hash on both sides, and its picture for the map."""

from __future__ import annotations

import json
import math
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from backend_clients.edge import messages_down as down
from backend_clients.edge.codec import mission_hash
from backend_clients.edge.messages_up import Datum
from hmi.commands.plan_wish import surroundings_of
from hmi.demo.catalogue import CATALOGUE, plan
from hmi.domain.mission_document import canonical, for_robot, mission_sha256, renamed
from hmi.domain.mission_plan import PlanRefused, PlanWish
from hmi.planning.mission import plan_mission
from hmi.planning.mission_map import mission_geojson
from tests.hmi.missions.rig import farm_map, lon_lat, parcel_geometry

metres = st.floats(-1e5, 1e5)
names = st.text(min_size=1, max_size=20)
segments = st.builds(
    down.Segment,
    kind=st.sampled_from(["approach", "row", "turn", "headland", "exit"]),
    points=st.lists(st.tuples(metres, metres), min_size=2, max_size=5),
    speed_mps=st.floats(0.01, 2),
    tool_on=st.booleans(),
    row=st.integers(0, 500),
    pivot=st.booleans(),
    jump=st.sampled_from([msgspec.UNSET, True]),
    dose=st.just(msgspec.UNSET) | st.floats(0, 2),
)
missions = st.builds(
    down.Mission,
    robot=st.sampled_from(["weeder-01", "weeder-02"]),
    mission_id=st.just("m-1"),
    revision=st.integers(0, 99),
    name=names,
    field_name=names,
    datum=st.builds(Datum, lat_deg=st.floats(-90, 90), lon_deg=st.floats(-180, 180), height_m=metres),
    width_m=st.floats(0.1, 50),
    area_m2=st.floats(0, 1e6),
    parcel=st.lists(st.lists(st.tuples(st.floats(-180, 180), st.floats(-90, 90)), max_size=4), min_size=1, max_size=2),
    segments=st.lists(segments, min_size=1, max_size=3),
    note=names,
    at_end=st.sampled_from(["stay", "return_home"]),
    home=st.none() | st.tuples(metres, metres),
    plant_spacing_m=st.just(msgspec.UNSET) | st.floats(0.05, 100),
    map_version=st.just(msgspec.UNSET)
    | st.builds(down.MapVersion, number=st.integers(0, 99), sha256=st.just("a" * 64)),
    continues=st.just(msgspec.UNSET)
    | st.builds(down.Continues, base_sha256=st.just("b" * 64), segments=st.integers(0, 9)),
)


def wish(**changes: Any) -> PlanWish:
    usual: dict[str, Any] = {
        "mission_id": "m-1",
        "name": "Home field",
        "robot_id": "weeder-01",
        "field_name": "Home field",
        "parcel": parcel_geometry(),
        "width_m": 3.0,
        "datum_lat_deg": 51.78,
        "datum_lon_deg": 4.26,
    }
    return PlanWish(**{**usual, **changes})


@given(missions)
@pytest.mark.slow
def test_the_hash_of_a_document_is_the_one_a_robot_computes(mission: down.Mission) -> None:
    assert mission_sha256(msgspec.to_builtins(mission)) == mission_hash(mission)


@pytest.mark.slow
@given(missions)
def test_the_hash_survives_storage_as_json(mission: down.Mission) -> None:
    stored = json.loads(json.dumps(msgspec.to_builtins(mission)))
    assert mission_sha256(stored) == mission_hash(mission)
    assert mission_hash(msgspec.convert(stored, down.Mission)) == mission_hash(mission)


def test_the_proof_of_an_update_is_no_part_of_the_hash() -> None:
    bare = msgspec.convert(plan_mission(wish()).document, down.Mission)
    proof = down.Proof(lease_token=7, lease_seq=3, challenge="c" * 16)
    assert mission_hash(msgspec.structs.replace(bare, proof=proof)) == mission_hash(bare)


def test_a_document_without_its_defaults_has_the_same_hash() -> None:
    document = plan_mission(wish()).document
    lean = {k: v for k, v in document.items() if k not in ("v", "note", "at_end", "home")}
    lean["segments"] = [{k: v for k, v in s.items() if v not in (False, 0)} for s in document["segments"]]
    assert mission_sha256(lean) == mission_sha256({**document, "note": "", "at_end": "stay", "home": None})


def test_the_contract_has_no_field_the_document_lacks() -> None:
    more = {"map_version": {"number": 1, "sha256": "a" * 64}, "continues": {"base_sha256": "b" * 64, "segments": 0}}
    document = canonical({**plan_mission(wish()).document, **more, "plant_spacing_m": 2.0})
    # the proof belongs to the moment of sending, not to the document
    assert set(document) == {f.encode_name for f in msgspec.structs.fields(down.Mission)} - {"proof"}
    more_of_it = {**document["segments"][0], "jump": True, "backward": True, "dose": 0.5}
    segment = canonical({**document, "segments": [more_of_it]})["segments"][0]
    assert set(segment) == {f.encode_name for f in msgspec.structs.fields(down.Segment)}
    left_out = {"jump", "backward", "dose"}  # where nobody gave one
    assert set(document["segments"][0]) == set(segment) - left_out
    assert set(document["datum"]) == {f.encode_name for f in msgspec.structs.fields(Datum)}


def test_a_document_for_another_robot_or_name_has_another_hash() -> None:
    planned = plan_mission(wish())
    for other in (for_robot(planned.document, "weeder-02"), renamed(planned.document, name="Other")):
        assert mission_sha256(other) != planned.sha256


@pytest.mark.parametrize("mission", CATALOGUE[:2], ids=lambda one: one.id)
def test_a_planned_mission_is_one_the_contract_takes(mission: Any) -> None:
    planned = plan(mission)
    wire = msgspec.convert(planned.document, down.Mission)
    assert mission_hash(wire) == planned.sha256
    assert wire.at_end == "return_home"
    assert wire.segments[-1].kind == "exit"
    assert wire.home is not None
    assert math.dist(wire.segments[-1].points[-1], wire.home) < 0.01
    for before, after in zip(wire.segments[:-1], wire.segments[1:], strict=True):
        assert before.points[-1] == after.points[0]


def test_the_same_wish_gives_the_same_document() -> None:
    assert plan_mission(wish()).sha256 == plan_mission(wish()).sha256


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ({"mission_id": "Not An Id"}, "bad_id"),
        ({"name": ""}, "bad_name"),
        ({"field_name": "x" * 81}, "bad_name"),
        ({"datum_lat_deg": math.nan}, "bad_datum"),
        ({"datum_lat_deg": 40.3, "datum_lon_deg": -3.48}, "field_too_far"),
        ({"parcel": {"type": "Point", "coordinates": [4.26, 51.78]}}, "bad_field"),
        ({"parcel": {"type": "Polygon", "coordinates": []}}, "bad_field"),
        ({"parcel": {"type": "Polygon", "coordinates": [[[4.26, 51.78], [4.27, 51.78]]]}}, "bad_field"),
        ({"parcel": {"type": "Polygon", "coordinates": [[[4.26, math.nan]] * 5]}}, "bad_field"),
        ({"parcel": {"type": "Polygon", "coordinates": [[["a", "b"]] * 5]}}, "bad_field"),
        ({"parcel": {"type": "Polygon", "coordinates": [[[951.0, 51.78]] * 5]}}, "bad_field"),
        ({"width_m": math.nan}, "width_not_positive"),
    ],
)
def test_a_wish_that_cannot_be_is_refused_with_a_reason(change: dict[str, Any], code: str) -> None:
    with pytest.raises(PlanRefused) as refused:
        plan_mission(wish(**change))
    assert refused.value.code == code


def test_the_map_shows_every_segment_in_driving_order_between_parcel_and_home() -> None:
    home = next(one for one in farm_map() if one.kind == "home").geometry["coordinates"]
    around = surroundings_of(farm_map(), parcel_geometry(), "field-1")
    document = plan_mission(wish(home=tuple(home), surroundings=around)).document
    features = mission_geojson(document)["features"]
    kinds = [one["properties"]["kind"] for one in features]
    assert kinds[0] == "parcel"
    assert kinds[-1] == "home"
    assert kinds[1:-1] == [segment["kind"] for segment in document["segments"]]
    assert [one["properties"]["segment"] for one in features[1:-1]] == list(range(len(document["segments"])))


def test_the_map_rounds_to_a_centimetre_and_keeps_longitude_first() -> None:
    features = mission_geojson(plan_mission(wish()).document)["features"]
    row = next(one for one in features if one["properties"]["kind"] == "row")
    for lon, lat in row["geometry"]["coordinates"]:
        assert 4.25 < lon < 4.27
        assert 51.77 < lat < 51.79
        assert (round(lon, 7), round(lat, 7)) == (lon, lat)


def test_a_picture_of_the_map_lies_where_the_field_is() -> None:
    [(lon, lat)] = lon_lat((20, 20))
    row = next(
        f for f in mission_geojson(plan_mission(wish()).document)["features"] if f["properties"]["kind"] == "row"
    )
    (lon_a, lat_a), *_ = row["geometry"]["coordinates"]
    assert abs(lon_a - lon) < 0.0005
    assert abs(lat_a - lat) < 0.0005
