"""Which map entities a broker was told, kept over a restart: one that is missing there was deleted by somebody else."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable
from pathlib import Path

import msgspec

from backend_clients.ngsi.identifier import EntityRef

log = logging.getLogger(__name__)


class _Note(msgspec.Struct):
    where: str = ""
    told: list[EntityRef] = msgspec.field(default_factory=list)


class ToldIds:
    """The entities that were told, in one file. Calls block for one small file.

    Args:
        path: of the file.
        where: broker and tenant; what another one was told does not count.
    """

    def __init__(self, path: Path, where: str) -> None:
        self._path, self._where = path, where
        note = _read(path)
        self._told = set(note.told) if note.where == where else set[EntityRef]()

    def all(self) -> frozenset[EntityRef]:
        """Return the entities that should be there."""
        return frozenset(self._told)

    def add(self, refs: Iterable[EntityRef]) -> None:
        """Note that entities were told."""
        self._keep(self._told | set(refs))

    def drop(self, refs: Iterable[EntityRef]) -> None:
        """Forget entities that are not expected there any more."""
        self._keep(self._told - set(refs))

    def forget(self) -> None:
        """Forget all: the broker knows nothing of us."""
        self._keep(set())

    def _keep(self, told: set[EntityRef]) -> None:
        if told == self._told:
            return
        self._told = told
        beside = self._path.with_suffix(".new")
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            beside.write_bytes(msgspec.json.encode(_Note(self._where, sorted(told))))
            os.replace(beside, self._path)
        except OSError as error:  # until the next change only this run knows
            log.warning("%s: %s", self._path.name, error)


def _read(path: Path) -> _Note:
    try:
        return msgspec.json.decode(path.read_bytes(), type=_Note)
    except (OSError, msgspec.DecodeError):
        return _Note()
