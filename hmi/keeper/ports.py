"""Ports: is it free, who may have it, give me one."""

from __future__ import annotations

import errno
import socket

from hmi.keeper.errors import StartError


def free_port(host: str = "127.0.0.1") -> int:
    """Return a TCP port that is free on ``host`` now."""
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        probe.bind((host, 0))
        port: int = probe.getsockname()[1]
        return port


def require_free(host: str, port: int, setting: str) -> None:
    """Raise ``StartError`` with one clear sentence unless ``host:port`` can be bound."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            raise StartError(_sentence(host, port, setting, error)) from error


def _sentence(host: str, port: int, setting: str, error: OSError) -> str:
    if error.errno == errno.EADDRINUSE:
        return f"Port {port} on {host} is in use by another program: end it, or choose another port with {setting}."
    if error.errno == errno.EACCES:
        return f"Port {port} needs administrator rights: choose a port above 1023 with {setting}."
    return f"Cannot listen on {host}:{port} ({error.strerror}): check HEADLAND_HOST and {setting}."
