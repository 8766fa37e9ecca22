"""Writes the format for machines: an OpenAPI 3.1 document with JSON Schemas, from the models.

``python -m backend_clients.planner.schema docs/protocols/planner`` writes it; a test compares what is committed
with what this makes.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from backend_clients.planner.messages import MAX_REQUEST, PlanReport, PlanRequest, Problem, ServiceInfo
from backend_clients.service.openapi import answer, document, parameter, written


def openapi() -> dict[str, Any]:
    """Return the OpenAPI document."""
    plan_id = parameter("id", "path", "the plan's id", r"^[A-Za-z0-9_-]{1,64}$")
    key = parameter("Idempotency-Key", "header", "id of the plan; sent twice it is one plan", plan_id["schema"])
    body = {"required": True, "content": {"application/json": {"schema": {"$ref": "#/components/schemas/PlanRequest"}}}}
    refused = {status: answer(text, "Problem") for status, text in _REFUSALS.items()}

    def some(*statuses: str) -> dict[str, Any]:
        return {status: refused[status] for status in statuses}

    paths = {
        "/": {"get": {"summary": "That it is a planner, and how busy",
                      "responses": {"200": answer("well", "ServiceInfo"), **some("401")}}},
        "/plans": {"post": {"summary": "Hand a wish in", "parameters": [key], "requestBody": body,
                            "responses": {"202": answer("taken; Location names the plan", "PlanReport"),
                                          **some("400", "401", "409", "413", "422", "429")}}},
        "/plans/{id}": {
            "parameters": [plan_id],
            "get": {"summary": "How far it is, and the path when it is done",
                    "responses": {"200": answer("the plan", "PlanReport"), **some("401", "404")}},
            "delete": {"summary": "Give it up; its result is forgotten",
                       "responses": {"204": {"description": "given up"}, **some("401", "404")}},
        },
    }  # fmt: skip
    about = f"Plans coverage paths for field robots. Requests have at most {MAX_REQUEST} bytes. See planner.md."
    models: list[type[BaseModel]] = [PlanRequest, PlanReport, ServiceInfo, Problem]
    return document("Headland planner", about, paths, models)


_REFUSALS = {
    "400": "not JSON",
    "401": "the token is missing or wrong",
    "404": "there is no such plan, or not any more",
    "409": "the key belongs to another wish",
    "413": "the request is too long",
    "422": "the wish is not what the format promises",
    "429": "too many plans wait; Retry-After says when to ask again",
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the document into the folder named."""
    parser = argparse.ArgumentParser(description="Write the planner format's OpenAPI document.")
    parser.add_argument("folder", type=Path)
    written(openapi(), parser.parse_args(arguments).folder)


if __name__ == "__main__":
    main()
