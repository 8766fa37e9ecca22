"""What the routes of the map answer, and how the map's refusals become errors of a request."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import datetime
from typing import Any

from fastapi.responses import JSONResponse

from hmi.api.errors import ApiError, answer
from hmi.commands.map_book import MapBlocked, MapShrinks
from hmi.domain.map_log import ChangedMeanwhile, FeatureChange, MapFeatures, Transaction, next_redo, next_undo
from hmi.map_files.errors import BadMapFile
from hmi.mapping.errors import BadFeature, BadWalk, OperationRefused
from hmi.security.session_info import SessionInfo
from hmi.store.maps import MapDraft, MapLocked, MapOutdated, MapVersion

LOG_SHOWN = 50
NAMES_SHOWN = 2  # one is named, several are not


def collection(features: MapFeatures) -> dict[str, Any]:
    """Return features as a GeoJSON FeatureCollection."""
    return {"type": "FeatureCollection", "features": list(features.values())}


def version_json(version: MapVersion) -> dict[str, Any]:
    """Return a version without its features."""
    return {
        "version": version.number,
        "published_utc": utc(version.published_at),
        "by": version.by,
        "note": version.note,
        "size": version.size,
    }


def state_json(draft: MapDraft, session: SessionInfo) -> dict[str, Any]:
    """Return everything about a draft but its features."""
    undo, redo = next_undo(draft.log), next_redo(draft.log)
    return {
        "base_version": draft.base_version,
        "saved_utc": utc(draft.saved_at),
        "editor": {"user": draft.editor_id, "name": draft.editor_name},
        "until_utc": utc(draft.locked_until),
        "left_s": round(draft.left_s, 1),
        "is_mine": draft.editor_id == session.user_id,
        "undo": undo.label if undo else None,
        "redo": redo.label if redo else None,
        "undo_id": undo.ref if undo else None,
        "redo_id": redo.ref if redo else None,
        "log": [
            {
                "id": one.ref,
                "label": one.label,
                "names": _names(one),
                "by": one.by,
                "utc": utc(one.at),
                "is_undone": one.is_undone,
            }
            for one in reversed(draft.log[-LOG_SHOWN:])
        ],
    }


def _names(transaction: Transaction) -> list[str]:
    """Return the names of what was changed, as they were before; without those that have none."""
    shapes = [one.before or one.after or {} for one in transaction.changes[:NAMES_SHOWN]]
    return [name for shape in shapes if (name := shape.get("properties", {}).get("name"))]


def draft_json(draft: MapDraft, session: SessionInfo) -> dict[str, Any]:
    """Return a draft with its features."""
    return {**state_json(draft, session), "features": collection(draft.features)}


def changes_json(changes: Sequence[FeatureChange]) -> list[dict[str, Any]]:
    """Return changes as the editor takes them."""
    return [{"id": one.id, "before": one.before, "after": one.after} for one in changes]


def step_json(result: tuple[MapDraft, Sequence[FeatureChange]], session: SessionInfo) -> dict[str, Any]:
    """Return a draft after a step, with what the step changed."""
    draft, changes = result
    return {"draft": state_json(draft, session), "changes": changes_json(changes)}


async def tried(work: Callable[[], Any], shown: Callable[[Any], Any]) -> Any:
    """Await the book; its refusals become errors of the request."""
    try:
        return shown(await work())
    except MapLocked as error:
        text = f"{error.by} edits this map until {error.until:%H:%M} UTC. Ask, or wait."
        return _with(423, "locked", text, by=error.by, until_utc=utc(error.until))
    except ChangedMeanwhile as error:
        text = "The draft is not what was shown here any more. It is loaded again: look at it, then do it once more."
        return _with(409, "changed", text, ids=list(error.ids))
    except MapOutdated as error:
        text = (
            f"Version {error.number} was published meanwhile. See under Compare what it changed,"
            " then discard this draft and do again on the new map what is still needed."
        )
        return _with(409, "outdated", text, version=error.number)
    except MapBlocked as error:
        count = len(error.findings)
        text = f"Fix {count} blocking check{'s' if count > 1 else ''} first: {error.findings[0].text}"
        return _with(409, "blocked", text, findings=[one.as_json() for one in error.findings])
    except MapShrinks as error:
        raise ApiError(409, "shrinks", f"{error.text} Publish anyway?") from error
    except (BadFeature, BadWalk, OperationRefused, BadMapFile) as error:
        raise ApiError(422, error.code, error.text) from error


def _with(status: int, code: str, text: str, **more: Any) -> JSONResponse:
    """Return an error in the one shape, with what a program needs to go on."""
    plain = answer(status, code, text)
    return JSONResponse({"code": code, "text": text, "field": None, **more}, plain.status_code)


def utc(at: datetime | None) -> str | None:
    """Return a time as ISO 8601 with milliseconds."""
    return None if at is None else at.isoformat(timespec="milliseconds")
