"""Which tenant is ours: an entity that names this console, and a note on disk that it was put there.

Another tenant looks empty and never wrong; without the marker the farm's data would go there without a word.
"""

from __future__ import annotations

import json
import secrets
from pathlib import Path

import msgspec

from backend_clients.ngsi import entity as make
from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.connection import Broker
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.identifier import EntityRef
from hmi.service_link import LinkState


class TenantMoved(Exception):
    """What answers now is not the tenant that knew this console: nothing of it may be believed or written."""


class _Note(msgspec.Struct):
    console: str
    placed: list[str] = msgspec.field(default_factory=list)


class Marker:
    """The entity of this console, and where it was put.

    Args:
        path: of the note.
        ref: of the entity.
        farm_name: shown to whoever looks into the broker.
        is_strict: a tenant that forgot the marker is not written to again without a person; a demo's broker
            forgets everything when it ends.
    """

    def __init__(self, path: Path, ref: EntityRef, farm_name: str, *, is_strict: bool = True) -> None:
        self._path, self._ref, self._farm_name, self._is_strict = path, ref, farm_name, is_strict
        self._note = _read(path)

    async def look(self, client: NgsiClient) -> tuple[LinkState, str, bool]:
        """Return ``OK``, or why nothing may be written here, and whether the tenant knew nothing of us before.

        Raises:
            NgsiError: it could not be asked.
        """
        found = await client.find(self._ref)
        if found is None:
            if self._is_strict and where_of(client.connection.broker) in self._note.placed:
                return LinkState.OTHER_TENANT, "The tenant does not know this console any more.", False
            await self.place(client)
            return LinkState.OK, "", True
        if found.value("console") != self._note.console:
            return LinkState.OTHER_CONSOLE, "Another console keeps this farm in this tenant.", False
        return LinkState.OK, "", False

    async def is_ours(self, client: NgsiClient) -> bool:
        """Say whether the tenant that answers now knows this console, without taking it; raises ``NgsiError``."""
        found = await client.find(self._ref)
        return found is not None and found.value("console") == self._note.console

    async def place(self, client: NgsiClient) -> None:
        """Take the tenant for this console; raises ``NgsiError``."""
        attributes = {"console": make.text(self._note.console), "name": make.text(self._farm_name)}
        await client.upsert(Entity(ref=self._ref, attributes=attributes))
        where = where_of(client.connection.broker)
        if where not in self._note.placed:
            self._note.placed.append(where)
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._path.write_bytes(msgspec.json.encode(self._note))


def where_of(broker: Broker) -> str:
    """Return what names one tenant of one broker."""
    return json.dumps([broker.url, broker.tenant.service, broker.tenant.path])


def _read(path: Path) -> _Note:
    try:
        return msgspec.json.decode(path.read_bytes(), type=_Note)
    except (OSError, msgspec.DecodeError):
        return _Note(secrets.token_hex(8))
