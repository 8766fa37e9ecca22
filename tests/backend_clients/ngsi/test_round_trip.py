"""Whatever the client takes, the broker takes too, finds and gives back."""

from __future__ import annotations

import asyncio
from typing import Any
from urllib.parse import urlencode

from hypothesis import given, settings
from hypothesis import strategies as st

from backend_clients.ngsi import location, query
from backend_clients.ngsi.entity import Attribute, Entity, Metadatum, entity_from_wire
from backend_clients.ngsi.errors import BadInput
from backend_clients.ngsi.identifier import EntityRef, ref_for
from backend_clients.ngsi.location import Position
from backend_clients.ngsi.query import Query
from tests.backend_clients.simulator.context_broker.rig import Rig

# half codes, operators and what a broker refuses are rare among random texts
TEXTS = st.text(st.characters(codec="utf-8") | st.sampled_from("%%2345789BCDE<>\"'=;()$"), max_size=12)
NUMBERS = st.integers(-(2**53), 2**53) | st.floats(-1e6, 1e6).map(lambda value: round(value, 6))
VALUES = st.recursive(
    st.none() | st.booleans() | NUMBERS | TEXTS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=3),
    max_leaves=6,
)
NAMES = st.text(st.sampled_from("abcXYZ019_.:-%~$*[]{}|@!+,"), min_size=1, max_size=10).filter(
    lambda name: name not in ("id", "type")
)
ATTRIBUTES = st.dictionaries(
    NAMES,
    st.builds(Attribute, value=VALUES, metadata=st.dictionaries(NAMES, st.builds(Metadatum, value=VALUES), max_size=1)),
    max_size=4,
)


def plain(entity: Entity) -> dict[str, Any]:
    return {
        name: (item.value, {k: m.value for k, m in item.metadata.items()}) for name, item in entity.attributes.items()
    }


@given(st.text(st.characters(codec="utf-8"), min_size=1, max_size=20), ATTRIBUTES)
@settings(max_examples=60)
def test_any_entity_comes_back_as_it_went(name: str, attributes: dict[str, Attribute]) -> None:
    rig, entity = Rig(), Entity(ref=ref_for("Robot", name), attributes=attributes)
    status, said = rig.ask("POST", "/v2/entities", entity.to_wire())
    assert status == 201, said
    found = entity_from_wire(rig.ask("GET", "/v2/entities")[1][0])
    assert found.ref == entity.ref
    assert plain(found) == plain(entity)


def test_each_metadatum_comes_back_as_its_own_type_wants() -> None:
    plain_text, raw = Metadatum(type="Text", value="don't"), Metadatum(type="TextUnrestricted", value="50 %27")
    sent = {
        "a": Attribute(type="TextUnrestricted", value="a %28 (b)", metadata={"m": plain_text, "r": raw}),
        "b": Attribute(type="Text", value="(b)", metadata={"m": plain_text, "r": raw}),
    }
    rig, entity = Rig(), Entity(ref=ref_for("Robot", "r"), attributes=sent)
    assert rig.ask("POST", "/v2/entities", entity.to_wire())[0] == 201
    assert plain(entity_from_wire(rig.ask("GET", "/v2/entities")[1][0])) == plain(entity)


@given(TEXTS.filter(bool), TEXTS.filter(bool), st.lists(TEXTS, max_size=2).map(tuple))
@settings(max_examples=60)
def test_a_text_is_found_by_itself_and_by_any_part_of_it(text: str, other: str, members: tuple[str, ...]) -> None:
    rig, value = Rig(), Attribute(value=text)
    inner: Any = text
    for member in reversed(members):
        inner = {member: inner}
    one = Entity(ref=EntityRef("one", "T"), attributes={"n": value, "deep": Attribute(value=inner)})
    rest = Entity(ref=EntityRef("rest", "T"), attributes={"n": Attribute(value=text + other)})
    for entity in (one, rest):
        assert rig.ask("POST", "/v2/entities", entity.to_wire())[0] == 201

    def found(condition: query.Condition) -> set[str]:
        status, said = rig.ask("GET", "/v2/entities?" + urlencode(Query(where=(condition,)).parameters()))
        assert status == 200, said
        return {item["id"] for item in said}

    assert found(query.equals("n", text)) == {"one"}
    assert found(query.equals("n", text, text + other)) == {"one", "rest"}
    try:
        deep = query.equals(("deep", *members), text)
    except BadInput:
        assert "" in members  # what has no name cannot be asked for
    else:
        assert found(deep) == {"one"}


@given(st.floats(-179, 179), st.floats(-85, 85), st.floats(0.001, 0.9))
@settings(max_examples=40)
def test_a_place_is_found_within_what_surrounds_it_and_near_itself(lon: float, lat: float, half: float) -> None:
    rig = Rig()
    entity = Entity(ref=EntityRef("one", "T"), attributes={"location": location.point(Position(lon, lat))})
    assert rig.ask("POST", "/v2/entities", entity.to_wire())[0] == 201
    around = [Position(lon + x * half, lat + y * half) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    for place, is_there in (
        (location.within(around), True),
        (location.related("disjoint", around), False),
        (location.near(Position(lon, lat), max_m=1), True),
        (location.near(Position(lon, lat), min_m=1), False),
    ):
        _, said = rig.ask("GET", "/v2/entities?" + urlencode(Query(place=place).parameters()))
        assert bool(said) is is_there


async def test_a_storm_of_changes_out_of_order_ends_with_the_newest_of_each() -> None:
    from backend_clients.ngsi.intake import Intake, Verdict
    from backend_clients.ngsi.notification import read_notification

    rig, intake, kept = Rig(), Intake(), {}
    rig.subscribe(notification={"attrs": ["*", "dateModified"]})
    for number in range(10):
        rig.make(f"r{number}", n=-1)
    for step in range(30):
        rig.clock.advance(0.002)
        for number in range(10):
            rig.put(f"r{number}", n=step)
        await asyncio.sleep(0)
    await rig.broker.notifier.settle()
    assert len(rig.posted) == 10 * 31
    for request in sorted(rig.posted, key=lambda posted: hash(posted.content)):
        headers = {name.lower(): value for name, value in request.headers.items()}
        (entity,) = read_notification(request.content, headers).entities
        if intake.judge(entity, rig.clock.utc()) is Verdict.NEW:
            kept[entity.ref.id] = entity.value("n")
    assert kept == {f"r{number}": 29 for number in range(10)}
