"""The installation's database, as the command line opens it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from hmi.clock import SystemClock
from hmi.keeper.data_folder import require_writable
from hmi.keeper.errors import StartError
from hmi.settings import Settings
from hmi.store.database import Database
from hmi.store.errors import StoreError
from hmi.store.farms import Farms


@contextmanager
def opened() -> Iterator[tuple[Settings, Database]]:
    """Open and migrate the database of the settings in force; store errors become one sentence."""
    settings = Settings()  # type: ignore[call-arg]  # every field comes from file or variables
    require_writable(settings.data)
    database = Database(settings.database)
    try:
        database.migrate()
        Farms(database, SystemClock()).ensure(settings.farm_id, settings.farm_name)
        yield settings, database
    except StoreError as error:
        raise StartError(f"{error}") from error
    finally:
        database.close()
