"""The committed schemas are those of the models, and honest messages fit them."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import msgspec
import pytest

from backend_clients.edge import messages_down as down
from backend_clients.edge.schema import asyncapi, files, json_schemas, main
from backend_clients.edge.topics import Down, Up
from backend_clients.simulator.verdict import REFUSALS
from tests.backend_clients.simulator.rig import Rig, small_mission

DOCS = Path(__file__).parents[3] / "docs" / "protocols"


def test_generating_gives_the_committed_files(tmp_path: Path) -> None:
    main([str(tmp_path)])
    made = {path.name: path.read_text("utf-8") for path in tmp_path.iterdir()}
    committed = {path.name: path.read_text("utf-8") for path in (DOCS / "edge").iterdir()}
    assert made == committed, "run: python -m backend_clients.edge.schema docs/protocols/edge"
    assert set(made) == set(files())


@pytest.mark.parametrize("kind", [*Up, *Down])
def test_each_schema_is_a_valid_schema(kind: Up | Down) -> None:
    jsonschema.Draft202012Validator.check_schema(json_schemas()[kind.value])


@pytest.mark.slow
def test_what_the_simulator_says_fits_the_schemas() -> None:
    rig = Rig()
    rig.start()
    rig.run(8)
    reporter = rig.boot.reporter
    said = {
        Up.PRESENCE: reporter.presence(),
        Up.FACTSHEET: reporter.factsheet(),
        Up.HEARTBEAT: reporter.heartbeat(),
        Up.TELEMETRY: reporter.telemetry(),
        Up.STATE: reporter.state(),
        Up.ACK: rig.stop(),
        Up.SAFETY: reporter.safety(),
        Up.NODE: reporter.nodes()[0],
        Up.EVENT: reporter.event(rig.events[0]),
        Down.MISSION: small_mission(),
        Down.COMMAND: rig.order("start"),
    }
    for kind, message in said.items():
        schema = json_schemas()[kind.value]
        jsonschema.validate(json.loads(msgspec.json.encode(message)), schema)


def test_the_schema_refuses_what_the_robot_refuses() -> None:
    schema = json_schemas()["ping"]
    body = {"robot": "weeder-01", "nonce": "1", "extra": 1}
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(body, schema)
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(body, down.Ping)


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
    assert {channel["address"].rpartition("/")[2] for channel in document["channels"].values()} == {*Up, *Down}


def test_every_refusal_is_in_the_document_with_its_sentence() -> None:
    text = (DOCS / "edge.md").read_text("utf-8")
    missing = [code for code, sentence in REFUSALS.items() if f"| `{code}` | {sentence} |" not in text]
    assert missing == []


def test_every_refusal_is_a_sentence_for_a_person() -> None:
    for code, sentence in REFUSALS.items():
        assert sentence[0].isupper(), code
        assert sentence.endswith("."), code
        assert code not in sentence
