"""``/v2/entities/{id}/attrs/{name}`` and its ``/value``."""

from __future__ import annotations

import json

from backend_clients.simulator.context_broker.attribute import (
    Attribute,
    Given,
    normalized,
    read_attribute,
    read_value,
)
from backend_clients.simulator.context_broker.exchange import (
    JSON_TYPE,
    TEXT_TYPE,
    Answer,
    Exchange,
    accepted,
    as_json,
    nothing,
    require_json_accepted,
)
from backend_clients.simulator.context_broker.json_text import Json, read, write
from backend_clients.simulator.context_broker.refusal import Refusal, bad_request, no_attribute
from backend_clients.simulator.context_broker.update import append, delete


def get(exchange: Exchange) -> Answer:
    """Return one attribute."""
    require_json_accepted(exchange.headers)
    return as_json(normalized(_read(exchange), exchange.parameters.words("metadata")))


def put(exchange: Exchange) -> Answer:
    """Write one attribute that exists."""
    return _write(exchange, read_attribute(exchange.object()))


def remove(exchange: Exchange) -> Answer:
    """Take one attribute away."""
    entity, given = exchange.entity_to_write(), {exchange.words[1]: Given(None, None)}
    exchange.store.apply(exchange.scope.tenant, entity, delete, given, exchange.how)
    return nothing()


def get_value(exchange: Exchange) -> Answer:
    """Return the value of one attribute: an object or list as JSON, anything else as text."""
    value = _read(exchange).value
    kinds = accepted(exchange.headers)
    takes_text = bool(kinds & {"*/*", "text/*", TEXT_TYPE})
    if isinstance(value, dict | list):
        if kinds & {"*/*", "application/*", JSON_TYPE}:
            return as_json(value)
        if takes_text:
            return Answer(200, write(value), TEXT_TYPE)
        raise Refusal(406, "NotAcceptable", f"accepted MIME types: {JSON_TYPE}, {TEXT_TYPE}")
    if not takes_text:
        raise Refusal(406, "NotAcceptable", f"accepted MIME types: {TEXT_TYPE}")
    text = f'"{value}"'.encode() if isinstance(value, str) else write(value)
    return Answer(200, text, TEXT_TYPE)


def put_value(exchange: Exchange) -> Answer:
    """Write the value of one attribute; its type stays."""
    value = _text_value(exchange.body) if exchange.content_type() == TEXT_TYPE else _json_value(exchange)
    entity = exchange.entity_to_write()
    attribute = entity.attributes.get(exchange.words[1])
    if attribute is None:
        raise no_attribute()
    return _write(exchange, read_value(value, attribute.type))


def _read(exchange: Exchange) -> Attribute:
    attribute = exchange.entity_to_read().attributes.get(exchange.words[1])
    if attribute is None:
        raise no_attribute()
    return attribute


def _write(exchange: Exchange, given: Given) -> Answer:
    entity, name = exchange.entity_to_write(), exchange.words[1]
    if name not in entity.attributes:
        raise no_attribute()
    exchange.store.apply(
        exchange.scope.tenant, entity, append, {name: given}, exchange.how, forced=exchange.is_forced()
    )
    return nothing()


def _json_value(exchange: Exchange) -> Json:
    if exchange.content_type() != JSON_TYPE:
        raise Refusal(415, "UnsupportedMediaType", f"not supported content type: {exchange.content_type()}")
    if not exchange.body.lstrip().startswith((b"{", b"[")):
        raise bad_request("Neither JSON Object nor JSON Array for attribute::value")
    return read(exchange.body)


def _text_value(body: bytes) -> Json:
    try:
        text = body.decode("utf-8").strip()
        if len(text) > 1 and text[0] == text[-1] == '"':
            return text[1:-1]
        value = json.loads(text, parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise bad_request("attribute value type not recognized") from error
    if isinstance(value, dict | list):
        raise bad_request("attribute value type not recognized")
    return value


def _no_constant(text: str) -> None:
    raise ValueError(text)
