"""Several plans for one wish, streamed as lines of JSON as they are made."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import aclosing
from typing import Any

import msgspec
from starlette.responses import StreamingResponse

from hmi.commands.mission_book import CandidateAnswer
from hmi.domain.mission_plan import Pattern

NDJSON = "application/x-ndjson"


def candidate_stream(answers: AsyncIterator[CandidateAnswer]) -> StreamingResponse:
    """Return a stream: first the patterns to come, then a line for each, at the end ``{"state": "done"}``.

    A planner that tells how far it is gives lines with state ``progress`` before a pattern's own.

    Leaving early (the browser closes the connection) ends the planning.
    """
    return StreamingResponse(_lines(answers), media_type=NDJSON, headers={"Cache-Control": "no-store"})


async def _lines(answers: AsyncIterator[CandidateAnswer]) -> AsyncIterator[bytes]:
    yield _line({"state": "planning", "patterns": [pattern.value for pattern in Pattern]})
    async with aclosing(answers) as open_answers:  # type: ignore[type-var]
        async for answer in open_answers:
            yield _line(_told(answer))
    yield _line({"state": "done"})


def _told(answer: CandidateAnswer) -> dict[str, Any]:
    line: dict[str, Any] = {"pattern": answer.pattern.value}
    if answer.progress is not None:
        share, words = answer.progress
        return {**line, "state": "progress", "share": round(share, 3), "text": words}
    if answer.refusal is not None:
        refusal = answer.refusal
        return {**line, "state": "refused", "code": refusal.code, "text": refusal.text, "field": refusal.field or None}
    if answer.same_as is not None:
        return {**line, "state": "same", "as": answer.same_as.value}
    assert answer.candidate is not None
    return {
        **line,
        "state": "planned",
        "statistics": answer.candidate.statistics,
        "drawing": answer.candidate.drawing,
    }


def _line(value: dict[str, Any]) -> bytes:
    return msgspec.json.encode(value) + b"\n"
