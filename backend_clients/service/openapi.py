"""Parts of OpenAPI documents that are made from pydantic models."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

REF = "#/components/schemas/{model}"
FILE = "openapi.json"


def document(title: str, about: str, paths: dict[str, Any], models: Sequence[type[BaseModel]]) -> dict[str, Any]:
    """Return an OpenAPI 3.1 document with the schemas of the models and all they are made of."""
    _, found = models_json_schema([(one, "validation") for one in models], ref_template=REF)
    return {
        "openapi": "3.1.0",
        "info": {"title": title, "version": "1", "description": about, "license": {"name": "Apache-2.0"}},
        "security": [{"token": []}],
        "paths": paths,
        "components": {
            "securitySchemes": {"token": {"type": "http", "scheme": "bearer"}},
            "schemas": found["$defs"],
        },
    }


def answer(text: str, model: str) -> dict[str, Any]:
    """Return a response with a body."""
    schema = {"$ref": REF.format(model=model)}
    return {"description": text, "content": {"application/json": {"schema": schema}}}


def parameter(name: str, place: str, text: str, pattern: str | dict[str, Any]) -> dict[str, Any]:
    """Return a parameter: text of a pattern, or of a schema."""
    schema = {"type": "string", "pattern": pattern} if isinstance(pattern, str) else pattern
    return {"name": name, "in": place, "required": place == "path", "description": text, "schema": schema}


def written(made: dict[str, Any], folder: Path) -> None:
    """Write a document into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / FILE).write_text(text_of(made), encoding="utf-8")


def text_of(made: dict[str, Any]) -> str:
    """Return a document as it is committed."""
    return json.dumps(made, indent=2, ensure_ascii=False) + "\n"
