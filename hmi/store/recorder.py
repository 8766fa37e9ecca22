"""The recorder: keeps events, changes of state and a sample a second of every registered robot.

``see`` and ``see_event`` cost microseconds and never wait; a thread writes in batches. What the database cannot take
waits in a bounded queue, then is dropped and counted.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from sqlalchemy import Connection, insert
from sqlalchemy.dialects import postgresql, sqlite

from hmi.clock import Clock
from hmi.domain.event import RobotEvent
from hmi.domain.robot import Robot
from hmi.store.batch_writer import BatchWriter, WriterHealth
from hmi.store.database import Database
from hmi.store.sampling import Sample, Sampler, event_columns, sample_columns
from hmi.store.tables import EventRow, SampleRow

CAPACITY = 30_000  # half a minute of 1,000 robots, some 20 MB
LINGER_S = 1.0  # one commit a second costs one flush of the disk, whatever the number of robots
_Item = Sample | dict[str, Any]


class Recorder:
    """Records one farm.

    Args:
        is_registered: answers from memory. Other robots leave no trace: anybody on the network can invent one.
    """

    def __init__(
        self,
        database: Database,
        farm_id: str,
        clock: Clock,
        is_registered: Callable[[str], bool],
        *,
        capacity: int = CAPACITY,
        linger_s: float = LINGER_S,
    ) -> None:
        self._database = database
        self._farm_id = farm_id
        self._is_registered = is_registered
        self._sampler = Sampler(clock)
        self.on_event: list[Callable[[RobotEvent], None]] = []
        """Told of each event that is kept, on the event loop: with its mission, and changes of mode among them."""
        self._writer: BatchWriter[_Item] = BatchWriter(
            "recorder", self._write, capacity=capacity, batch_size=5000, linger_s=linger_s
        )

    def start(self) -> None:
        """Start writing."""
        self._writer.start()

    def close(self, timeout_s: float = 2.0) -> bool:
        """Write what waits and stop; False if something was left over. Blocks."""
        return self._writer.close(timeout_s)

    def flush(self, timeout_s: float = 5.0) -> bool:
        """Wait until what was seen so far is written; False if that takes too long. Blocks."""
        return self._writer.flush(timeout_s)

    def health(self) -> WriterHealth:
        """Return queue, losses and the newest error."""
        return self._writer.health()

    def see(self, robot: Robot) -> None:
        """Take note of a robot that changed; on the event loop, as often as you like."""
        if robot.farm_id != self._farm_id or not self._is_registered(robot.id):
            return
        sample = self._sampler.sample(robot)
        if sample is not None:
            self._writer.put(sample)
        transition = self._sampler.transition(robot)
        if transition is not None:
            self.see_event(transition)

    def see_event(self, event: RobotEvent) -> None:
        """Keep an event of a registered robot; the same id again is harmless."""
        if self._is_registered(event.robot_id):
            mission_id = event.mission_id or self._sampler.mission_of(event.robot_id)
            self._writer.put(event_columns(event, self._farm_id, mission_id))
            told = replace(event, mission_id=mission_id)
            for listener in self.on_event:
                listener(told)

    def forget(self, robot_id: str) -> None:
        """Drop what is remembered of a robot that was removed; its history stays."""
        self._sampler.forget(robot_id)

    def _write(self, items: Sequence[_Item]) -> None:
        samples = [sample_columns(item) for item in items if isinstance(item, Sample)]
        events = [item for item in items if not isinstance(item, Sample)]
        with self._database.connect_writing() as connection:
            if samples:
                connection.execute(insert(SampleRow), samples)
            if events:
                _insert_new(connection, events)


def _insert_new(connection: Connection, events: list[dict[str, Any]]) -> None:
    """Insert events whose id is not there yet; both dialects spell it alike, but there is no common word for it."""
    make: Callable[..., Any] = postgresql.insert if connection.dialect.name == "postgresql" else sqlite.insert
    connection.execute(make(EventRow).on_conflict_do_nothing(index_elements=["robot_id", "id"]), events)
