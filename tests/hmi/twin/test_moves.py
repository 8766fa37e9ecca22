"""Our messages that move a frame say what viser's own would say; a viser that says it otherwise is found here."""

from __future__ import annotations

import pytest
from viser import _messages

from hmi.twin.moves import Orientation, Position

NAME = "/machine/planter-02/column"
PAIRS = [
    (Position(NAME, (1.0, -2.5, 3.0)), _messages.SetPositionMessage(NAME, (1.0, -2.5, 3.0))),
    (Orientation(NAME, (0.6, 0.0, 0.0, 0.8)), _messages.SetOrientationMessage(NAME, (0.6, 0.0, 0.0, 0.8))),
]


@pytest.mark.parametrize(("ours", "theirs"), PAIRS, ids=["position", "orientation"])
def test_a_move_is_sent_kept_and_replaced_as_viser_does(
    ours: Position | Orientation, theirs: _messages.Message
) -> None:
    for message in (ours, theirs):
        message.owner = "7"  # type: ignore[union-attr]  # the scene stamps it
    assert ours.as_serializable_dict([]) == theirs.as_serializable_dict([])
    assert ours.redundancy_key() == theirs.redundancy_key()
    assert ours.entity_state_key() == theirs.entity_state_key()
    assert ours.lifecycle_phase == theirs.lifecycle_phase
