"""Reading in large pieces changes nothing of what is read."""

from __future__ import annotations

import socket
import threading

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from backend_clients.edge.buffered import READ_BYTES, BufferedSocket, Publication
from backend_clients.edge.mqtt import MqttLink

CONNACK, SUBACK_HEAD = b"\x20\x02\x00\x00", b"\x90"


@settings(deadline=None)
@given(
    data=st.binary(min_size=1, max_size=3000), cuts=st.lists(st.integers(1, 700)), sizes=st.lists(st.integers(1, 900))
)
def test_bytes_come_out_as_they_went_in(data: bytes, cuts: list[int], sizes: list[int]) -> None:
    near, far = socket.socketpair()
    with near, far:
        buffered = BufferedSocket(near)
        near.setblocking(False)
        got, at = b"", 0
        for cut, size in zip([*cuts, len(data)], [*sizes, *[50] * len(cuts)], strict=False):
            far.sendall(data[at : at + cut])
            at += cut
            for _ in range(3):
                try:
                    got += buffered.recv(size)
                except BlockingIOError:
                    assert buffered.pending() == 0
        far.sendall(data[at:])
        far.shutdown(socket.SHUT_WR)
        while piece := buffered.recv(100):
            got += piece
        assert got == data


def test_a_socket_without_data_says_so_and_stays_usable() -> None:
    near, far = socket.socketpair()
    with near, far:
        buffered = BufferedSocket(near)
        buffered.setblocking(False)
        with pytest.raises(BlockingIOError):
            buffered.recv(10)
        far.sendall(b"abc")
        assert (buffered.recv(1), buffered.pending(), buffered.recv(10)) == (b"a", 2, b"bc")


def publish(topic: bytes, payload: bytes, first: bytes = b"\x30") -> bytes:
    """Return an MQTT PUBLISH, of QoS 0 unless ``first`` says otherwise."""
    body = len(topic).to_bytes(2, "big") + topic + payload
    length, size = len(body), b""
    while True:
        length, digit = divmod(length, 128)
        size += bytes([digit | (0x80 if length else 0)])
        if not length:
            return first + size + body


def publications(stream: bytes) -> tuple[list[Publication], int]:
    """Return what a buffer that holds ``stream`` takes out at once, and how much it leaves."""
    near, far = socket.socketpair()
    with near, far:
        buffered = BufferedSocket(near)
        far.sendall(b"." + stream)
        assert buffered.recv(1) == b"."
        taken = []
        while publication := buffered.take_publication():
            taken.append(publication)
        return taken, buffered.pending()


@pytest.mark.slow
@given(messages=st.lists(st.tuples(st.binary(max_size=200), st.binary(max_size=300), st.booleans()), min_size=1))
def test_whole_publications_are_taken_out_and_a_cut_one_is_left(messages: list[tuple[bytes, bytes, bool]]) -> None:
    packets = [publish(t, p, b"\x31" if kept else b"\x30") for t, p, kept in messages]
    assert publications(b"".join(packets)) == ([Publication(*one) for one in messages], 0)
    cut = b"".join(packets)[:-1]
    assert publications(cut) == ([Publication(*one) for one in messages[:-1]], len(packets[-1]) - 1)


@pytest.mark.parametrize(
    "stream",
    [
        publish(b"a/b", b"\x00\x01needs an answer", b"\x32"),
        b"\xd0\x00",
        b"\x30\x00",
        b"\x30\x01\x00",
        b"\x30\x04\x00\x09ab",
        b"\x30\xff\xff\xff\xff\x01",
        b"\x30\xff",
        b"\x30",
    ],
    ids=["qos 1", "ping", "no body", "half a topic length", "topic longer than packet", "length", "cut length", "cut"],
)
def test_what_is_not_a_whole_qos_0_publication_is_left_to_paho(stream: bytes) -> None:
    assert publications(stream) == ([], len(stream))


def test_a_topic_that_is_no_text_is_a_fault_and_harms_nothing_after_it() -> None:
    stream = b"".join(
        [publish(b"\xff\xfe", b"1"), publish(b"a/b", b"2"), publish(b"\xff", b"3"), publish(b"a/b", b"4", b"\x31")]
    )
    got: list[tuple[str, bytes, bool]] = []
    faults: list[Exception] = []
    done = threading.Event()

    def on_message(topic: str, payload: bytes, is_retained: bool) -> None:
        got.append((topic, payload, is_retained))
        if payload == b"4":
            done.set()

    with socket.create_server(("127.0.0.1", 0)) as listener:
        broker = threading.Thread(target=serve, args=(listener, stream, len(stream)))
        broker.start()
        url = f"mqtt://127.0.0.1:{listener.getsockname()[1]}"
        link = MqttLink(url, "test", subscriptions=[("a/b", 0)], on_message=on_message, on_fault=faults.append)
        link.start()
        assert done.wait(20)
        link.stop()
        broker.join(5)
    assert got == [("a/b", b"2", False), ("a/b", b"4", True)]
    assert [type(fault) for fault in faults] == [UnicodeDecodeError, UnicodeDecodeError]


def serve(listener: socket.socket, stream: bytes, piece: int) -> None:
    """Be a broker for one client: accept, then send ``stream`` in pieces."""
    sock, _ = listener.accept()
    with sock:
        sock.recv(4096)
        sock.sendall(CONNACK)
        request = sock.recv(4096)
        packet_id = request[2:4]
        sock.sendall(SUBACK_HEAD + b"\x03" + packet_id + b"\x00")
        for at in range(0, len(stream), piece):
            sock.sendall(stream[at : at + piece])
        sock.recv(4096)


@pytest.mark.parametrize("piece", [1, 7, 1000, 10_000_000])
def test_every_message_arrives_however_the_network_cuts_the_stream(piece: int) -> None:
    small = [b"%d" % n for n in range(150 if piece == 1 else 900)]
    large = bytes(range(256)) * (4 if piece == 1 else 3 * READ_BYTES // 256)
    stream = b"".join(publish(b"a/b", p) for p in [*small, large, b"last"])
    got: list[bytes] = []
    done = threading.Event()

    def on_message(_topic: str, payload: bytes, _is_retained: bool) -> None:
        got.append(payload)
        if payload == b"last":
            done.set()

    with socket.create_server(("127.0.0.1", 0)) as listener:
        broker = threading.Thread(target=serve, args=(listener, stream, piece))
        broker.start()
        port = listener.getsockname()[1]
        link = MqttLink(f"mqtt://127.0.0.1:{port}", "test", subscriptions=[("a/b", 0)], on_message=on_message)
        link.start()
        assert done.wait(20)
        assert link.is_alive
        link.stop()
        assert not link.is_alive
        broker.join(5)
    assert got == [*small, large, b"last"]
