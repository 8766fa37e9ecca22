"""Writes the contract for machines: JSON Schemas and an AsyncAPI 3 document, from the models.

``python -m backend_clients.edge.schema docs/protocols/edge`` writes them; a test compares what is
committed with what this makes.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import DOWN_TYPES, MAX_BYTES, MAX_MISSION_BYTES, UP_TYPES
from backend_clients.edge.topics import ID_PATTERN, PREFIX, Down, Up

VERSION = "1.0.0"
DRAFT = "https://json-schema.org/draft/2020-12/schema"
REF = "#/$defs/{name}"


@dataclass(frozen=True, slots=True)
class Delivery:
    """How one kind of message travels."""

    qos: int
    is_retained: bool
    rate: str


UP_DELIVERY: dict[Up, Delivery] = {
    Up.PRESENCE: Delivery(1, True, "at connect and shutdown; last will"),
    Up.FACTSHEET: Delivery(1, True, "at connect and when it changes"),
    Up.HEARTBEAT: Delivery(0, False, "5 Hz"),
    Up.TELEMETRY: Delivery(0, False, "10 Hz"),
    Up.STATE: Delivery(1, False, "2 Hz and at every change"),
    Up.SAFETY: Delivery(1, False, "5 Hz (QoS 0), 10 Hz while stopping, and at every change (QoS 1)"),
    Up.EVENT: Delivery(1, False, "as it happens; kept while offline"),
    Up.NODE: Delivery(1, True, "each 5 s, one message a node"),
    Up.BODY: Delivery(0, False, "10 Hz while it moves, 2 Hz at rest"),
    Up.WORKSITE: Delivery(1, True, "at each change"),
    Up.SCAN: Delivery(0, False, "at most 1 Hz"),
    Up.DETECTIONS: Delivery(0, False, "at most 2 Hz a camera, while its pictures are fetched"),
    Up.ACK: Delivery(1, False, "answer to each order"),
}
DOWN_DELIVERY: dict[Down, Delivery] = {
    Down.COMMAND: Delivery(1, False, "once, repeats with the same id are harmless"),
    Down.MISSION: Delivery(1, False, "once; large ones by HTTP"),
    Down.STOP: Delivery(1, False, "each 200 ms until standstill is confirmed, each 1 s after 10 s"),
    Down.STOP_RESET: Delivery(1, False, "once, repeats with the same id are harmless"),
    Down.DRIVE: Delivery(0, False, "10 Hz while held"),
    Down.JOG: Delivery(0, False, "10 Hz while held"),
    Down.OPERATOR: Delivery(0, False, "1 Hz while a page of the lease holder is open"),
    Down.PING: Delivery(0, False, "1 Hz"),
}


def json_schemas() -> dict[str, dict[str, Any]]:
    """Return one JSON Schema for each kind of message, keyed by the last word of its topic."""
    kinds: list[tuple[Up | Down, type[up.Header] | type[down.Order]]] = [*UP_TYPES.items(), *DOWN_TYPES.items()]
    schemas = {}
    for kind, model in kinds:
        (schema,), parts = msgspec.json.schema_components([model], ref_template=REF)
        schemas[kind.value] = {"$schema": DRAFT, "title": f"{PREFIX}/+/{kind.value}", **schema, "$defs": parts}
    return schemas


def asyncapi() -> dict[str, Any]:
    """Return the AsyncAPI 3 document, seen from the robot."""
    models: list[type[up.Header] | type[down.Order]] = [*UP_TYPES.values(), *DOWN_TYPES.values()]
    _, parts = msgspec.json.schema_components(models, ref_template="#/components/schemas/{name}")
    channels: dict[str, Any] = {}
    operations: dict[str, Any] = {}
    messages: dict[str, Any] = {}
    for up_kind, up_model in UP_TYPES.items():
        _add(channels, operations, messages, up_kind, up_model, UP_DELIVERY[up_kind], "send")
    for down_kind, down_model in DOWN_TYPES.items():
        _add(channels, operations, messages, down_kind, down_model, DOWN_DELIVERY[down_kind], "receive")
    return {
        "asyncapi": "3.0.0",
        "info": {
            "title": "Headland edge contract",
            "version": VERSION,
            "description": "What a robot and the console say to each other over MQTT 3.1.1. "
            "Rules, HTTP and refusal codes: docs/protocols/edge.md.",
            "license": {"name": "Apache-2.0"},
        },
        "defaultContentType": "application/json",
        "channels": channels,
        "operations": operations,
        "components": {"messages": messages, "schemas": parts},
    }


def files() -> dict[str, str]:
    """Return every generated file: name and text."""
    made = {f"{kind}.schema.json": _text(schema) for kind, schema in json_schemas().items()}
    made["asyncapi.json"] = _text(asyncapi())
    return made


def main(arguments: Sequence[str] | None = None) -> None:
    """Write all files into the folder named."""
    parser = argparse.ArgumentParser(description="Write the edge contract's JSON Schemas and AsyncAPI document.")
    parser.add_argument("folder", type=Path)
    folder: Path = parser.parse_args(arguments).folder
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files().items():
        (folder / name).write_text(text, encoding="utf-8")


def _add(
    channels: dict[str, Any],
    operations: dict[str, Any],
    messages: dict[str, Any],
    kind: Up | Down,
    model: type[up.Header] | type[down.Order],
    delivery: Delivery,
    action: str,
) -> None:
    name = model.__name__
    limit = MAX_MISSION_BYTES if kind is Down.MISSION else MAX_BYTES
    channels[kind.value] = {
        "address": f"{PREFIX}/{{robot}}/{kind.value}",
        "parameters": {"robot": {"description": f"robot id, {ID_PATTERN}"}},
        "messages": {name: {"$ref": f"#/components/messages/{name}"}},
    }
    operations[f"{action}-{kind.value}"] = {
        "action": action,
        "channel": {"$ref": f"#/channels/{kind.value}"},
        "messages": [{"$ref": f"#/channels/{kind.value}/messages/{name}"}],
        "summary": delivery.rate,
        "bindings": {"mqtt": {"qos": delivery.qos, "retain": delivery.is_retained, "bindingVersion": "0.2.0"}},
    }
    messages[name] = {
        "name": name,
        "contentType": "application/json",
        "description": f"{(model.__doc__ or '').strip()} At most {limit} bytes.",
        "payload": {"$ref": f"#/components/schemas/{name}"},
    }


def _text(document: dict[str, Any]) -> str:
    return json.dumps(document, indent=2, ensure_ascii=False, sort_keys=False) + "\n"


if __name__ == "__main__":
    main()
