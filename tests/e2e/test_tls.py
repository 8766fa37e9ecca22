"""HTTPS with the farm's own certificate: console, live lane and STOP gateway speak it together."""

from __future__ import annotations

import ssl
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from playwright.sync_api import Browser

from tests.e2e.conftest import SIZES
from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for
from tests.e2e.test_installation import headland

pytestmark = pytest.mark.browser


@pytest.fixture
def safe(tmp_path: Path) -> Iterator[Installation]:
    """A demo that speaks HTTPS with a certificate of `headland cert`."""
    data = tmp_path / "data"
    made = headland("cert", "127.0.0.1", "localhost", HEADLAND_DATA=str(data))
    assert made.returncode == 0, made.stderr
    running = Installation.start(data, "--tls")
    yield running
    running.end()


@pytest.mark.long
def test_a_tablet_that_trusts_the_farm_operates_and_stops_by_https(safe: Installation, plain_browser: Browser) -> None:
    trust = ssl.create_default_context(cafile=safe.data / "tls" / "ca.pem")
    assert httpx.get(f"{safe.url}/api/v1/health", verify=trust, trust_env=False).status_code == 200
    with pytest.raises(httpx.ConnectError):  # whoever does not trust the farm sees no page
        httpx.get(f"{safe.url}/api/v1/health", trust_env=False)
    width, height = SIZES["landscape"]
    # the browser under test has no store of its own to put the farm's authority in
    context = plain_browser.new_context(
        viewport={"width": width, "height": height}, base_url=safe.url, ignore_https_errors=True
    )
    martha = Person("operator", context, safe)
    martha.sign_in()
    martha.operate("weeder-01")
    assert martha.page.evaluate("window.isSecureContext") is True
    martha.hook("lease-request").click()
    wait_for(lambda: "You have control" in martha.hook("lease-owner").inner_text(), within_s=20, what="control")
    martha.press_stop()
    martha.sees("stop", "standstill")
    assert safe.world("weeder-01")["latched"]
    context.close()


def test_https_without_a_certificate_is_one_sentence(tmp_path: Path) -> None:
    ended = headland("demo", "--tls", HEADLAND_DATA=str(tmp_path / "data"))
    assert ended.returncode != 0
    assert "Make one with `headland cert ADDRESS`" in ended.stderr
    assert "Traceback" not in ended.stderr
