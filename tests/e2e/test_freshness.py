"""Nothing old looks fresh: values grey out by themselves, banners say so, ended sessions leave."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from tests.e2e.installation import Installation
from tests.e2e.person import Person

pytestmark = pytest.mark.browser
Come = Callable[..., Person]
ROBOT = "weeder-01"
# not awaited: the page may leave before its own answer comes
SIGN_OUT = """() => void fetch('/api/v1/session',
    {method: 'DELETE', keepalive: true, headers: {'X-Headland-CSRF': window.HEADLAND.csrf}})"""


def test_a_silent_robot_greys_out_and_the_banner_names_it(person: Come, calm: Installation) -> None:
    martha = person("operator")
    martha.operate(ROBOT)
    martha.sees("value-speed", "fresh|late")
    calm.fault(ROBOT, "silence", http=True)
    martha.sees("value-speed", "stale|lost", within_s=5)
    martha.sees("link-banner", "robot-lost", within_s=6)
    expect(martha.page.get_by_text(re.compile("No link to Weeder 01 for"))).to_be_visible()
    expect(martha.page.get_by_text("Commands are off until the link is back")).to_be_visible()
    martha.sees("stop", "no-link")
    calm.mend(ROBOT)
    martha.sees("link-banner", "ok", within_s=10)
    martha.sees("value-speed", "fresh|late")


def test_a_frozen_server_is_noticed_by_the_browser_alone(person: Come, calm: Installation) -> None:
    martha = person("operator")
    martha.operate(ROBOT)
    console = calm.pid("console")
    os.kill(console, signal.SIGSTOP)
    try:
        martha.sees("link-banner", "server-lost", within_s=6)
        martha.sees("value-speed", "stale|lost", within_s=6)
        martha.sees("stop", "ready")
    finally:
        os.kill(console, signal.SIGCONT)
    martha.sees("link-banner", "ok", within_s=20)


def test_a_burst_of_held_messages_does_not_look_fresh(person: Come, calm: Installation) -> None:
    martha = person("operator")
    martha.operate(ROBOT)
    calm.fault(ROBOT, "packets", direction="up", delay_s=4.0)
    martha.sees("value-speed", "stale|lost", within_s=8)
    martha.page.wait_for_function(
        "() => Number(document.querySelector('[data-testid=value-speed]').dataset.ageMs) > 3000", timeout=15_000
    )
    martha.page.wait_for_timeout(3000)  # messages arrive again, each four seconds old
    assert martha.state("value-speed") in ("stale", "lost")


def test_signing_out_closes_every_page_of_the_session(person: Come, calm: Installation) -> None:
    martha = person("operator", by_form=True)
    martha.operate(ROBOT)
    second = martha.context.new_page()
    second.goto("/fleet")
    expect(second.get_by_test_id("stop")).to_have_attribute("data-state", "ready", timeout=15_000)
    martha.page.evaluate(SIGN_OUT)
    for page in (martha.page, second):
        expect(page.get_by_test_id("login-name")).to_be_visible(timeout=15_000)


@pytest.mark.long
def test_a_draft_survives_ten_seconds_without_network(person: Come, calm: Installation) -> None:
    anna = person("admin")
    anna.open("/admin")
    draft = anna.page.get_by_label("Name").first
    draft.fill("Lucia Romero")
    anna.context.set_offline(True)
    anna.page.wait_for_timeout(10_000)
    anna.context.set_offline(False)
    anna.sees("link-banner", "ok", within_s=30)
    expect(anna.page.get_by_label("Name").first).to_have_value("Lucia Romero")
