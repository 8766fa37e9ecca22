"""Update operators in a value, ``{"$inc": 1}`` and its kin."""

from __future__ import annotations

from collections.abc import Callable

from backend_clients.simulator.context_broker.json_text import Json
from backend_clients.simulator.context_broker.refusal import Refusal, bad_request


def apply_operator(before: Json, value: Json) -> Json:
    """Return the value after the operator in ``value``; a value without one is itself."""
    if not isinstance(value, dict) or not any(name.startswith("$") for name in value):
        return value
    names = set(value) - {"$unset"} if set(value) == {"$set", "$unset"} else set(value)
    if len(names) != 1 or not names <= _OPERATORS.keys():
        raise bad_request(f"invalid update operator: {', '.join(sorted(value))}"[:200])
    result = before
    for name, operand in value.items():
        result = _OPERATORS[name](result, operand)
    return result


def _arithmetic(rule: Callable[[float, float], float], start: float | None) -> Callable[[Json, Json], Json]:
    def apply(before: Json, operand: Json) -> Json:
        if not _is_number(operand):
            raise bad_request("the operand of this operator must be a number")
        if before is None:
            return operand if start is None else rule(start, operand)
        if not _is_number(before):
            raise Refusal(500, "InternalServerError", "Database Error: cannot apply to a value of non-numeric type")
        return rule(before, operand)

    return apply


def _listed(rule: Callable[[list[Json], Json], list[Json]]) -> Callable[[Json, Json], Json]:
    def apply(before: Json, operand: Json) -> Json:
        if before is not None and not isinstance(before, list):
            raise Refusal(500, "InternalServerError", "Database Error: the value must be an array")
        return rule(before or [], operand)

    return apply


def _set(before: Json, operand: Json) -> Json:
    if not isinstance(operand, dict):
        raise bad_request("the operand of $set must be an object")
    return {**(before if isinstance(before, dict) else {}), **operand}


def _unset(before: Json, operand: Json) -> Json:
    gone = operand if isinstance(operand, dict) else {}
    return {k: v for k, v in before.items() if k not in gone} if isinstance(before, dict) else before


def _pull_all(before: list[Json], operand: Json) -> list[Json]:
    return [item for item in before if item not in (operand if isinstance(operand, list) else [operand])]


def _is_number(value: Json) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


_OPERATORS: dict[str, Callable[[Json, Json], Json]] = {
    "$inc": _arithmetic(lambda a, b: a + b, 0),
    "$mul": _arithmetic(lambda a, b: a * b, 0),
    "$min": _arithmetic(min, None),
    "$max": _arithmetic(max, None),
    "$push": _listed(lambda items, new: [*items, new]),
    "$addToSet": _listed(lambda items, new: items if new in items else [*items, new]),
    "$pull": _listed(lambda items, gone: [item for item in items if item != gone]),
    "$pullAll": _listed(_pull_all),
    "$set": _set,
    "$unset": _unset,
}
