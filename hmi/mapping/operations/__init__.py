"""Operations on features: one transaction each, worked out in metres on a plane beside the features.

docs/protocols/map.md has the table of operations and their arguments.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

from hmi.mapping.attributes import LONGEST_NAME
from hmi.mapping.errors import BadFeature, OperationRefused
from hmi.mapping.feature import MapFeature, as_geojson, parse_feature
from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.buffer import buffer
from hmi.mapping.operations.clean import clean
from hmi.mapping.operations.clip import clip
from hmi.mapping.operations.close_gap import close_gap
from hmi.mapping.operations.cut_antimeridian import cut_antimeridian
from hmi.mapping.operations.hole import add_hole, remove_hole
from hmi.mapping.operations.merge import merge
from hmi.mapping.operations.move import shift, turn
from hmi.mapping.operations.orient import orient
from hmi.mapping.operations.outcome import Change, Outcome
from hmi.mapping.operations.remove import remove
from hmi.mapping.operations.selection import Selection
from hmi.mapping.operations.simplify import simplify
from hmi.mapping.operations.snap_end import snap_end
from hmi.mapping.operations.split import split
from hmi.mapping.operations.straighten import straighten
from hmi.mapping.operations.straighten_all import straighten_all
from hmi.mapping.operations.swap_axes import swap_axes
from hmi.mapping.operations.untangle import untangle

__all__ = ["OPERATIONS", "Change", "Outcome", "apply"]


class Operation(NamedTuple):
    """What does it, and the names of its arguments."""

    do: Callable[[Selection, Arguments], Outcome]
    arguments: frozenset[str] = frozenset()


OPERATIONS: MappingProxyType[str, Operation] = MappingProxyType(
    {
        "split": Operation(split, frozenset({"line"})),
        "merge": Operation(merge, frozenset({"gap_m"})),
        "buffer": Operation(buffer, frozenset({"distance_m"})),
        "straighten": Operation(straighten, frozenset({"from", "to", "ring"})),
        "straighten_all": Operation(straighten_all, frozenset({"within_deg"})),
        "simplify": Operation(simplify, frozenset({"tolerance_m"})),
        "shift": Operation(shift, frozenset({"east_m", "north_m"})),
        "turn": Operation(turn, frozenset({"angle_deg"})),
        "add_hole": Operation(add_hole, frozenset({"ring"})),
        "remove_hole": Operation(remove_hole, frozenset({"ring"})),
        "clip": Operation(clip, frozenset({"others"})),
        "orient": Operation(orient),
        "clean": Operation(clean),
        "untangle": Operation(untangle),
        "snap_end": Operation(snap_end, frozenset({"to"})),
        "swap_axes": Operation(swap_axes),
        "close_gap": Operation(close_gap, frozenset({"to", "width_m"})),
        "cut_antimeridian": Operation(cut_antimeridian),
        "remove": Operation(remove),
    }
)


def apply(op: str, features: Mapping[str, MapFeature], ids: Sequence[str], args: Mapping[str, Any]) -> Outcome:
    """Return what an operation would change; ``features`` stays as it is.

    Args:
        op: a name of ``OPERATIONS``.
        features: the whole draft by id.
        ids: the features chosen.
        args: as in the table of operations; metres, degrees, positions as ``[longitude, latitude]``.

    Raises:
        OperationRefused: the operation is not known, an argument is wrong, or it does not fit these features.
    """
    if op not in OPERATIONS:
        raise OperationRefused("unknown_operation", f"{op[:40]!r} is no operation. Use one of {', '.join(OPERATIONS)}.")
    operation = OPERATIONS[op]
    outcome = operation.do(Selection.of(features, ids), Arguments(args, operation.arguments))
    return Outcome(outcome.label, tuple(_checked(change) for change in outcome.changes))


def _checked(change: Change) -> Change:
    """Hold the result to the rules of every feature; it shares no list with the draft."""
    if change.after is None:
        return change
    try:
        after = parse_feature(as_geojson(change.after))
        is_renamed = change.before is None or change.before.name != after.name
        return replace(change, after=replace(after, name=after.name[:LONGEST_NAME]) if is_renamed else after)
    except BadFeature as error:
        raise OperationRefused(error.code, error.text) from error
