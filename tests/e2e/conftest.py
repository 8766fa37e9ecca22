"""One running demo for all browser tests, and people who use it on tablets."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext

from tests.e2e.installation import ROBOTS, Installation
from tests.e2e.person import Person

IS_LONG = bool(os.environ.get("HEADLAND_LONG"))  # cameras cost the regular run more than they prove in it
SIZES = {"landscape": (1280, 800), "portrait": (800, 1280), "desk": (1920, 1080)}


@pytest.fixture(scope="session")
def installation(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Installation]:
    """A demo that runs for the whole session; ends with Ctrl+C."""
    host = os.environ.get("HEADLAND_TEST_HOST", "127.0.0.1")
    data = tmp_path_factory.mktemp("demo") / "data"
    running = Installation.start(data, host=host, has_media=True, has_cameras=IS_LONG)
    yield running
    running.end()


@pytest.fixture
def calm(installation: Installation) -> Iterator[Installation]:
    """The demo with healthy robots that stand still and are not stopped; faults end with the test."""
    installation.calm()
    yield installation
    for robot in ROBOTS:
        installation.mend(robot)


@pytest.fixture
def person(request: pytest.FixtureRequest, calm: Installation) -> Iterator[Callable[..., Person]]:
    """Give people with their own browsers: ``person("operator")``, ``person("viewer", size="portrait")``.

    They are signed in, with ``by_form`` as a person does it.
    Their tablets have no WebGL unless ``has_webgl`` is said: drawing it in software takes a core.
    """
    contexts: list[BrowserContext] = []

    def come(
        name: str,
        *,
        size: str = "landscape",
        sign_in: bool = True,
        by_form: bool = False,
        has_webgl: bool = False,
        **options: Any,
    ) -> Person:
        width, height = SIZES[size]
        browser: Browser = request.getfixturevalue("browser" if has_webgl else "plain_browser")
        context = browser.new_context(
            viewport={"width": width, "height": height}, has_touch=size != "desk", base_url=calm.url, **options
        )
        contexts.append(context)
        someone = Person(name, context, calm)
        if sign_in and by_form:
            someone.sign_in()
        elif sign_in:
            someone.come_in()
        return someone

    yield come
    for context in contexts:
        context.close()
