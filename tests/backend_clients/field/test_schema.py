"""The committed schemas are those of the models, and honest messages fit them."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import msgspec
import pytest

from backend_clients.field import messages as m
from backend_clients.field.codec import TYPES
from backend_clients.field.schema import asyncapi, files, json_schemas, main
from backend_clients.field.topics import PREFIX, Down, Up
from tests.backend_clients.field.honest import honest

DOCS = Path(__file__).parents[3] / "docs" / "protocols"


def test_generating_gives_the_committed_files(tmp_path: Path) -> None:
    main([str(tmp_path)])
    made = {path.name: path.read_text("utf-8") for path in tmp_path.iterdir()}
    committed = {path.name: path.read_text("utf-8") for path in (DOCS / "field_sensors").iterdir()}
    assert made == committed, "run: python -m backend_clients.field.schema docs/protocols/field_sensors"
    assert set(made) == set(files())


@pytest.mark.parametrize("kind", sorted(TYPES))
def test_each_schema_is_a_valid_schema_and_takes_an_honest_message(kind: Up | Down) -> None:
    schema = json_schemas()[kind.value]
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(json.loads(msgspec.json.encode(honest()[kind])), schema)


def test_the_schema_refuses_what_a_station_refuses() -> None:
    schema = json_schemas()["trigger"]
    body = json.loads(msgspec.json.encode(honest()[Down.TRIGGER])) | {"extra": 1}
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(body, schema)
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(body, m.Trigger)


def test_every_reference_of_the_asyncapi_document_leads_somewhere() -> None:
    document = asyncapi()

    def follow(node: object) -> None:
        if isinstance(node, dict):
            reference = node.get("$ref")
            if isinstance(reference, str):
                place: object = document
                for part in reference.removeprefix("#/").split("/"):
                    assert isinstance(place, dict), reference
                    place = place[part]
            for value in node.values():
                follow(value)
        elif isinstance(node, list):
            for value in node:
                follow(value)

    follow(document)
    kinds: set[str] = {*Up, *Down}
    assert {channel["address"] for channel in document["channels"].values()} == {
        f"{PREFIX}/{{station}}/{kind}" for kind in kinds
    }


def test_every_kind_is_in_the_document_with_its_delivery() -> None:
    text = (DOCS / "field_sensors.md").read_text("utf-8")
    missing = [kind for kind in (*Up, *Down) if f"| `{kind}` |" not in text]
    assert missing == []
