"""A PostgreSQL server of the test's own: in a temporary folder, on a free port of loopback."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

UNPRIVILEGED = "nobody"  # PostgreSQL refuses to run as root


def programs() -> Path | None:
    """Return the folder of PostgreSQL's server programs, the newest one; ``None`` if it is not installed."""
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"), key=lambda one: int(one.parts[-3]))
    if found:
        return found[-1].parent
    plain = shutil.which("initdb")
    return Path(plain).parent if plain else None


@contextmanager
def cluster(bin_folder: Path) -> Iterator[str]:
    """Start a server; yield its URL without a database's name."""
    as_user = UNPRIVILEGED if os.geteuid() == 0 else None
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if as_user:
            shutil.chown(folder, as_user)
        data = folder / "data"
        _run(as_user, folder, bin_folder / "initdb", "-D", data, "-U", "headland", "-A", "trust", "-E", "UTF8", "-N")
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        options = f"-p {port} -c listen_addresses=127.0.0.1 -c unix_socket_directories='{folder}' -c fsync=off"
        control = bin_folder / "pg_ctl"
        _run(as_user, folder, control, "-D", data, "-o", options, "-l", folder / "log", "-w", "start")
        try:
            yield f"postgresql+psycopg://headland@127.0.0.1:{port}"
        finally:
            _run(as_user, folder, control, "-D", data, "-m", "immediate", "-w", "stop")


def _run(as_user: str | None, folder: Path, *command: str | Path) -> None:
    told = subprocess.run([str(part) for part in command], user=as_user, cwd=folder, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False)  # fmt: skip
    if told.returncode:
        raise RuntimeError(f"{command[0]} failed: {told.stdout}")
