"""What a robot's safety controller says reaches control and the queue, whatever it says."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from hmi.app.console import Console
from hmi.commands.lease_service import LeaseOp
from tests.hmi.commands.field import MARTHA, Field


async def test_the_button_on_the_machine_ends_control_each_time_it_is_pressed() -> None:
    field, seen = Field(), []
    console = SimpleNamespace(
        edge=SimpleNamespace(fleet=SimpleNamespace(robot=field.robot)),
        queue=SimpleNamespace(see=seen.append),
        desk=field.desk,
    )
    owners = []
    for is_pressed in (True, False, True):
        field.desk.leases.operate(MARTHA, "weeder-01", LeaseOp.REQUEST, tick_id=field.tick())
        field.weeder.hardware_stop = is_pressed
        safety = field.weeder.known().safety
        assert safety is not None
        Console._safety(cast("Any", console), "weeder-01", safety)
        owners.append(field.desk.leases.of("weeder-01"))
    assert [one is None for one in owners] == [True, False, True]
    assert len(seen) == 3
