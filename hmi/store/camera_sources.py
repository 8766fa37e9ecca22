"""Where cameras' pictures come from, as an admin said. Blocking; call through ``Database.run``."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import delete, select, update

from hmi.domain.camera import SourceKind
from hmi.store.database import Database
from hmi.store.picture_tables import CameraSourceRow


@dataclass(frozen=True, slots=True)
class StoredSource:
    """Where the pictures of one camera come from.

    Args:
        sealed: the password, encrypted; see ``hmi.security.sealed``.
        token_sha256: of the token an upload must show.
        period_s: how far apart pictures are meant to come that are uploaded or asked for one by one.
        keep_every_s: one of them is kept this often, 0 keeps none.
    """

    robot_id: str
    camera: str
    kind: SourceKind
    changed_by: str
    changed_at: datetime
    label: str = ""
    url: str = ""
    user_name: str = ""
    sealed: str = ""
    token_sha256: str = ""
    period_s: float = 5.0
    keep_every_s: float = 900.0
    width_px: int = 0
    height_px: int = 0


class CameraSources:
    """Sources of one farm.

    Args:
        farm_id: whose they are.
    """

    def __init__(self, database: Database, farm_id: str) -> None:
        self._database, self._farm_id = database, farm_id

    def all(self) -> list[StoredSource]:
        """Return all."""
        query = select(CameraSourceRow).filter_by(farm_id=self._farm_id)
        with self._database.read() as session:
            return [_stored(row) for row in session.scalars(query)]

    def put(self, one: StoredSource) -> None:
        """Keep one, in place of the one that is there."""
        parts = {name: getattr(one, name) for name in StoredSource.__slots__}
        with self._database.write() as session:
            session.merge(CameraSourceRow(farm_id=self._farm_id, **{**parts, "kind": one.kind.value}))

    def remove(self, robot_id: str, camera: str) -> bool:
        """Forget one; return whether there was one."""
        table = CameraSourceRow
        with self._database.write() as session:
            gone = session.execute(
                delete(table)
                .where(table.farm_id == self._farm_id, table.robot_id == robot_id, table.camera == camera)
                .returning(table.camera)
            )
            return gone.first() is not None

    def set_size(self, robot_id: str, camera: str, width_px: int, height_px: int) -> None:
        """Note how large the pictures of an upload are."""
        table = CameraSourceRow
        with self._database.write() as session:
            session.execute(
                update(table)
                .where(table.farm_id == self._farm_id, table.robot_id == robot_id, table.camera == camera)
                .values(width_px=width_px, height_px=height_px)
            )


def _stored(row: CameraSourceRow) -> StoredSource:
    parts = {name: getattr(row, name) for name in StoredSource.__slots__}
    return StoredSource(**{**parts, "kind": SourceKind(row.kind)})
