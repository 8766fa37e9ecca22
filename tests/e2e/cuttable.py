"""A line to the console that can be cut: a TCP forwarder that drops connections by what they asked for."""

from __future__ import annotations

import contextlib
import socket
import threading
from types import TracebackType


class CuttableLine:
    """Forwards a free port of loopback to another port."""

    def __init__(self, port: int) -> None:
        self._target = port
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._open: list[tuple[bytes, socket.socket, socket.socket]] = []
        self._thread = threading.Thread(target=self._accept, daemon=True)

    @property
    def url(self) -> str:
        """Address to be used instead of the console's."""
        return f"http://127.0.0.1:{self._listener.getsockname()[1]}"

    def __enter__(self) -> CuttableLine:
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._listener.close()
        self.cut(b"")

    def cut(self, asked: bytes) -> int:
        """Cut the connections whose first words hold ``asked``; return how many."""
        chosen = [one for one in self._open if asked in one[0]]
        for entry in chosen:
            self._open.remove(entry)
            for end in entry[1:]:
                with contextlib.suppress(OSError):
                    end.shutdown(socket.SHUT_RDWR)
                end.close()
        return len(chosen)

    def _accept(self) -> None:
        while True:
            try:
                near, _ = self._listener.accept()
            except OSError:
                return
            threading.Thread(target=self._carry, args=(near,), daemon=True).start()

    def _carry(self, near: socket.socket) -> None:
        with contextlib.suppress(OSError):
            first = near.recv(65536)
            far = socket.create_connection(("127.0.0.1", self._target))
            far.sendall(first)
            entry = (first.split(b"\r\n", 1)[0], near, far)
            self._open.append(entry)
            threading.Thread(target=_pump, args=(far, near), daemon=True).start()
            _pump(near, far)
            with contextlib.suppress(ValueError):  # it was cut
                self._open.remove(entry)


def _pump(source: socket.socket, target: socket.socket) -> None:
    with contextlib.suppress(OSError):
        while data := source.recv(65536):
            target.sendall(data)
    for end in (source, target):
        with contextlib.suppress(OSError):
            end.shutdown(socket.SHUT_RDWR)
