"""The broker beyond the recording: operators, places, order, batch; and nothing makes it stumble."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.backend_clients.simulator.context_broker.rig import Rig

HERE = {"type": "geo:json", "value": {"type": "Point", "coordinates": [-3.48, 40.31]}}


def values(rig: Rig, query: str) -> list[str]:
    status, found = rig.ask("GET", f"/v2/entities?{query}")
    assert status == 200, found
    return [item["id"] for item in found]


@pytest.mark.parametrize(
    ("before", "operator", "after"),
    [(2, {"$inc": 3}, 5), (2, {"$mul": 3}, 6), (2, {"$min": 1}, 1), (2, {"$max": 1}, 2), ([1], {"$push": 1}, [1, 1]),
     ([1], {"$addToSet": 1}, [1]), ([1, 2, 1], {"$pull": 1}, [2]), ([1, 2, 3], {"$pullAll": [1, 2]}, [3]),
     ({"a": 1}, {"$set": {"b": 2}}, {"a": 1, "b": 2}), ({"a": 1, "b": 2}, {"$unset": {"a": 1}}, {"b": 2}),
     ({"a": 1}, {"$set": {"b": 2}, "$unset": {"a": 1}}, {"b": 2})],
)  # fmt: skip
def test_an_operator_makes_the_new_value_from_the_old_one(before: Any, operator: Any, after: Any) -> None:
    rig = Rig()
    rig.make("r1", n=before)
    assert rig.ask("PATCH", "/v2/entities/r1/attrs", {"n": {"value": operator, "type": "X"}})[0] == 204
    assert rig.ask("GET", "/v2/entities/r1?options=keyValues")[1]["n"] == after


@pytest.mark.parametrize(
    ("operator", "status"), [({"$inc": "x"}, 400), ({"$inc": 1, "$mul": 2}, 400), ({"$no": 1}, 400)]
)
def test_an_operator_that_makes_no_sense_is_refused(operator: Any, status: int) -> None:
    rig = Rig()
    rig.make("r1", n=1)
    assert rig.ask("PATCH", "/v2/entities/r1/attrs", {"n": {"value": operator, "type": "Number"}})[0] == status
    assert rig.ask("GET", "/v2/entities/r1/attrs/n/value")[1] == 1


def test_adding_to_a_text_is_an_error_of_the_store() -> None:
    rig = Rig()
    rig.make("r1", n="x")
    assert rig.ask("PATCH", "/v2/entities/r1/attrs", {"n": {"value": {"$inc": 1}, "type": "Number"}})[0] == 500


@pytest.mark.parametrize(
    ("query", "found"),
    [("georel=near;maxDistance:1000&geometry=point&coords=40.31,-3.48", ["here"]),
     ("georel=near;minDistance:1000&geometry=point&coords=40.31,-3.48", ["far"]),
     ("georel=near;minDistance:0&geometry=point&coords=39.5,-0.4&orderBy=geo:distance", ["far", "here"]),
     ("georel=coveredBy&geometry=polygon&coords=40,-4;40,-3;41,-3;41,-4;40,-4", ["here"]),
     ("georel=coveredBy&geometry=box&coords=40,-4;41,-3", ["here"]),
     ("georel=disjoint&geometry=box&coords=40,-4;41,-3", ["far"]),
     ("georel=intersects&geometry=line&coords=40.31,-4;40.31,-3", ["here"]),
     ("georel=equals&geometry=point&coords=40.31,-3.48", ["here"]),
     ("georel=coveredBy&geometry=box&coords=-4,40;-3,41", []),
     ("geometry=point&coords=40.31,-3.48", ["bare", "far", "here"])],
)  # fmt: skip
def test_places_are_found_by_latitude_and_longitude(query: str, found: list[str]) -> None:
    rig = Rig()
    far = {"type": "geo:point", "value": "39.47, -0.37"}
    for name, place in (("here", {"location": HERE}), ("far", {"location": far}), ("bare", {})):
        assert rig.ask("POST", "/v2/entities", {"id": name, "type": "T", **place})[0] == 201
    assert (values(rig, query) if "near" in query else sorted(values(rig, query))) == found


def test_a_distance_is_that_on_the_sphere() -> None:
    rig = Rig()
    # one degree of latitude on the sphere of the store is 111,319 m
    rig.ask("POST", "/v2/entities", {"id": "a", "type": "T", "location": HERE})
    ask = "georel=near;maxDistance:{}&geometry=point&coords=41.31,-3.48"
    assert values(rig, ask.format(111_318)) == []
    assert values(rig, ask.format(111_320)) == ["a"]


@pytest.mark.parametrize(
    "query",
    ["georel=near&geometry=point&coords=1,1", "georel=near;maxDistance:x&geometry=point&coords=1,1",
     "georel=near;maxDistance:1&geometry=line&coords=1,1;2,2", "georel=coveredBy&geometry=polygon&coords=1,1;2,2;3,1",
     "georel=coveredBy&geometry=point", "georel=coveredBy&coords=1,1", "georel=above&geometry=point&coords=1,1",
     "georel=equals&geometry=point&coords=91,0", "georel=equals&geometry=circle&coords=1,1"],
)  # fmt: skip
def test_a_place_that_makes_no_sense_is_refused(query: str) -> None:
    rig = Rig()
    rig.make("r1")
    assert rig.ask("GET", f"/v2/entities?{query}")[0] == 400


def test_of_a_feature_only_the_geometry_is_kept_and_a_second_place_is_refused() -> None:
    rig = Rig()
    feature = {"type": "Feature", "properties": {"a": 1}, "geometry": HERE["value"]}
    rig.ask("POST", "/v2/entities", {"id": "a", "type": "T", "location": {"type": "geo:json", "value": feature}})
    assert rig.ask("GET", "/v2/entities/a?options=keyValues")[1]["location"] == HERE["value"]
    status, said = rig.ask("POST", "/v2/entities/a/attrs", {"home": HERE})
    assert (status, said["error"]) == (413, "NoResourcesAvailable")
    marked = {**HERE, "metadata": {"ignoreType": {"value": True, "type": "Boolean"}}}
    assert rig.ask("POST", "/v2/entities/a/attrs", {"home": marked})[0] == 204


def test_a_tie_in_the_order_is_broken_by_the_next_key() -> None:
    rig = Rig()
    for name, rank in (("b", 1), ("a", 1), ("c", 0), ("d", "x")):
        rig.make(name, rank=rank)
    assert values(rig, "orderBy=rank,id") == ["c", "a", "b", "d"]
    assert values(rig, "orderBy=!rank,id&limit=2&offset=1") == ["a", "b"]


def test_conditions_on_metadata_and_lists_are_met() -> None:
    rig = Rig()
    rig.ask(
        "POST", "/v2/entities", {"id": "a", "type": "T", "n": {"value": [1, 2], "metadata": {"acc": {"value": 0.5}}}}
    )
    assert values(rig, "mq=n.acc>0.1") == ["a"]
    assert values(rig, "mq=n.acc>0.9") == []
    assert values(rig, "q=n==2") == ["a"]
    assert values(rig, "q=n!=2") == []
    assert values(rig, "q=n=='2'") == []
    for wrong in ("q=;", "q===1", "q=a>true", "q=a=='x", "mq=n"):
        assert rig.ask("GET", f"/v2/entities?{wrong}")[0] == 400


def test_a_batch_tells_what_it_did_and_did_not_do() -> None:
    rig = Rig()
    rig.make("a", n=1)

    def update(action: str, *entities: dict[str, Any]) -> tuple[int, Any]:
        typed = [{"type": "Robot", **entity} for entity in entities]
        return rig.ask("POST", "/v2/op/update", {"actionType": action, "entities": typed})

    assert update("append", {"id": "b", "n": {"value": 1}}, {"id": "a", "m": {"value": 1}}) == (204, None)
    status, said = update("update", {"id": "a", "n": {"value": 2}}, {"id": "x", "n": {"value": 2}})
    assert (status, said["error"]) == (422, "PartialUpdate")
    assert rig.ask("GET", "/v2/entities/a/attrs/n/value")[1] == 2
    assert update("update", {"id": "x"}, {"id": "y"})[0] == 404
    assert update("appendStrict", {"id": "a", "n": {"value": 3}})[1]["error"] == "Unprocessable"
    assert update("replace", {"id": "a", "only": {"value": 1}})[0] == 204
    assert rig.ask("GET", "/v2/entities/a?options=keyValues")[1] == {"id": "a", "type": "Robot", "only": 1}
    assert update("delete", {"id": "a"}, {"id": "b"})[0] == 204
    assert values(rig, "limit=10") == []
    assert update("destroy", {"id": "a"})[0] == 400


def test_a_query_in_a_body_is_answered_like_one_in_the_address() -> None:
    rig = Rig()
    rig.make("a", n=1)
    rig.make("b", n=2)
    body = {"entities": [{"idPattern": ".*", "type": "Robot"}], "attrs": ["n"], "expression": {"q": "n>1"}}
    answer = rig.full("POST", "/v2/op/query?options=count,keyValues", body)
    assert json.loads(answer.body) == [{"id": "b", "type": "Robot", "n": 2}]
    assert answer.headers["Fiware-Total-Count"] == "1"


def test_tenants_fold_case_and_share_nothing() -> None:
    rig = Rig()
    rig.make("a")
    assert len(rig.ask("GET", "/v2/entities", service="G1")[1]) == 1
    assert rig.ask("GET", "/v2/entities", service="g2")[1] == []
    assert rig.ask("GET", "/v2/entities", path_header="/#")[1] != []
    assert rig.ask("GET", "/v2/entities", path_header="/other,/farm")[1] != []


def test_a_body_with_repeated_members_or_no_number_is_refused() -> None:
    rig = Rig()
    assert rig.ask("POST", "/v2/entities", raw=b'{"id":"a","n":{"value":1},"n":{"value":2}}')[0] == 400
    for raw in (b'{"id":"a","n":{"value":NaN}}', b'{"id":"a","n":{"value":1e999}}', b"\xff", b"[" * 100_000, b'"a"'):
        assert rig.ask("POST", "/v2/entities", raw=raw)[1]["error"] == "ParseError"


SCALARS = st.none() | st.booleans() | st.sampled_from([0, 1.5, -1e300, "", "a", "x=y", "$inc", "2026-01-01"])
TYPES = st.sampled_from(["Number", "Text", "DateTime", "geo:json", "geo:point", "geo:box", "TextUnrestricted", "None"])
ENTITY_WORDS = ["id", "type", "value", "metadata", "n", "$inc", "$push", "$set", "coordinates", "entities", "idPattern"]
OTHER_WORDS = ["actionType", "subject", "notification", "http", "url", "condition", "expression", "q", "attrs"]
BODIES = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=2) | st.dictionaries(st.sampled_from(ENTITY_WORDS + OTHER_WORDS), inner, max_size=4)
    ),
    max_leaves=10,
)
ATTRIBUTE = st.fixed_dictionaries({"value": BODIES}, optional={"type": TYPES, "metadata": st.just({}) | BODIES})
ENTITY = st.fixed_dictionaries({"id": st.sampled_from(["a", "b"])}, optional={"n": ATTRIBUTE, "m": ATTRIBUTE})
ACTION = st.sampled_from(["append", "appendStrict", "update", "delete", "replace", "x"])
BATCH = st.fixed_dictionaries({"actionType": ACTION, "entities": st.lists(ENTITY, min_size=1, max_size=3)})
ENTITY_PATHS = ["/v2/entities", "/v2/entities/a", "/v2/entities/a/attrs", "/v2/entities/a/attrs/n"]
OTHER_PATHS = ["/v2/entities/a/attrs/n/value", "/v2/op/update", "/v2/op/query", "/v2/subscriptions", "/v2/types/T"]
PATHS = st.sampled_from(ENTITY_PATHS + OTHER_PATHS)
NAMES = ["q", "mq", "georel", "geometry", "coords", "limit", "offset", "orderBy", "attrs", "options", "idPattern"]
RIGHT = ["near;maxDistance:1", "point", "1,1", "coveredBy", "keyValues", "values", "upsert", "n==1..2", "!n", "n.a>1"]
WRONG = st.text(st.sampled_from("nab.;:'=!<>~,1[]*+-0e"), min_size=1, max_size=12)
PARAMETERS = st.dictionaries(st.sampled_from(NAMES), WRONG | st.sampled_from(RIGHT), max_size=3)


@given(
    st.sampled_from(["GET", "POST", "PATCH", "PUT", "DELETE"]), PATHS, BODIES | ENTITY | ATTRIBUTE | BATCH, PARAMETERS
)
@settings(max_examples=60)
def test_no_request_makes_the_broker_stumble(method: str, path: str, body: Any, parameters: dict[str, str]) -> None:
    rig = Rig()
    rig.make("a", n=1)
    query = "&".join(f"{name}={value}" for name, value in parameters.items()).replace("+", "%2B")
    with_body = method in ("POST", "PATCH", "PUT")
    answer = rig.full(method, f"{path}?{query}", raw=json.dumps(body).encode() if with_body else b"")
    assert answer.status in (200, 201, 204, 400, 404, 405, 406, 409, 413, 422, 500, 501)
    if answer.status >= 400:
        assert set(json.loads(answer.body)) == {"error", "description"}
    assert rig.ask("GET", "/v2/entities?limit=5")[0] == 200


def test_options_come_in_one_list_or_in_several() -> None:
    rig = Rig()
    rig.make("a", n=1)
    for query in ("options=count,keyValues", "options=count&options=keyValues"):
        answer = rig.full("GET", f"/v2/entities?{query}")
        assert json.loads(answer.body) == [{"id": "a", "type": "Robot", "n": 1}]
        assert answer.headers["Fiware-Total-Count"] == "1"
    assert rig.ask("GET", "/v2/entities?options=keyValues,values")[0] == 400


def test_other_methods_are_refused_with_those_that_are_there() -> None:
    rig = Rig()
    for method in ("HEAD", "OPTIONS", "DELETE"):
        answer = rig.full(method, "/v2/entities")
        assert (answer.status, answer.headers["Allow"]) == (405, "POST, GET")
