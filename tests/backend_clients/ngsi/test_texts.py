"""What is sent is what a broker takes, and comes back as it was."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from backend_clients.ngsi import entity as make
from backend_clients.ngsi import identifier, location, query
from backend_clients.ngsi.entity import Attribute, Entity, entity_from_wire
from backend_clients.ngsi.errors import BadInput, Unreadable
from backend_clients.ngsi.escaping import FORBIDDEN, escape, escape_value, unescape, unescape_value
from backend_clients.ngsi.identifier import EntityRef, name_of, ref_for
from backend_clients.ngsi.location import Position
from backend_clients.ngsi.query import Query
from backend_clients.ngsi.tenant import Tenant

# codes and half codes are rare among random texts, and the only ones that could be lost
TEXTS = st.text(st.characters(codec="utf-8") | st.sampled_from("%%%2345789BCDE<>\"'=;()$"))
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.floats(allow_nan=False, allow_infinity=False) | TEXTS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=3),
    max_leaves=8,
)
LON, LAT = st.floats(-180, 180), st.floats(-90, 90)


@given(TEXTS)
def test_any_text_survives_escaping_and_has_nothing_forbidden(text: str) -> None:
    assert set(FORBIDDEN).isdisjoint(escape(text))
    assert unescape(escape(text)) == text


@given(VALUES)
def test_any_value_survives_escaping_and_has_no_operator(value: Any) -> None:
    escaped = escape_value(value)
    assert unescape_value(escaped) == value
    assert not (isinstance(escaped, dict) and any(key.startswith("$") for key in escaped))


@pytest.mark.parametrize(
    ("text", "wire"),
    [("50 % & 10%", "50 % & 10%"), ("don't", "don%27t"), ("%27", "%2527"), ("%2<", "%2%3C"), ("%%27", "%%2527")],
)
def test_escaping_leaves_readable_what_it_can(text: str, wire: str) -> None:
    assert escape(text) == wire


def test_a_value_nested_without_end_is_refused() -> None:
    value: list[Any] = []
    for _ in range(60):
        value = [value]
    with pytest.raises(BadInput):
        escape_value(value)


@given(st.text(st.characters(codec="utf-8"), min_size=1, max_size=40))
def test_any_name_makes_an_id_and_is_found_again(name: str) -> None:
    try:
        ref = ref_for("AgriParcel", name)
    except BadInput:
        assert len(name.encode()) * 3 > 200
    else:
        assert identifier.check_id(ref.id) == ref.id
        assert name_of(ref) == name


@pytest.mark.parametrize("text", ["", "a b", "a/b", "a#b", "a<b", "ñ", "i" * 257, "a\n", "a'b", "a(b"])
def test_an_id_that_a_broker_refuses_is_refused_before_it_is_sent(text: str) -> None:
    with pytest.raises(BadInput):
        identifier.check_id(text)


@pytest.mark.parametrize("text", ["other:1", "urn:ngsi-ld:Robot:~zz", "urn:ngsi-ld:Robot:~41", "urn:ngsi-ld:Robot:~FF"])
def test_an_id_of_somebody_else_is_not_taken_for_ours(text: str) -> None:
    with pytest.raises(BadInput):
        name_of(EntityRef(text, "Robot"))


@pytest.mark.parametrize(
    ("service", "path"),
    [("A", "/"), ("a-b", "/"), ("a" * 51, "/"), ("a", "farm"), ("a", "/fa-rm"), ("a", "/#"), ("a", "/a,/b"),
     ("a", "/1/2/3/4/5/6/7/8/9/10/11"), ("a", "/farm/"), ("a\n", "/")],
)  # fmt: skip
def test_a_tenant_that_a_broker_refuses_is_refused_before_it_is_sent(service: str, path: str) -> None:
    with pytest.raises(BadInput):
        Tenant(service, path)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 2**53 + 1, "\ud800", {"a": [float("nan")]}])
def test_a_value_that_would_be_refused_or_lose_digits_is_not_sent(value: Any) -> None:
    attribute = Attribute.model_construct(type="Number", value=value, metadata={})
    with pytest.raises(BadInput):
        attribute.to_wire()


def test_unrestricted_text_goes_as_it_is() -> None:
    attribute = Attribute(type="TextUnrestricted", value="f(x)=%3C")
    assert attribute.to_wire()["value"] == "f(x)=%3C"
    body = {"id": "a", "type": "T", "x": {"type": "TextUnrestricted", "value": "%3C", "metadata": {}}}
    assert entity_from_wire(body).value("x") == "%3C"
    with pytest.raises(BadInput):
        Attribute(type="TextUnrestricted", value={"$inc": 1}).to_wire()


def test_times_go_in_utc_and_need_a_zone() -> None:
    at = datetime(2026, 5, 1, 10, tzinfo=timezone(timedelta(hours=2)))
    assert make.date_time(at).value == "2026-05-01T08:00:00.000Z"
    assert make.date_time(at).moment() == at
    with pytest.raises(BadInput):
        make.date_time(datetime(2026, 5, 1))  # noqa: DTZ001
    with pytest.raises(Unreadable):
        make.text("tomorrow").moment()


@pytest.mark.parametrize(
    "body",
    [None, [], {}, {"id": "a"}, {"id": 1, "type": "T"}, {"id": "a", "type": "T", "x": 1},
     {"id": "a", "type": "T", "x": {"value": 1, "unit": "m"}}, {"id": "a", "type": "T", "x": {"type": 5}}],
)  # fmt: skip
def test_what_is_no_entity_is_not_taken_for_one(body: Any) -> None:
    with pytest.raises(Unreadable):
        entity_from_wire(body)


def test_what_only_a_broker_sets_is_not_sent_back() -> None:
    found = Entity(ref=EntityRef("a", "T"), attributes={"dateModified": make.text("x"), "n": make.number(1)})
    assert set(found.to_wire()) == {"id", "type", "n"}


@given(st.text(st.characters(codec="utf-8"), min_size=1))
def test_no_text_breaks_out_of_a_query(text: str) -> None:
    wire = query.equals("note", text).text
    assert wire.startswith("note=='")
    assert wire.endswith("'")
    assert not set("'\"<>=;()") & set(wire[len("note=='") : -1])


@pytest.mark.parametrize("path", ["", "a b", ("a", ""), "a;b", "a=b"])
def test_a_path_that_cannot_be_asked_for_is_refused(path: Any) -> None:
    with pytest.raises(BadInput):
        query.exists(path)


def test_values_go_in_the_words_of_the_query_language() -> None:
    at = datetime(2026, 5, 1, tzinfo=UTC)
    assert query.equals("a", "x,y", 1.5, True, None).text == "a=='x,y',1.5,true,null"
    assert query.between("a", 1, 2).text == "a==1..2"
    assert query.at_most("a", at).text == "a<=2026-05-01T00:00:00.000Z"
    assert query.absent(("a.b", "c d")).text == "!'a.b'.'c d'"
    with pytest.raises(BadInput):
        query.matches("a", "(b")
    with pytest.raises(BadInput):
        query.equals("a")


def test_an_order_without_ties_is_what_pages_need() -> None:
    assert Query(order_by=("!rank",)).steady().order_by == ("!rank", "id", "type")
    assert Query(order_by=("!id",)).steady().order_by == ("!id", "type")
    with pytest.raises(BadInput):
        Query(ids=("a",), id_pattern="b").parameters()
    with pytest.raises(BadInput):
        Query(ids=("a,b",)).parameters()


@given(LON, LAT)
def test_a_query_names_latitude_first(lon: float, lat: float) -> None:
    first, second = location.near(Position(lon, lat), max_m=10).coords.split(",")
    assert float(first) == pytest.approx(lat, abs=1e-8)
    assert float(second) == pytest.approx(lon, abs=1e-8)
    assert "e" not in first + second


def test_places_that_are_none_are_refused() -> None:
    square = [Position(0, 0), Position(1, 0), Position(1, 1), Position(0, 1)]
    assert location.within(square).coords == "0,0;0,1;1,1;1,0;0,0"
    bow_tie = [Position(0, 0), Position(1, 1), Position(1, 0), Position(0, 1)]
    for wrong in (lambda: location.polygon(bow_tie), lambda: location.polygon(square[:2]),
                  lambda: location.point(Position(float("nan"), 0)), lambda: location.point(Position(0, 91)),
                  lambda: location.near(square[0]), lambda: location.near(square[0], max_m=-1),
                  lambda: location.line(square[:1]), lambda: location.read_point(make.number(1))):  # fmt: skip
        with pytest.raises(BadInput):
            wrong()
