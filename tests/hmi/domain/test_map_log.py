"""Transactions on a map draft."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.map_log import (
    ChangedMeanwhile,
    FeatureChange,
    MapFeatures,
    Transaction,
    applied,
    next_redo,
    next_undo,
    taken_back,
)

IDS = st.sampled_from(["a", "b", "c", "d"])
CONTENT = st.none() | st.builds(lambda n: {"n": n}, st.integers(0, 3))


def feature(n: int) -> dict[str, Any]:
    """Return something that stands for a feature."""
    return {"n": n}


def test_a_change_is_made_only_on_what_was_seen() -> None:
    there = {"a": feature(1)}
    assert applied(there, [FeatureChange("a", feature(1), feature(2))]) == {"a": feature(2)}
    assert applied(there, [FeatureChange("a", feature(1), None)]) == {}
    assert applied(there, [FeatureChange("b", None, feature(3))]) == {"a": feature(1), "b": feature(3)}
    assert there == {"a": feature(1)}


@pytest.mark.parametrize(
    "change",
    [
        FeatureChange("a", feature(7), feature(2)),
        FeatureChange("a", None, feature(2)),
        FeatureChange("b", feature(1), None),
    ],
)
def test_one_change_that_does_not_fit_refuses_all(change: FeatureChange) -> None:
    with pytest.raises(ChangedMeanwhile) as refused:
        applied({"a": feature(1)}, [FeatureChange("c", None, feature(5)), change])
    assert refused.value.ids == (change.id,)


@pytest.mark.slow
@given(st.lists(st.lists(st.tuples(IDS, CONTENT), min_size=1, max_size=4), max_size=8))
def test_taking_everything_back_gives_the_beginning_and_doing_it_again_the_end(
    steps: list[list[tuple[str, dict[str, Any] | None]]],
) -> None:
    state: MapFeatures = {}
    made = []
    for step in steps:
        changes = []
        for key, after in step:
            before = state.get(key)
            state = applied(state, [FeatureChange(key, before, after)])
            changes.append(FeatureChange(key, before, after))
        made.append(tuple(changes))
    back = state
    for one in reversed(made):
        back = applied(back, taken_back(one))
    assert back == {}
    again: MapFeatures = {}
    for one in made:
        again = applied(again, one)
    assert again == state


def test_undo_takes_the_newest_and_redo_the_one_taken_back_last() -> None:
    def one(ref: str, *, is_undone: bool) -> Transaction:
        return Transaction(ref, ref, "Anna", datetime(2026, 5, 20, tzinfo=UTC), (), is_undone)

    log = [one("a", is_undone=False), one("b", is_undone=False), one("c", is_undone=True), one("d", is_undone=True)]
    undo, redo = next_undo(log), next_redo(log)
    assert undo is not None
    assert redo is not None
    assert (undo.ref, redo.ref) == ("b", "c")
    assert next_undo(log[2:]) is None
    assert next_redo(log[:2]) is None
