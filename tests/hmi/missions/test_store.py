"""Missions and map features on disk and in memory."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta

import pytest

from hmi.domain.mission import BadMove, MissionStatus, Mover
from hmi.domain.mission_document import mission_sha256
from hmi.domain.mission_plan import MissionRefused
from hmi.planning.mission import plan_mission
from hmi.store.errors import AlreadyExists, NotFound
from hmi.store.features import Feature, feature_collection
from hmi.store.missions import Mission, Missions
from tests.hmi.missions.rig import FARM, OTHER_FARM, Rig, farm_map, parcel_geometry
from tests.hmi.missions.test_document import wish

S = MissionStatus


def put(rig: Rig, mission_id: str = "m-1", status: MissionStatus = S.VALIDATED) -> Mission:
    planned = plan_mission(wish(mission_id=mission_id))
    now = rig.clock.utc()
    mission = Mission(mission_id, FARM, "Home field", "Home field", status, "", "Pieter", now, now, "weeder-01")
    return rig.missions.add(replace(mission, statistics=planned.statistics), planned.document, "Planned.")


def through(rig: Rig, mission_id: str, *steps: tuple[MissionStatus, Mover]) -> None:
    for after, mover in steps:
        rig.missions.move(FARM, mission_id, after, mover, "Martha Keller")


RUN = ((S.SENT, Mover.PERSON), (S.ACCEPTED, Mover.ROBOT), (S.RUNNING, Mover.ROBOT), (S.DONE, Mover.ROBOT))


def test_a_mission_is_read_back_as_it_was_stored(rig: Rig) -> None:
    stored = put(rig)
    again = Missions(rig.database, rig.clock)
    again.load()
    assert again.known("m-1") == stored
    assert mission_sha256(again.document(FARM, "m-1")) == stored.sha256


def test_an_id_is_used_once(rig: Rig) -> None:
    put(rig)
    with pytest.raises(AlreadyExists):
        put(rig)


def test_the_log_says_who_moved_it_on_and_when(rig: Rig) -> None:
    put(rig)
    rig.clock.advance(60)
    rig.missions.move(FARM, "m-1", S.SENT, Mover.PERSON, "Martha Keller", "Sent.", robot_id="weeder-02")
    first, second = rig.missions.log(FARM, "m-1")
    assert (first.status, first.by, first.why) == (S.VALIDATED, "Pieter", "Planned.")
    assert (second.status, second.by, second.why) == (S.SENT, "Martha Keller", "Sent.")
    assert second.at - first.at == timedelta(seconds=60)


def test_sending_to_another_robot_addresses_the_document_to_it(rig: Rig) -> None:
    before = put(rig)
    after, change = rig.missions.move(FARM, "m-1", S.SENT, Mover.PERSON, "Martha", robot_id="weeder-02")
    document = rig.missions.document(FARM, "m-1")
    assert document["robot"] == after.robot_id == "weeder-02"
    assert after.sha256 == mission_sha256(document) != before.sha256
    assert (change.before, change.after) == (S.VALIDATED, S.SENT)


def test_a_move_the_table_lacks_changes_nothing(rig: Rig) -> None:
    before = put(rig)
    with pytest.raises(BadMove):
        rig.missions.move(FARM, "m-1", S.DONE, Mover.ROBOT, "Weeder 01")
    assert rig.missions.known("m-1") == before
    assert len(rig.missions.log(FARM, "m-1")) == 1


def test_a_new_name_is_in_document_and_hash(rig: Rig) -> None:
    before = put(rig)
    after = rig.missions.rename(FARM, "m-1", "Beets north", "Pieter")
    assert after.name == rig.missions.document(FARM, "m-1")["name"] == "Beets north"
    assert after.sha256 != before.sha256


def test_a_mission_on_a_robot_is_not_renamed_underneath_it(rig: Rig) -> None:
    put(rig)
    through(rig, "m-1", *RUN[:2])
    with pytest.raises(MissionRefused, match="Copy it instead"):
        rig.missions.rename(FARM, "m-1", "Other", "Pieter")


def test_a_mission_that_never_ran_is_deleted_with_its_log(rig: Rig) -> None:
    put(rig)
    deleted: list[Mission] = []
    rig.missions.on_deleted(deleted.append)
    rig.missions.delete(FARM, "m-1")
    assert [one.id for one in deleted] == ["m-1"]
    assert rig.missions.known("m-1") is None
    with pytest.raises(NotFound):
        rig.missions.document(FARM, "m-1")


def test_the_record_of_a_mission_that_ran_is_kept(rig: Rig) -> None:
    put(rig)
    through(rig, "m-1", *RUN)
    with pytest.raises(MissionRefused, match="its record is kept"):
        rig.missions.delete(FARM, "m-1")


def test_a_mission_that_came_back_from_a_robot_keeps_its_record_too(rig: Rig) -> None:
    put(rig)
    through(rig, "m-1", *RUN[:2], (S.VALIDATED, Mover.ROBOT))
    with pytest.raises(MissionRefused):
        rig.missions.delete(FARM, "m-1")


def test_another_farm_sees_and_touches_nothing(rig: Rig) -> None:
    put(rig)
    assert rig.missions.all_known(OTHER_FARM) == []
    for touch in (rig.missions.document, rig.missions.delete):
        with pytest.raises(NotFound):
            touch(OTHER_FARM, "m-1")


def test_missions_come_newest_change_first(rig: Rig) -> None:
    for mission_id in ("m-1", "m-2", "m-3"):
        put(rig, mission_id)
        rig.clock.advance(1)
    rig.missions.move(FARM, "m-1", S.SENT, Mover.PERSON, "Martha")
    assert [one.id for one in rig.missions.all_known(FARM)] == ["m-1", "m-3", "m-2"]


def test_listeners_hear_of_every_change(rig: Rig) -> None:
    heard: list[MissionStatus] = []
    rig.missions.on_changed(lambda mission: heard.append(mission.status))
    put(rig)
    through(rig, "m-1", *RUN)
    assert heard == [S.VALIDATED, S.SENT, S.ACCEPTED, S.RUNNING, S.DONE]


def test_features_are_read_back_and_told_as_geojson(rig: Rig) -> None:
    found = rig.features.all(FARM)
    assert {one.id for one in found} == {one.id for one in farm_map()}
    collection = feature_collection(rig.features.all(FARM, ("home",)))
    assert collection["features"][0]["properties"] == {
        "robot": "weeder-01",
        "id": "home-1",
        "kind": "home",
        "name": "Garage",
    }


def test_a_feature_of_another_farm_is_neither_shown_nor_replaced(rig: Rig) -> None:
    with pytest.raises(NotFound):
        rig.features.get(OTHER_FARM, "field-1")
    ours = rig.features.get(FARM, "field-1")
    rig.features.put([Feature("field-1", OTHER_FARM, "parcel", "Theirs", parcel_geometry())])
    assert rig.features.get(OTHER_FARM, "field-1").name == "Theirs"
    assert rig.features.get(FARM, "field-1") == ours
