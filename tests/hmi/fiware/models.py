"""The published schemas, with what they refer to from copies beside this file: no test asks the Internet."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator, FormatChecker
from referencing import Registry, Resource
from referencing.jsonschema import DRAFT202012

_HOME = "https://smart-data-models.github.io"
_RAW = "https://raw.githubusercontent.com/smart-data-models/dataModel.AutonomousMobileRobot/master"
_ROBOT = "AutonomousMobileRobot-schema.json"
SCHEMAS: dict[str, dict[str, Any]] = {
    path.stem: json.loads(path.read_text(encoding="utf-8"))
    for path in (Path(__file__).parent / "schemas").glob("*.json")
}
_ALERT = {"definitions": {"Common-Alert": SCHEMAS["weather-schema"]["definitions"]["Weather-Alert"]}}
_SERIES = "TimeSeriesAggregation"
_ENVIRONMENT = {"definitions": {_SERIES: SCHEMAS["common-schema"]["definitions"][_SERIES]}}
_ALSO = {
    f"{_RAW}/{_ROBOT}": SCHEMAS["AutonomousMobileRobot-schema"],
    f"{_HOME}/dataModel.AutonomousMobileRobot/{_ROBOT}": SCHEMAS["AutonomousMobileRobot-schema"],
    f"{_HOME}/dataModel.Alert/alert-schema.json": _ALERT,
    f"{_HOME}/dataModel.Environment/Environment-schema.json": _ENVIRONMENT,
}


def _resource(content: dict[str, Any]) -> Resource[Any]:
    return DRAFT202012.create_resource(content)  # one of them names no dialect


REGISTRY: Registry[Any] = Registry().with_resources(
    [(schema["$id"], _resource(schema)) for schema in SCHEMAS.values()]
    + [(address, _resource(schema)) for address, schema in _ALSO.items()]
)


def check(entity: dict[str, Any]) -> None:
    """Return if an entity's key-values fit the schema of its type; raises ``ValidationError``."""
    schema = SCHEMAS[entity["type"]]
    Draft202012Validator(schema, registry=REGISTRY, format_checker=FormatChecker()).validate(entity)
