"""Writes the contract for machines: JSON Schemas and an AsyncAPI 3 document, from the models.

``python -m backend_clients.field.schema docs/protocols/field_sensors`` writes them; a test compares what is
committed with what this makes.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec

from backend_clients.edge.schema import DRAFT, REF, Delivery
from backend_clients.edge.topics import ID_PATTERN
from backend_clients.field.codec import MAX_BYTES, MAX_FRAME_BYTES, TYPES
from backend_clients.field.topics import PREFIX, Down, Up

VERSION = "1.0.0"
DELIVERY: dict[Up | Down, Delivery] = {
    Up.ABOUT: Delivery(1, True, "at connect and when it changes"),
    Up.DATA: Delivery(1, False, "each period_s of about, and at once after connecting"),
    Up.FRAME: Delivery(0, False, "a field camera once an hour, a triggered one at most each 5 s; 100 a day"),
    Up.ACK: Delivery(1, False, "answer to each notice and trigger"),
    Down.NOTICE: Delivery(1, True, "when treatment near the station begins and ends, renewed while it lasts"),
    Down.TRIGGER: Delivery(1, False, "once, repeats with the same id are harmless"),
}
_FRAME = {"type": "string", "contentMediaType": "image/jpeg", "description": "JPEG bytes as they are"}


def json_schemas() -> dict[str, dict[str, Any]]:
    """Return one JSON Schema for each kind of JSON message, keyed by the last word of its topic."""
    schemas = {}
    for kind, model in TYPES.items():
        (schema,), parts = msgspec.json.schema_components([model], ref_template=REF)
        schemas[kind.value] = {"$schema": DRAFT, "title": f"{PREFIX}/+/{kind.value}", **schema, "$defs": parts}
    return schemas


def asyncapi() -> dict[str, Any]:
    """Return the AsyncAPI 3 document, seen from the station."""
    _, parts = msgspec.json.schema_components(list(TYPES.values()), ref_template="#/components/schemas/{name}")
    return {
        "asyncapi": "3.0.0",
        "info": {
            "title": "Headland field sensor contract",
            "version": VERSION,
            "description": "What a station in a field and the console say to each other over MQTT 3.1.1. "
            "Rules: docs/protocols/field_sensors.md.",
            "license": {"name": "Apache-2.0"},
        },
        "defaultContentType": "application/json",
        "channels": {kind.value: _channel(kind) for kind in DELIVERY},
        "operations": {f"{_action(kind)}-{kind.value}": _operation(kind) for kind in DELIVERY},
        "components": {"messages": {_name(kind): _message(kind) for kind in DELIVERY}, "schemas": parts},
    }


def files() -> dict[str, str]:
    """Return every generated file: name and text."""
    made = {f"{kind}.schema.json": _text(schema) for kind, schema in json_schemas().items()}
    made["asyncapi.json"] = _text(asyncapi())
    return made


def main(arguments: Sequence[str] | None = None) -> None:
    """Write all files into the folder named."""
    parser = argparse.ArgumentParser(description="Write the field sensor contract's JSON Schemas and AsyncAPI.")
    parser.add_argument("folder", type=Path)
    folder: Path = parser.parse_args(arguments).folder
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files().items():
        (folder / name).write_text(text, encoding="utf-8")


def _name(kind: Up | Down) -> str:
    return TYPES[kind].__name__ if kind in TYPES else "Frame"


def _action(kind: Up | Down) -> str:
    return "send" if isinstance(kind, Up) else "receive"


def _channel(kind: Up | Down) -> dict[str, Any]:
    name = _name(kind)
    return {
        "address": f"{PREFIX}/{{station}}/{kind.value}",
        "parameters": {"station": {"description": f"station id, {ID_PATTERN}"}},
        "messages": {name: {"$ref": f"#/components/messages/{name}"}},
    }


def _operation(kind: Up | Down) -> dict[str, Any]:
    delivery = DELIVERY[kind]
    return {
        "action": _action(kind),
        "channel": {"$ref": f"#/channels/{kind.value}"},
        "messages": [{"$ref": f"#/channels/{kind.value}/messages/{_name(kind)}"}],
        "summary": delivery.rate,
        "bindings": {"mqtt": {"qos": delivery.qos, "retain": delivery.is_retained, "bindingVersion": "0.2.0"}},
    }


def _message(kind: Up | Down) -> dict[str, Any]:
    if kind is Up.FRAME:
        text = f"A picture. At most {MAX_FRAME_BYTES} bytes."
        return {"name": "Frame", "contentType": "image/jpeg", "description": text, "payload": _FRAME}
    model = TYPES[kind]
    return {
        "name": model.__name__,
        "contentType": "application/json",
        "description": f"{(model.__doc__ or '').strip()} At most {MAX_BYTES} bytes.",
        "payload": {"$ref": f"#/components/schemas/{model.__name__}"},
    }


def _text(document: dict[str, Any]) -> str:
    return json.dumps(document, indent=2, ensure_ascii=False, sort_keys=False) + "\n"


if __name__ == "__main__":
    main()
