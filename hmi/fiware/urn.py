"""Ids of entities and their common parts (ETSI GS CIM 009, annex A)."""

from __future__ import annotations

import re
from datetime import UTC, datetime
from typing import Any

KeyValues = dict[str, Any]
OWN = "headland"  # attribute with what the models have no place for
_CUT = 64


class Urns:
    """Names of the entities of one farm; ``farm_name`` is the part of them that names it.

    Args:
        farm_id: whose they are.
    """

    def __init__(self, farm_id: str) -> None:
        self.farm_name = re.sub(r"[^a-z0-9_-]+", "-", farm_id.lower()).strip("-")[:_CUT] or "farm"
        self.farm = self.of("AgriFarm", "")

    def of(self, model: str, name: str) -> str:
        """Return the id of an entity; ``name`` is an id of ours."""
        return ":".join(part for part in ("urn:ngsi-ld", model, self.farm_name, name) if part)

    def crop(self, name: str) -> str:
        """Return the id of a crop; crops are few and shared by parcels."""
        return self._shared("AgriCrop", name)

    def soil(self, name: str) -> str:
        """Return the id of a kind of soil, shared as crops are."""
        return self._shared("AgriSoil", name)

    def _shared(self, model: str, name: str) -> str:
        plain = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:_CUT]
        return self.of(model, plain or name.encode().hex()[:_CUT])

    def name_of(self, model: str, entity_id: str) -> str | None:
        """Return our id in an entity's id, ``None`` if it is not one of this farm's."""
        head = f"urn:ngsi-ld:{model}:{self.farm_name}:"
        return entity_id[len(head) :] or None if entity_id.startswith(head) else None


def moment(at: datetime) -> str:
    """Return an aware time as the schemas want it: UTC, milliseconds."""
    return at.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def point(lat_deg: float, lon_deg: float) -> KeyValues:
    """Return a place as GeoJSON, eight decimals."""
    return {"type": "Point", "coordinates": [round(lon_deg, 8), round(lat_deg, 8)]}


def depth_name(depth_m: float) -> str:
    """Return a depth below ground as it stands in an id."""
    return f"{round(depth_m * 100)}cm"


def told(entity: KeyValues) -> KeyValues:
    """Return the entity without what is not known: a missing value is left out, never a zero."""
    return {key: value for key, value in entity.items() if value is not None}
