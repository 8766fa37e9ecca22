"""Times in entities: ISO 8601, aware, UTC."""

from __future__ import annotations

from datetime import UTC, datetime

from backend_clients.ngsi.errors import BadInput, Unreadable


def moment_text(moment: datetime) -> str:
    """Return the text of an aware time, milliseconds, as a broker gives it back."""
    if moment.tzinfo is None:
        raise BadInput("a time needs a zone")
    return moment.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def read_moment(text: object) -> datetime:
    """Return the aware time of a text; raises ``Unreadable``."""
    if not isinstance(text, str) or len(text) > 40:
        raise Unreadable(f"not a time: {str(text)[:40]!r}")
    try:
        found = datetime.fromisoformat(text)
        return (found if found.tzinfo else found.replace(tzinfo=UTC)).astimezone(UTC)
    except (ValueError, OverflowError) as error:
        raise Unreadable(f"not a time: {text!r}") from error
