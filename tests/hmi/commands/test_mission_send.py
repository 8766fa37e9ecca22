"""Sending a mission: read back and compared; and what a person saw, recorded and nothing more."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from typing import Any

import pytest

from hmi.commands.mission_send import Way
from hmi.commands.ports import StoredMission
from hmi.commands.refusal import OrderRefused
from hmi.domain.command import Acknowledgement, Outcome
from hmi.store.errors import DatabaseUnavailable
from tests.hmi.commands.field import MARTHA, SHA, VERA, Field, factsheet


async def test_a_mission_the_robot_read_back_is_sent() -> None:
    field = Field()
    sent = await field.desk.missions.send(MARTHA, "weeder-01", "field-1")
    assert (sent.outcome, sent.sha256) == (Outcome.ACCEPTED, SHA)
    assert field.missions.noted == [("field-1", "weeder-01")]
    assert field.audit.outcomes("mission") == ["accepted"]
    assert field.events_of("mission")[-1]["mission_id"] == "field-1"
    assert field.desk.leases.of("weeder-01") is None


async def test_another_hash_is_no_mission() -> None:
    field = Field()
    field.weeder.stored_sha256 = "b" * 64
    sent = await field.desk.missions.send(MARTHA, "weeder-01", "field-1")
    assert (sent.outcome, sent.code) == (Outcome.REJECTED, "hash_mismatch")
    assert field.missions.noted == []


async def test_silence_leaves_it_unknown_whether_the_robot_has_it() -> None:
    field = Field()
    field.weeder.is_silent = True
    sent = await field.desk.missions.send(MARTHA, "weeder-01", "field-1")
    assert sent.outcome is Outcome.UNKNOWN
    assert field.missions.noted == []


async def test_the_robots_refusal_comes_back_in_its_words() -> None:
    field = Field()
    field.weeder.refuse_with = ("mission_active", "It works on another mission.")
    sent = await field.desk.missions.send(MARTHA, "weeder-01", "field-1")
    assert (sent.outcome, sent.text) == (Outcome.REJECTED, "It works on another mission.")


async def test_a_mission_goes_by_the_way_that_was_chosen_and_by_no_other() -> None:
    field = Field()
    without = await field.desk.missions.send(MARTHA, "weeder-01", "field-1", way=Way.CLOUD)
    assert (without.outcome, without.code, without.way) == (Outcome.REJECTED, "no_cloud", Way.CLOUD)
    assert field.missions.noted == []
    cloud = CloudWay()
    field.desk.missions.cloud = cloud
    sent = await field.desk.missions.send(MARTHA, "weeder-01", "field-1", way=Way.CLOUD)
    assert (sent.outcome, cloud.robots) == (Outcome.ACCEPTED, ["weeder-01"])
    assert "through the cloud in" in sent.text
    assert field.events_of("mission")[-1]["way"] == "cloud"
    direct = await field.desk.missions.send(MARTHA, "weeder-01", "field-1")
    assert (direct.way, cloud.robots) == (Way.DIRECT, ["weeder-01"])
    assert "cloud" not in direct.text


class CloudWay:
    """Takes every mission."""

    def __init__(self) -> None:
        self.robots: list[str] = []

    async def upload_mission(self, robot_id: str, document: dict[str, Any]) -> Acknowledgement:
        """See ``MissionWay``."""
        self.robots.append(robot_id)
        return Acknowledgement(robot_id, "mission", "field-1", True, "ok", "", None, SHA, None)


async def test_who_may_not_send_and_what_is_not_there_is_refused() -> None:
    field = Field()
    assert (await field.desk.missions.send(VERA, "weeder-01", "field-1")).code == "not_allowed"
    assert (await field.desk.missions.send(MARTHA, "weeder-01", "field-9")).code == "unknown_mission"


async def test_a_path_driven_backwards_is_not_sent_to_a_robot_that_follows_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    field = Field()
    source = field.missions.stored

    async def backing(farm_id: str, mission_id: str, robot_id: str, by: str) -> StoredMission | None:
        stored = await source(farm_id, mission_id, robot_id, by)
        assert stored is not None
        return replace(stored, document={**stored.document, "segments": [{"kind": "turn", "backward": True}]})

    monkeypatch.setattr(field.missions, "stored", backing)
    field.weeder.factsheet = factsheet()
    sent = await field.desk.missions.send(MARTHA, "weeder-01", "field-1")
    assert (sent.outcome, sent.code) == (Outcome.REJECTED, "no_reverse")
    assert "Plan the mission for it" in sent.text
    field.weeder.factsheet = factsheet(path_reverse_mps=0.5)
    assert (await field.desk.missions.send(MARTHA, "weeder-01", "field-1")).outcome is Outcome.ACCEPTED


async def test_the_store_may_refuse_with_a_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    field = Field()

    async def far(*_args: str) -> StoredMission:
        raise OrderRefused("too_far", "The robot is 12 km away.")

    monkeypatch.setattr(field.missions, "stored", far)
    sent = await field.desk.missions.send(MARTHA, "weeder-01", "field-1")
    assert (sent.outcome, sent.text) == (Outcome.REJECTED, "The robot is 12 km away.")


async def test_a_status_that_cannot_be_stored_does_not_unsend_a_mission(monkeypatch: pytest.MonkeyPatch) -> None:
    field = Field()

    async def away(*_args: str) -> None:
        raise DatabaseUnavailable("disk full")

    monkeypatch.setattr(field.missions, "sent", away)
    assert (await field.desk.missions.send(MARTHA, "weeder-01", "field-1")).outcome is Outcome.ACCEPTED


async def test_one_mission_at_a_time_goes_to_a_robot() -> None:
    field = Field()
    both = await asyncio.gather(*(field.desk.missions.send(MARTHA, "weeder-01", "field-1") for _ in range(2)))
    assert sorted(s.code for s in both) == ["busy", "ok"]
    assert (await field.desk.missions.send(MARTHA, "weeder-01", "field-1")).code == "ok"


def test_what_a_person_saw_is_recorded_under_the_press() -> None:
    field = Field()
    field.desk.seen.note(VERA, "weeder-01", "stop-000001")
    [entry] = field.audit.entries
    assert (entry.kind, entry.ref, entry.actor) == ("seen", "stop-000001", "Vera Lang")
    assert field.events == []
    with pytest.raises(OrderRefused):
        field.desk.seen.note(VERA, "weeder-99", "stop-000001")
