"""What a robot says of itself, and what nobody may make of what it does not say."""

from __future__ import annotations

from backend_clients.edge import messages_up as up
from hmi.clock import FakeClock
from hmi.ingest import translate
from tests.hmi.ingest.wire import FakeWireRobot


def test_what_it_does_by_itself_is_not_known_where_its_factsheet_does_not_say_so() -> None:
    robot = FakeWireRobot("mower-7", FakeClock())
    silent = translate.factsheet(robot.factsheet(behaviour=None))
    times = (silent.drive_deadman_s, silent.operator_lost_pause_s, silent.link_lost_pause_s, silent.start_horn_s)
    assert times == (None, None, None, None)
    assert silent.keep_out_m == 15.0, "people stay away all the same"
    told = translate.factsheet(robot.factsheet(behaviour=up.Behaviour(operator_lost_pause_s=2.0)))
    assert (told.operator_lost_pause_s, told.keep_out_m) == (2.0, 15.0)
