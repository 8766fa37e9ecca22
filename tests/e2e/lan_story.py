"""What a tablet in the network does, by plain HTTP: run by ``test_lan.py`` inside a network of its own.

Not collected by itself: the address exists only in there.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for

pytestmark = pytest.mark.browser


def test_operate_and_stop_from_another_address(person: Callable[..., Person], calm: Installation) -> None:
    assert "127.0.0.1" not in calm.url
    martha = person("operator", by_form=True)
    martha.operate("weeder-01")
    assert martha.page.evaluate("window.isSecureContext") is False
    martha.sees("value-speed", "fresh|late")
    martha.hook("lease-request").click()
    wait_for(lambda: "You have control" in martha.hook("lease-owner").inner_text(), within_s=20, what="control")
    martha.press_stop()
    martha.sees("stop", "standstill")
    assert calm.world("weeder-01")["latched"]
