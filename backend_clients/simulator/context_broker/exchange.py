"""One request and its answer, as the handlers see them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from starlette.datastructures import Headers

from backend_clients.simulator.context_broker.entity import Entity
from backend_clients.simulator.context_broker.json_text import Json, read_object, write
from backend_clients.simulator.context_broker.parameters import Parameters
from backend_clients.simulator.context_broker.refusal import Refusal, bad_request
from backend_clients.simulator.context_broker.store import Store
from backend_clients.simulator.context_broker.tenancy import Scope
from backend_clients.simulator.context_broker.update import How

JSON_TYPE = "application/json"
TEXT_TYPE = "text/plain"


@dataclass(frozen=True, slots=True)
class Answer:
    """Status, headers and body of an answer; ``body`` is bytes already, its type is ``media_type``."""

    status: int = 200
    body: bytes = b""
    media_type: str = ""
    headers: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Exchange:
    """One request, checked so far that a handler can work with it.

    Args:
        words: the variable parts of the path, decoded.
        now: the time at which it takes effect.
    """

    store: Store
    method: str
    scope: Scope
    words: tuple[str, ...]
    parameters: Parameters
    headers: Headers
    body: bytes
    how: How

    def object(self) -> dict[str, Json]:
        """Return the JSON object of the body."""
        if self.content_type() != JSON_TYPE:
            raise Refusal(415, "UnsupportedMediaType", f"not supported content type: {self.content_type()}")
        return read_object(self.body)

    def content_type(self) -> str:
        """Return the type of the body without its parameters."""
        return self.headers.get("content-type", "").partition(";")[0].strip().lower()

    def is_plain(self) -> bool:
        """Say whether the body is in the short form."""
        return "keyValues" in self.parameters.options

    def is_forced(self) -> bool:
        """Say whether unchanged values are to be notified too."""
        return "forcedUpdate" in self.parameters.options

    def entity_to_read(self) -> Entity:
        """Return the entity that the path names."""
        return self.store.one(self.scope, self.words[0], self.parameters.words("type"))

    def entity_to_write(self) -> Entity:
        """Return the entity that the path names, where writes go."""
        return self.store.one(self.scope.for_writing(), self.words[0], self.parameters.words("type"))


def as_json(value: Json, *, headers: Mapping[str, str] | None = None) -> Answer:
    """Return a 200 with JSON."""
    return Answer(200, write(value), JSON_TYPE, headers or {})


def nothing(status: int = 204, **headers: str) -> Answer:
    """Return an answer without a body."""
    return Answer(status, headers=headers)


def require_json_accepted(headers: Headers) -> None:
    """Refuse a reader who wants anything but JSON."""
    kinds = accepted(headers)
    if not kinds & {"*/*", "application/*", JSON_TYPE}:
        if kinds & {"text/*", TEXT_TYPE}:
            raise Refusal(406, "NotAcceptable", f"acceptable MIME types: {JSON_TYPE}", {"Content-Type": TEXT_TYPE})
        raise Refusal(406, "NotAcceptable", "no acceptable mime-type in accept header")


def accepted(headers: Headers) -> set[str]:
    """Return the media types a reader takes; anything if it does not say."""
    return {item.partition(";")[0].strip().lower() for item in headers.get("accept", "*/*").split(",")}


def member(body: Mapping[str, Json], name: str, kind: type, default: Any = None) -> Any:
    """Return a member of a body, or refuse another kind of it."""
    found = body.get(name, default)
    if not isinstance(found, kind):
        raise bad_request(f"{name} is missing or of the wrong JSON type")
    return found
