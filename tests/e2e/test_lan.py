"""The console on an address that is not loopback, where browsers withhold what needs a secure context."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import pytest

from tests.e2e.installation import ROOT

ADDRESS = "192.168.77.1"
NETWORK = f"""
set -e
ip link set lo up
ip address add {ADDRESS}/24 dev lo
exec "$@"
"""


def unshare() -> list[str]:
    """Return the command that gives a child a network of its own; skips where that is not permitted."""
    if not shutil.which("unshare") or not shutil.which("ip", path=f"{os.environ['PATH']}:/usr/sbin:/sbin"):
        pytest.skip("needs unshare (util-linux) and ip (iproute2)")
    for command in (["unshare", "--net"], ["unshare", "--net", "--map-root-user"]):
        if subprocess.run([*command, "true"], capture_output=True, check=False).returncode == 0:
            return command
    pytest.skip("this machine does not let the test make a network namespace")


@pytest.mark.browser
@pytest.mark.broker
@pytest.mark.timeout(180)
def test_a_tablet_in_the_network_operates_and_stops_by_plain_http() -> None:
    story = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/e2e/lan_story.py"]
    ended = subprocess.run(
        [*unshare(), "sh", "-c", NETWORK, "sh", *story],
        cwd=ROOT,
        env={**os.environ, "HEADLAND_TEST_HOST": ADDRESS, "PATH": f"{os.environ['PATH']}:/usr/sbin:/sbin"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stdout[-4000:] + ended.stderr[-2000:]
    assert "1 passed" in ended.stdout
