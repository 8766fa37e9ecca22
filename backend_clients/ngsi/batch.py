"""Many entities in few requests, and what became of each."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Literal

from backend_clients.http.trouble import Trouble
from backend_clients.ngsi.connection import MAX_REQUEST, Call, Connection
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.errors import (
    BadInput,
    BrokerRefused,
    NgsiError,
    NotAllowed,
    NotFound,
    Overloaded,
    TooLarge,
    Unreachable,
    Unreadable,
)
from backend_clients.ngsi.identifier import EntityRef

Action = Literal["append", "appendStrict", "update", "delete", "replace"]
MAX_ENTITIES = 200  # keeps one request, and what a failure leaves open, small
ROOM = 200  # for what surrounds the entities
NARROW = 4096  # bytes that any way to a broker must take: a proxy that refuses them refuses everything


@dataclass(slots=True)
class BatchOutcome:
    """What became of each entity of a batch.

    Args:
        done: these took effect as a whole.
        failed: these did not, or not wholly, or nobody knows; each with its reason.
        too_large: entities in the smallest request of several that was refused as too large, ``None`` if none was.
    """

    done: list[EntityRef] = field(default_factory=list)
    failed: dict[EntityRef, NgsiError] = field(default_factory=dict)
    too_large: int | None = None

    def is_complete(self) -> bool:
        """Say whether everything took effect."""
        return not self.failed

    def unknown(self) -> list[EntityRef]:
        """Return those of which nobody knows whether they took effect."""
        return [ref for ref, error in self.failed.items() if error.is_outcome_unknown]


async def run(
    connection: Connection, action: Action, entities: Sequence[Entity], most: int = MAX_ENTITIES
) -> BatchOutcome:
    """Do one action on all entities; a refused part is halved until it is known which ones the broker refuses.

    Once the broker cannot be reached or lets nobody in, the rest fails with that reason without being sent.
    ``appendStrict`` is never sent twice: a refused part of it fails as a whole.
    With ``delete`` what is not there counts as done when it was sent among others: the broker does not say of which
    entity it was the first time.

    Args:
        most: entities in one request.
    """
    outcome = BatchOutcome()
    wire = _checked(entities, outcome)
    stop: NgsiError | None = None
    waiting = [(part, False) for part in _parts(wire, most)]
    while waiting:
        part, is_half = waiting.pop(0)
        refs = [ref for ref, _ in part]
        if stop is not None:
            outcome.failed.update(dict.fromkeys(refs, stop))
            continue
        error = await _send(connection, action, [body for _, body in part])
        if isinstance(error, TooLarge):
            if len(part) > 1:
                outcome.too_large = len(part)
            elif error.is_of_proxy and len(part[0][1]) <= NARROW:
                error.trouble = Trouble.NARROW
        is_gone = isinstance(error, NotFound) and action == "delete" and len(part) == 1 and is_half
        if error is None or is_gone:  # gone: the whole part was sent, and what was there of it is deleted by that
            outcome.done += refs
        elif _ends_all(error):
            outcome.failed.update(dict.fromkeys(refs, error))
            stop = _not_sent(error)
        elif len(part) == 1 or action == "appendStrict":
            outcome.failed.update(dict.fromkeys(refs, error))
        else:
            middle = len(part) // 2
            waiting[:0] = [(part[:middle], True), (part[middle:], True)]
    return outcome


_Part = list[tuple[EntityRef, bytes]]


def _checked(entities: Iterable[Entity], outcome: BatchOutcome) -> _Part:
    wire: _Part = []
    seen: set[EntityRef] = set()
    for entity in entities:
        if entity.ref in seen:
            raise BadInput(f"twice in one batch: {entity.ref.id}")
        seen.add(entity.ref)
        try:
            body = json.dumps(entity.to_wire(), ensure_ascii=False, allow_nan=False).encode()
            if len(body) > MAX_REQUEST - ROOM:
                raise BadInput(f"{entity.ref.id}: {len(body)} bytes are more than a broker takes at once")
        except BadInput as error:
            outcome.failed[entity.ref] = error
        else:
            wire.append((entity.ref, body))
    return wire


def _parts(wire: _Part, most: int) -> Iterable[_Part]:
    part: _Part = []
    size = ROOM
    for ref, body in wire:
        if part and (len(part) >= most or size + len(body) + 1 > MAX_REQUEST):
            yield part
            part, size = [], ROOM
        part.append((ref, body))
        size += len(body) + 1
    if part:
        yield part


async def _send(connection: Connection, action: Action, bodies: list[bytes]) -> NgsiError | None:
    body = b'{"actionType":"%s","entities":[%s]}' % (action.encode(), b",".join(bodies))
    try:
        call = Call("POST", "v2/op/update", body=body, is_repeatable=action != "appendStrict")
        reply = await connection.send(call)
    except NotFound as error:
        if action == "delete" and len(bodies) == 1 and error.attempts > 1:
            return None  # after a lost answer it is gone because we deleted it
        return error
    except NgsiError as error:
        return error
    return None if reply.status == 204 else _no_broker(reply.status)


def _no_broker(status: int) -> Unreadable:
    """Return the error for an answer that no broker gives: a sign-in page answers 200 to everything."""
    error = Unreadable(f"the answer to a batch is {status}, not that of a context broker")
    error.is_outcome_unknown = True
    return error


def _ends_all(error: NgsiError) -> bool:
    if not isinstance(error, BrokerRefused) or error.trouble is Trouble.NARROW:
        return True
    return isinstance(error, NotAllowed | Overloaded) or error.status >= 500


def _not_sent(error: NgsiError) -> Unreachable:
    return Unreachable(f"not sent, since an earlier part failed: {error}")
