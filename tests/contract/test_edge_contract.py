"""Edge contract v1 over a real broker and real HTTP, on every broker the product runs with."""

from __future__ import annotations

import uuid
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import httpx
import pytest

from backend_clients.edge import codec
from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import mission_hash
from backend_clients.edge.topics import Down, topic
from tests.backend_clients.simulator.rig import small_mission
from tests.brokers import MOSQUITTO, free_port, start_amqtt, start_mosquitto
from tests.contract.wire import ROBOT, TOKEN, Listener, Site, running_simulator, wait_for_retained

pytestmark = pytest.mark.broker


def press(stop_id: str = "") -> down.Stop:
    return down.Stop(robot=ROBOT, stop_id=stop_id or uuid.uuid4().hex, by="Martha", device="Tablet 3")


def test_a_robot_says_who_and_how_it_is(listener: Listener) -> None:
    assert listener.wait(up.Presence).online
    assert listener.wait(up.Factsheet).family == "weeder"
    assert listener.wait(up.Safety).standstill
    assert listener.wait(up.State).mode == "idle"
    assert listener.wait(up.Telemetry).gnss is not None
    listener.command("drive_open")
    assert listener.wait(up.Event, lambda e: e.name == "Driving by hand").event_id


def test_presence_factsheet_and_nodes_are_there_for_who_comes_later(broker: str, listener: Listener) -> None:
    listener.wait(up.Node)
    with Listener(broker) as late:
        late.wait(up.Presence)
        late.wait(up.Factsheet)
        late.wait(up.Node)
        retained = {type(message) for message, is_retained in late.heard if is_retained}
    assert {up.Presence, up.Factsheet, up.Node} <= retained
    assert not retained & {up.Heartbeat, up.Telemetry, up.State, up.Safety, up.Event, up.Ack}


def test_heartbeats_come_at_5_hz_and_telemetry_at_10_hz_each_with_new_values(listener: Listener) -> None:
    """A machine that stutters beats late: five of its heartbeats in a row must come in step, not each one."""

    def in_step(heard: Sequence[up.Header], apart_ms: float) -> bool:
        steps = [later.mono_ms - sooner.mono_ms for sooner, later in pairwise(heard)]
        return any(
            all(0.75 * apart_ms <= step <= 1.25 * apart_ms for step in steps[at : at + 5])
            for at in range(len(steps) - 4)
        )

    since = listener.mark()
    listener.wait(up.Heartbeat, lambda _: in_step(listener.all(up.Heartbeat, since), 200), since=since, timeout_s=30)
    listener.wait(up.Telemetry, lambda _: in_step(listener.all(up.Telemetry, since), 100), since=since, timeout_s=30)
    beats = listener.all(up.Heartbeat, since)
    assert len({h.challenge for h in beats}) == len(beats)
    assert [h.seq for h in beats] == sorted({h.seq for h in beats})


def test_every_ping_is_echoed_once(listener: Listener) -> None:
    for nonce in ("a1", "a2", "a3"):
        listener.send(Down.PING, down.Ping(robot=ROBOT, nonce=nonce))
    for nonce in ("a1", "a2", "a3"):
        assert listener.wait(up.Heartbeat, lambda h, nonce=nonce: h.echo_nonce == nonce).echo_held_ms < 1000


def test_stop_is_acknowledged_latched_and_reset_only_by_a_fresh_lease(listener: Listener) -> None:
    stop = press()
    since = listener.mark()
    listener.send(Down.STOP, stop)
    ack = listener.wait(up.Ack, lambda a: a.ref == stop.stop_id, since=since)
    assert (ack.kind, ack.outcome) == ("stop", "accepted")
    safety = listener.wait(up.Safety, lambda s: s.latched and s.standstill, since=since)
    assert safety.presses[0].stop_id == stop.stop_id
    listener.send(Down.STOP, stop)
    assert listener.wait(up.Ack, lambda a: a.code == "already_latched", since=since).ref == stop.stop_id
    reset_id = uuid.uuid4().hex
    listener.send(
        Down.STOP_RESET,
        down.StopReset(reset_id=reset_id, stop_ids=[stop.stop_id], by="Martha", reason="Test", **listener.proof(3)),
    )
    assert listener.wait(up.Ack, lambda a: a.ref == reset_id).outcome == "accepted"
    listener.wait(up.Safety, lambda s: not s.latched, since=listener.mark())
    listener.send(Down.STOP, stop)
    assert listener.wait(up.Ack, lambda a: a.code == "already_reset").outcome == "accepted"


def test_stop_by_http_is_seen_on_mqtt(site: Site, listener: Listener) -> None:
    stop = press()
    since = listener.mark()
    answer = site.http.post(f"/{ROBOT}/stop", content=codec.encode(stop))
    assert answer.json()["outcome"] == "accepted"
    listener.wait(up.Safety, lambda s: s.latched, since=since)
    assert listener.wait(up.State, lambda s: s.mode == "stopped", since=since).hold is not None


def test_a_repeated_command_gets_the_same_answer_and_acts_once(listener: Listener) -> None:
    order = down.Command(command_id=uuid.uuid4().hex, action="drive_open", by="Martha", **listener.proof(1))
    since = listener.mark()
    for _ in range(3):
        listener.send(Down.COMMAND, order)
    listener.wait(up.Event, lambda e: e.name == "Driving by hand", since=since)
    again = down.Command(command_id=order.command_id, action="drive_close", by="Martha", **listener.proof(1))
    listener.send(Down.COMMAND, again)
    listener.wait(up.Ack, lambda _: len(_acks(listener, since, order.command_id)) == 4, since=since)
    assert {(a.outcome, a.code) for a in _acks(listener, since, order.command_id)} == {("accepted", "ok")}
    assert sum(e.name == "Driving by hand" for e in listener.all(up.Event, since)) == 1


def _acks(listener: Listener, since: int, ref: str) -> list[up.Ack]:
    return [message for message, _ in listener.heard[since:] if isinstance(message, up.Ack) and message.ref == ref]


def test_a_retained_command_is_refused_at_reconnect(broker: str, site: Site, listener: Listener) -> None:
    since = listener.mark()
    site.fault({"fault": "crash"})
    listener.wait(up.Presence, lambda p: not p.online, since=since)
    order = down.Command(
        command_id=uuid.uuid4().hex, action="drive_open", by="Martha", challenge="12345678", robot=ROBOT
    )
    try:
        listener.send(Down.COMMAND, order, retain=True)
        wait_for_retained(broker, topic(ROBOT, Down.COMMAND))
        site.mend("crash")
        assert listener.wait(up.Ack, lambda a: a.ref == order.command_id, since=since).code == "retained"
    finally:
        listener.send_bytes(Down.COMMAND, b"", retain=True)


def test_setpoints_move_it_and_silence_stops_it_within_half_a_second(site: Site, listener: Listener) -> None:
    assert listener.command("drive_open").outcome == "accepted"
    for _ in range(12):
        listener.send(Down.DRIVE, down.Drive(v_mps=0.5, yaw_rate_radps=0.0, **listener.proof(1)))
    assert site.truth()["speed_mps"] > 0.3
    stopped = site.until(lambda world: world["stopped_age_s"] is not None and world["speed_mps"] == 0)
    braking_s = 0.5 / 1.2
    assert stopped["setpoint_to_standstill_s"] <= 0.5 + braking_s + 0.2
    assert not stopped["laser_on"]


def test_a_mission_is_sent_started_and_done_over_the_wire(broker: str) -> None:
    start = {"datum_lat_deg": 52.0, "datum_lon_deg": 5.0, "y_m": -2.0, "theta_rad": 1.5708}
    mission = small_mission(rows=2)
    with running_simulator(broker, speed=30, **start) as site, Listener(broker) as listener:
        listener.wait(up.Heartbeat)
        listener.send(Down.MISSION, mission)
        ack = listener.wait(up.Ack, lambda a: a.kind == "mission")
        assert (ack.outcome, ack.sha256) == ("accepted", mission_hash(mission))
        assert listener.wait(up.State, lambda s: s.order is not None).mode == "idle"
        assert listener.command("start", mission_id=mission.mission_id, mission_sha256=ack.sha256).outcome == "accepted"
        done = listener.wait(up.State, lambda s: s.order is not None and s.order.status == "done", timeout_s=20)
        assert done.order is not None
        assert (done.order.row, done.order.rows) == (2, 2)
        for row in (1, 2):
            listener.wait(up.Event, lambda e, row=row: e.kind == "treatment" and e.data["row"] == row)
        assert site.truth()["distance_m"] > 20


def test_a_mission_of_half_a_megabyte_goes_by_mqtt(listener: Listener) -> None:
    points = [(0.0, i * 0.01) for i in range(30_000)]
    long = down.Segment(kind="row", points=points, speed_mps=1.0, tool_on=True, row=1)
    mission = small_mission(segments=[long])
    assert len(codec.encode(mission)) > 300_000
    listener.send(Down.MISSION, mission)
    assert listener.wait(up.Ack, lambda a: a.kind == "mission").sha256 == mission_hash(mission)


def test_a_crash_is_told_by_the_last_will_and_a_reboot_has_a_new_id(site: Site, listener: Listener) -> None:
    boot = listener.wait(up.Presence).boot
    since = listener.mark()
    site.fault({"fault": "crash", "reboot_after_s": 1.0})
    assert listener.wait(up.Presence, lambda p: not p.online, since=since).reason == "lost"
    back = listener.wait(up.Presence, lambda p: p.online, since=since)
    assert back.boot != boot
    assert listener.wait(up.Heartbeat, lambda h: h.boot == back.boot, since=since).challenge


def test_a_shutdown_says_goodbye(broker: str, request: pytest.FixtureRequest) -> None:
    with running_simulator(broker), Listener(broker) as listener:
        listener.wait(up.Presence, lambda p: p.online)
        since = listener.mark()
    with Listener(broker) as late:
        said = late.wait(up.Presence)
    assert since
    assert said.online is False
    # amqtt forgets a DISCONNECT that it reads together with the end of the connection, and says the will instead
    may_be_lost = request.node.callspec.params["broker"] == "amqtt"
    assert said.reason == "shutdown" or (may_be_lost and said.reason == "lost")


def test_a_silent_robot_says_nothing_but_still_stops(site: Site, listener: Listener) -> None:
    site.fault({"fault": "silence"})
    since = listener.mark()
    listener.send(Down.STOP, press())
    site.until(lambda world: world["latched"])
    late = [m for m in listener.all(up.Header, since) if m.mono_ms > listener.heard[since - 1][0].mono_ms + 300]
    assert late == []
    site.mend("silence")
    assert listener.wait(up.Safety, lambda s: s.latched, since=since)


def test_duplicated_and_reordered_packets_change_no_outcome(site: Site, listener: Listener) -> None:
    site.fault({"fault": "packets", "duplicate": 0.5, "reorder": 0.3, "jitter_s": 0.1})
    for action in ("drive_open", "drive_close", "drive_open", "drive_close"):
        listener.command(action)
    events = [e for e in listener.all(up.Event) if e.name == "Driving by hand"]
    assert len({e.event_id for e in events}) == len({e.mono_ms for e in events}) <= 2


def test_no_payload_on_any_topic_silences_the_robot(site: Site, listener: Listener) -> None:
    for payload in (b"", b"{", b"[]", b'{"robot":"weeder-02"}', b"\xff" * 100, b"9" * 70_000):
        for kind in Down:
            if kind is not Down.STOP:
                listener.send_bytes(kind, payload)
    since = listener.mark()
    listener.send(Down.PING, down.Ping(robot=ROBOT, nonce="still-there"))
    assert listener.wait(up.Heartbeat, lambda h: h.echo_nonce == "still-there", since=since)
    assert site.truth()["distance_m"] == 0


def test_a_stop_that_cannot_be_read_stops_all_the_same(listener: Listener) -> None:
    listener.send_bytes(Down.STOP, b'{"robot":"weeder-01","stop_id":"newer-console-1","by":"Anna","v":2,"zone":7}')
    assert listener.wait(up.Ack, lambda a: a.kind == "stop").ref == "newer-console-1"
    assert listener.wait(up.Safety, lambda s: s.latched)


@pytest.mark.parametrize("kind", ["mosquitto", "amqtt"])
def test_stop_by_http_works_while_the_broker_is_dead_and_events_come_later(kind: str, tmp_path: Path) -> None:
    if kind == "mosquitto" and MOSQUITTO is None:
        pytest.skip("mosquitto is not installed (apt-get install mosquitto)")
    port = free_port()

    def start() -> object:
        return start_mosquitto(tmp_path, port) if kind == "mosquitto" else start_amqtt(port)

    url = f"mqtt://127.0.0.1:{port}"
    with start():  # type: ignore[attr-defined]
        simulator = running_simulator(url)
        site = simulator.__enter__()
        with Listener(url) as listener:
            listener.wait(up.Heartbeat)
    try:
        stop = press("stop-while-dead")
        answer = httpx.post(
            f"{site.base_url}/{ROBOT}/stop",
            content=codec.encode(stop),
            headers={"Authorization": f"Bearer {TOKEN}"},
            trust_env=False,
        )
        assert answer.json()["outcome"] == "accepted"
        with start(), Listener(url) as listener:  # type: ignore[attr-defined]
            event = listener.wait(up.Event, lambda e: e.data.get("stop_id") == "stop-while-dead", timeout_s=15)
            assert event.kind == "safety"
            assert listener.wait(up.Safety).latched
    finally:
        simulator.__exit__(None, None, None)
