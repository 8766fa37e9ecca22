"""Missions that are not planned yet: what a person chose so far, under the id the mission will keep.

Blocking; call through ``Database.run``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from sqlalchemy.orm import Session

from hmi.domain.mission import MissionStatus, Mover, check_move
from hmi.domain.mission_document import Document
from hmi.domain.mission_plan import MissionRefused
from hmi.store.missions import Mission, Missions


def refuse_planned(mission: Mission) -> None:
    """Return if a mission is a draft.

    Raises:
        MissionRefused: it has a plan.
    """
    if mission.status is not MissionStatus.DRAFT:
        raise MissionRefused("no_draft", f"{mission.name} is no draft any more: it was planned. Copy it.")


def refuse_draft(mission: Mission) -> None:
    """Return if a mission has a plan.

    Raises:
        MissionRefused: it is a draft.
    """
    if mission.status is MissionStatus.DRAFT:
        raise MissionRefused("draft", f"{mission.name} is a draft. Open it and plan it first.")


class MissionDrafts:
    """Changes drafts, and makes them missions. ``revision`` of a draft counts how often it was saved."""

    def __init__(self, missions: Missions) -> None:
        self._missions = missions

    def save(
        self, farm_id: str, mission_id: str, revision: int, name: str, wish: Mapping[str, Any], field_name: str, by: str
    ) -> Mission:
        """Keep other choices.

        Args:
            revision: of the draft that was changed.

        Raises:
            NotFound: there is no such mission.
            MissionRefused: it is no draft any more, or somebody else saved it since.
        """

        def change(_session: Session, mission: Mission, document: Document) -> tuple[Mission, Document]:
            _refuse_other(mission, revision)
            return with_wish(replace(mission, name=name, revision=revision + 1), wish, field_name), document

        return self._missions.change(farm_id, mission_id, change, by, "Draft saved.")

    def complete(self, planned: Mission, document: Document, revision: int, by: str, why: str) -> Mission:
        """Give a draft its plan; who began it stays.

        Raises:
            NotFound: it was deleted meanwhile.
            MissionRefused: it is no draft any more, or somebody else saved it since.
        """

        def change(_session: Session, mission: Mission, _document: Document) -> tuple[Mission, Document]:
            _refuse_other(mission, revision)
            check_move(mission.status, planned.status, Mover.PERSON)
            return replace(planned, created_by=mission.created_by, created_at=mission.created_at, wish=None), document

        return self._missions.change(planned.farm_id, planned.id, change, by, why)


def with_wish(mission: Mission, wish: Mapping[str, Any], field_name: str) -> Mission:
    """Return a draft with these choices, and what of them its list shows."""
    return replace(
        mission,
        wish=dict(wish),
        field_id=wish.get("field_id"),
        field_name=field_name,
        robot_id=wish.get("robot_id"),
        is_supervised=wish.get("is_supervised", True),
    )


def _refuse_other(mission: Mission, revision: int) -> None:
    refuse_planned(mission)
    if mission.revision != revision:
        text = f"Somebody saved {mission.name} since you opened it. Open it again; nothing of theirs was changed."
        raise MissionRefused("draft_changed", text)
