"""Published maps, the draft and its lock."""

from __future__ import annotations

from datetime import timedelta
from typing import Any

import pytest

from hmi.clock import FakeClock
from hmi.domain.map_log import ChangedMeanwhile, FeatureChange, Transaction
from hmi.store.database import Database
from hmi.store.errors import NotFound
from hmi.store.farms import Farms
from hmi.store.features import Feature, Features
from hmi.store.maps import LOCK, MapLocked, MapOutdated, Maps
from tests.hmi.store.conftest import FARM

SQUARE = {"type": "Polygon", "coordinates": [[[5.0, 52.0], [5.001, 52.0], [5.001, 52.001], [5.0, 52.0]]]}


def raw(feature_id: str, name: str = "North", **own: Any) -> dict[str, Any]:
    """Return a parcel as GeoJSON."""
    properties = {"id": feature_id, "kind": "parcel", "name": name, **own}
    return {"type": "Feature", "id": feature_id, "properties": properties, "geometry": SQUARE}


def step(clock: FakeClock, ref: str, *changes: FeatureChange) -> Transaction:
    """Return a transaction of Anna's."""
    return Transaction(ref, f"Step {ref}", "Anna", clock.utc(), changes)


def add(clock: FakeClock, ref: str, feature_id: str) -> Transaction:
    """Return a transaction that adds a parcel."""
    return step(clock, ref, FeatureChange(feature_id, None, raw(feature_id)))


@pytest.fixture
def maps(database: Database, clock: FakeClock) -> Maps:
    """Return the maps of an installation."""
    return Maps(database, clock)


def test_a_farm_without_features_has_version_0(maps: Maps) -> None:
    assert maps.published(FARM).number == 0
    assert maps.features_of(FARM, 0) == {}
    assert maps.versions(FARM) == []


def test_features_that_came_without_a_version_become_the_first(
    maps: Maps, database: Database, clock: FakeClock
) -> None:
    Features(database, clock).put([Feature("north", FARM, "parcel", "North", SQUARE, {"crop": "Maize"})])
    assert (maps.published(FARM).number, maps.published(FARM).size) == (1, 1)
    assert maps.features_of(FARM, 1) == {"north": raw("north", crop="Maize")}


def test_a_draft_is_published_whole_and_ends(maps: Maps, database: Database, clock: FakeClock) -> None:
    maps.open(FARM, "anna", "Anna")
    maps.append(FARM, "anna", add(clock, "ref-1", "north"))
    version = maps.publish(FARM, "anna", "Anna", "Two fields")
    assert (version.number, version.by, version.note, version.size) == (1, "Anna", "Two fields", 1)
    assert maps.draft(FARM) is None
    [feature] = Features(database, clock).all(FARM)
    assert (feature.id, feature.kind, feature.name, feature.map_version) == ("north", "parcel", "North", 1)
    maps.open(FARM, "anna", "Anna")
    maps.append(FARM, "anna", step(clock, "ref-2", FeatureChange("north", raw("north"), None)))
    assert maps.publish(FARM, "anna", "Anna", "").size == 0
    assert Features(database, clock).all(FARM) == []
    assert [one.number for one in maps.versions(FARM)] == [2, 1]
    assert maps.features_of(FARM, 1) == {"north": raw("north")}


def test_the_log_of_a_draft_carries_names_and_no_shapes_and_undo_still_has_them(
    maps: Maps, database: Database, clock: FakeClock
) -> None:
    maps.open(FARM, "anna", "Anna")
    maps.append(FARM, "anna", add(clock, "ref-1", "north"))
    moved = raw("north", crop="Maize")
    draft, _ = maps.append(FARM, "anna", step(clock, "ref-2", FeatureChange("north", raw("north"), moved)))
    named = {"properties": {"name": "North"}}
    assert [one.changes for one in draft.log] == [
        (FeatureChange("north", None, named),),
        (FeatureChange("north", named, named),),
    ]
    again = Maps(database, clock)  # after a restart
    assert again.draft(FARM) == draft
    assert again.changes_of(FARM, "ref-2") == (FeatureChange("north", raw("north"), moved),)
    assert again.changes_of(FARM, "ref-9") is None
    assert again.undo(FARM, "anna")[1] == (FeatureChange("north", moved, raw("north")),)
    assert again.redo(FARM, "anna")[1] == (FeatureChange("north", raw("north"), moved),)


def test_undo_and_redo_survive_and_a_new_step_cuts_off_what_was_undone(maps: Maps, clock: FakeClock) -> None:
    maps.open(FARM, "anna", "Anna")
    for number in (1, 2, 3):
        maps.append(FARM, "anna", add(clock, f"ref-{number}", f"field-{number}"))
    draft, changes = maps.undo(FARM, "anna")
    assert set(draft.features) == {"field-1", "field-2"}
    assert changes == (FeatureChange("field-3", raw("field-3"), None),)
    maps.undo(FARM, "anna")
    draft, changes = maps.redo(FARM, "anna")
    assert set(draft.features) == {"field-1", "field-2"}
    assert [one.id for one in changes] == ["field-2"]
    draft, _ = maps.append(FARM, "anna", add(clock, "ref-4", "field-4"))
    assert [one.ref for one in draft.log] == ["ref-1", "ref-2", "ref-4"]
    draft, changes = maps.redo(FARM, "anna")
    assert changes == ()


def test_the_same_step_twice_is_one_and_a_stale_one_is_refused_whole(maps: Maps, clock: FakeClock) -> None:
    maps.open(FARM, "anna", "Anna")
    maps.append(FARM, "anna", add(clock, "ref-1", "north"))
    other = step(clock, "ref-1", FeatureChange("west", None, raw("west")))
    draft, stored = maps.append(FARM, "anna", other)
    assert (len(draft.log), stored) == (1, (FeatureChange("north", None, raw("north")),))
    stale = step(
        clock, "ref-2", FeatureChange("south", None, raw("south")), FeatureChange("north", raw("north", "Old"), None)
    )
    with pytest.raises(ChangedMeanwhile):
        maps.append(FARM, "anna", stale)
    there = maps.draft(FARM)
    assert there is not None
    assert set(there.features) == {"north"}


def test_a_walk_that_names_its_step_is_made_once_however_often_it_is_asked(maps: Maps, clock: FakeClock) -> None:
    maps.open(FARM, "anna", "Anna")
    for number in (1, 2, 3):
        maps.append(FARM, "anna", add(clock, f"ref-{number}", f"field-{number}"))
    once, twice = maps.undo(FARM, "anna", "ref-3"), maps.undo(FARM, "anna", "ref-3")
    assert once[1] == twice[1] == (FeatureChange("field-3", raw("field-3"), None),)
    assert set(twice[0].features) == {"field-1", "field-2"}
    maps.undo(FARM, "anna", "ref-2")
    once, twice = maps.redo(FARM, "anna", "ref-2"), maps.redo(FARM, "anna", "ref-2")
    assert once[1] == twice[1] == (FeatureChange("field-2", None, raw("field-2")),)
    assert set(twice[0].features) == {"field-1", "field-2"}


def test_a_walk_over_another_step_than_the_named_one_is_refused(maps: Maps, clock: FakeClock) -> None:
    maps.open(FARM, "anna", "Anna")
    for number in (1, 2):
        maps.append(FARM, "anna", add(clock, f"ref-{number}", f"field-{number}"))
    for work in (lambda: maps.undo(FARM, "anna", "ref-1"), lambda: maps.undo(FARM, "anna", "ref-9")):
        with pytest.raises(ChangedMeanwhile):
            work()
    maps.undo(FARM, "anna")
    maps.undo(FARM, "anna")
    with pytest.raises(ChangedMeanwhile):
        maps.redo(FARM, "anna", "ref-2")


def test_only_the_draft_that_the_editor_saw_is_published(maps: Maps, clock: FakeClock) -> None:
    maps.open(FARM, "anna", "Anna")
    maps.append(FARM, "anna", add(clock, "ref-1", "north"))
    maps.append(FARM, "anna", add(clock, "ref-2", "south"))
    with pytest.raises(ChangedMeanwhile):
        maps.publish(FARM, "anna", "Anna", "", "ref-1")
    assert maps.publish(FARM, "anna", "Anna", "", "ref-2").size == 2


def test_one_person_edits_and_the_lock_is_renewed_by_each_step(maps: Maps, clock: FakeClock) -> None:
    maps.open(FARM, "anna", "Anna")
    with pytest.raises(MapLocked) as refused:
        maps.open(FARM, "ben", "Ben")
    assert refused.value.by == "Anna"
    clock.advance((LOCK - timedelta(minutes=1)).total_seconds())
    maps.append(FARM, "anna", add(clock, "ref-1", "north"))
    clock.advance(120)
    with pytest.raises(MapLocked):
        maps.open(FARM, "ben", "Ben")
    clock.advance(LOCK.total_seconds())
    assert maps.open(FARM, "ben", "Ben").editor_name == "Ben"
    with pytest.raises(MapLocked):
        maps.append(FARM, "anna", add(clock, "ref-2", "south"))


def test_a_draft_is_taken_only_when_that_is_said(maps: Maps, clock: FakeClock) -> None:
    maps.open(FARM, "anna", "Anna")
    assert maps.open(FARM, "ben", "Ben", is_taking=True).editor_id == "ben"
    with pytest.raises(MapLocked):
        maps.publish(FARM, "anna", "Anna", "")


def test_nobody_publishes_over_a_version_that_the_draft_does_not_know(
    maps: Maps, database: Database, clock: FakeClock
) -> None:
    maps.open(FARM, "anna", "Anna")
    Features(database, clock).put([Feature("east", FARM, "parcel", "East", SQUARE)])
    maps.published(FARM)
    with pytest.raises(MapOutdated) as refused:
        maps.publish(FARM, "anna", "Anna", "")
    assert refused.value.number == 1


def test_two_farms_publish_features_of_the_same_id_and_each_keeps_its_own(
    maps: Maps, database: Database, clock: FakeClock
) -> None:
    Farms(database, clock).ensure("neighbour", "The neighbour's farm")
    for farm_id, name in ((FARM, "Ours"), ("neighbour", "Theirs")):
        maps.open(farm_id, "anna", "Anna")
        drawn = FeatureChange("north", None, raw("north", name))
        maps.append(farm_id, "anna", step(clock, f"ref-{farm_id}", drawn))
        maps.publish(farm_id, "anna", "Anna", "")
    features = Features(database, clock)
    features.put([Feature("east", FARM, "parcel", "East", SQUARE), Feature("east", "neighbour", "parcel", "O", SQUARE)])
    assert [features.get(farm, "north").name for farm in (FARM, "neighbour")] == ["Ours", "Theirs"]
    assert [one.name for one in features.all("neighbour")] == ["O", "Theirs"]
    maps.open(FARM, "anna", "Anna")
    maps.append(FARM, "anna", step(clock, "ref-9", FeatureChange("north", raw("north", "Ours"), None)))
    maps.publish(FARM, "anna", "Anna", "")
    assert [one.name for one in features.all("neighbour")] == ["O", "Theirs"]


def test_without_a_draft_nothing_can_be_changed(maps: Maps, clock: FakeClock) -> None:
    for work in (
        lambda: maps.append(FARM, "anna", add(clock, "ref-1", "north")),
        lambda: maps.undo(FARM, "anna"),
        lambda: maps.publish(FARM, "anna", "Anna", ""),
        lambda: maps.discard(FARM, "anna"),
        lambda: maps.features_of(FARM, 7),
    ):
        with pytest.raises(NotFound):
            work()


def test_a_discarded_draft_leaves_nothing(maps: Maps, clock: FakeClock) -> None:
    maps.open(FARM, "anna", "Anna")
    maps.append(FARM, "anna", add(clock, "ref-1", "north"))
    maps.discard(FARM, "anna")
    assert maps.draft(FARM) is None
    assert maps.open(FARM, "anna", "Anna").log == ()
