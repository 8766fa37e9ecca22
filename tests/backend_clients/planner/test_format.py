"""The committed OpenAPI document is that of the models, and what we say fits it."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import pytest
from pydantic import ValidationError

from backend_clients.planner.messages import PlanRequest, Wish, wish_sha256
from backend_clients.planner.schema import main, openapi
from backend_clients.service.connection import Service
from backend_clients.service.errors import BadRequest
from tests.backend_clients.planner.wishes import WISH

DOCS = Path(__file__).parents[3] / "docs/protocols/planner"


def test_generating_gives_the_committed_file(tmp_path: Path) -> None:
    main([str(tmp_path)])
    made, kept = ((folder / "openapi.json").read_text("utf-8") for folder in (tmp_path, DOCS))
    assert made == kept, "run: python -m backend_clients.planner.schema docs/protocols/planner"


def test_a_wish_fits_the_schema_and_holds_no_name() -> None:
    document = openapi()
    request = json.loads(PlanRequest(wish_sha256=wish_sha256(WISH), wish=WISH).model_dump_json())
    schema = {"$ref": "#/components/schemas/PlanRequest", "components": document["components"]}
    jsonschema.validate(request, schema)
    assert not any("name" in key or "robot" in key or "farm" in key for key in request["wish"])


@pytest.mark.parametrize(
    "change",
    [{"width_m": 0}, {"overlap": 0.9}, {"angle_rad": float("nan")}, {"pattern": "zigzag"}, {"field": []}, {"x": 1}],
)
def test_a_wish_out_of_bounds_is_none(change: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        Wish.model_validate({**WISH.model_dump(), **change})


def test_wishes_that_differ_have_other_hashes() -> None:
    assert wish_sha256(WISH) == wish_sha256(Wish.model_validate(WISH.model_dump()))
    assert wish_sha256(WISH) != wish_sha256(WISH.model_copy(update={"width_m": 2.0}))


@pytest.mark.parametrize("url", ["ftp://x", "http://", "http://a:b@x", "http://x/?q=1", "nonsense"])
def test_an_address_that_cannot_be_is_refused_at_once(url: str) -> None:
    with pytest.raises(BadRequest):
        Service(url)
