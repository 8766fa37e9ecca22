"""What a farmer can read about a parcel's crop, stage and dates over the published maps."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

import pytest

from hmi.mapping.errors import BadFeature
from hmi.mapping.history import Entry, Published, attribute_history
from tests.hmi.mapping.farms import area, box


def published(version: int, properties: dict[str, Any] | None) -> Published:
    return Published(version, "Jonas", datetime(2026, 4, version, tzinfo=UTC), f"note {version}", properties)


def told(*versions: dict[str, Any] | None) -> list[Entry]:
    return attribute_history([published(n, one) for n, one in enumerate(versions, 1)])


def lines(entries: list[Entry]) -> list[tuple[int, str, Any, Any]]:
    return [(one.version, one.label, one.before, one.after) for one in entries]


def test_every_change_of_a_value_is_told_newest_first() -> None:
    found = told(
        {"name": "Nord", "crop": "Maize"},
        {"name": "Nord", "crop": "Maize", "status": "BBCH 12"},
        {"name": "Nord", "crop": "Sugar beet", "status": "BBCH 10", "row_spacing_m": 0.45},
    )
    assert lines(found) == [
        (3, "Crop", "Maize", "Sugar beet"),
        (3, "Growth stage", "BBCH 12", "BBCH 10"),
        (3, "Row spacing", None, 0.45),
        (2, "Growth stage", None, "BBCH 12"),
        (1, "Name", None, "Nord"),
        (1, "Crop", None, "Maize"),
    ]
    assert (found[0].by, found[0].note) == ("Jonas", "note 3")


def test_a_parcel_that_is_drawn_later_and_removed_says_so() -> None:
    found = told(None, {"crop": "Maize"}, None)
    assert lines(found) == [(3, "Crop", "Maize", None), (3, "Removed", None, None), (2, "Crop", None, "Maize"),
                            (2, "Drawn", None, None)]  # fmt: skip


def test_a_value_holds_from_the_day_that_was_given_with_it() -> None:
    first = {"crop": "Maize", "valid_from": {"crop": "2026-03-20"}}
    assert told(first)[0].valid_from == "2026-03-20"
    later = {"crop": "Maize", "valid_from": {"crop": "2026-03-22"}}
    assert [(one.after, one.valid_from) for one in told(first, later)] == [
        ("Maize", "2026-03-22"),
        ("Maize", "2026-03-20"),
    ]


def test_a_day_that_was_given_for_the_old_value_is_not_told_of_the_new_one() -> None:
    days = {"valid_from": {"crop": "2026-03-20"}}
    assert told({"crop": "Maize", **days}, {"crop": "Beet", **days})[0].valid_from is None


@pytest.mark.parametrize("days", [{"crop": "soon"}, {"weather": "2026-01-01"}, ["crop"], {"crop": 2026}])
def test_a_day_that_is_none_is_refused(days: Any) -> None:
    with pytest.raises(BadFeature, match="bad_valid_from"):
        area("a", box(0, 0, 9, 9), valid_from=days)
