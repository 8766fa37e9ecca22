"""How the broker says no: a status, an error word and a sentence, as Orion words them."""

from __future__ import annotations

from collections.abc import Mapping


class Refusal(Exception):
    """Ends the handling of a request with an error answer.

    Args:
        status: HTTP status.
        error: Orion's error word, e.g. ``BadRequest``.
        description: one sentence.
        headers: more headers of the answer.
    """

    def __init__(self, status: int, error: str, description: str, headers: Mapping[str, str] | None = None) -> None:
        super().__init__(f"{status} {error}: {description}")
        self.status, self.error, self.description = status, error, description
        self.headers = dict(headers or {})


def bad_request(description: str) -> Refusal:
    """Return a 400."""
    return Refusal(400, "BadRequest", description)


def parse_error() -> Refusal:
    """Return what Orion says of any body it cannot read."""
    return Refusal(400, "ParseError", "Errors found in incoming JSON buffer")


def no_entity() -> Refusal:
    """Return the 404 of an entity."""
    return Refusal(404, "NotFound", "The requested entity has not been found. Check type and id")


def no_attribute() -> Refusal:
    """Return the 404 of an attribute."""
    return Refusal(404, "NotFound", "The entity does not have such an attribute")


def ambiguous() -> Refusal:
    """Return the 409 of an id that stands for several entities."""
    return Refusal(409, "TooManyResults", "More than one matching entity. Please refine your query")


def unprocessable(description: str, *, is_partial: bool = False) -> Refusal:
    """Return a 422; ``is_partial`` says that some of the request took effect."""
    return Refusal(422, "PartialUpdate" if is_partial else "Unprocessable", description)
