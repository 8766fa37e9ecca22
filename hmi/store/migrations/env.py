"""Read by Alembic: run the steps on the connection that ``upgrade`` hands over."""

from __future__ import annotations

from alembic import context

from hmi.store import (  # noqa: F401 - so that their tables are known
    alarm_tables,
    base_map_tables,
    fleet_tables,
    map_tables,
    mission_tables,
    picture_tables,
    queue_tables,
    sensor_tables,
    template_tables,
)
from hmi.store.tables import Base

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=Base.metadata,
    compare_type=True,
    render_as_batch=True,
    transactional_ddl=True,
)
context.run_migrations()
