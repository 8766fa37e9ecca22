"""The manual names every setting as the program knows it."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydantic import ValidationError

from hmi.keeper.settings_table import settings_table
from hmi.settings import Settings, origin_of

MANUAL = Path(__file__).parents[3] / "docs" / "operations.md"


def test_the_manual_holds_the_table_of_settings() -> None:
    assert settings_table() in MANUAL.read_text(encoding="utf-8")


def test_the_default_secret_is_refused_outside_the_demo() -> None:
    with pytest.raises(ValidationError, match="secret is the default"):
        Settings(demo=False)  # type: ignore[call-arg]
    assert Settings(demo=True).demo  # type: ignore[call-arg]


@pytest.mark.parametrize(
    "url",
    [
        "https://tiles.example/{z}/{x}.png",
        "https://{s}.tiles.example/{z}/{x}/{y}.png",
        "https://user:key@tiles.example/{z}/{x}/{y}.png",
        "https://tiles.example; script-src */{z}/{x}/{y}",
        "https://*/{z}/{x}/{y}",
        "ftp://tiles.example/{z}/{x}/{y}",
        "/tiles/{z}/{x}/{y}",
        "https://tiles.example/{z}/{x}/{y}/{key}",
        "https://tiles.example/{z}/{x}/{y}?a='b'",
    ],
)
def test_an_online_map_that_names_no_single_server_is_refused(url: str) -> None:
    with pytest.raises(ValidationError, match="online_tiles_url"):
        Settings(demo=True, online_tiles_url=url)  # type: ignore[call-arg]


def test_an_online_map_is_off_until_it_is_set_and_opens_one_origin() -> None:
    assert Settings(demo=True).online_tiles_url is None  # type: ignore[call-arg]
    url = "https://tiles.example:8443/a/{z}/{x}/{y}.png?key=1"
    assert Settings(demo=True, online_tiles_url=url).online_tiles_url == url  # type: ignore[call-arg]
    assert origin_of(url) == "https://tiles.example:8443"


def test_half_a_certificate_is_refused() -> None:
    with pytest.raises(ValidationError, match="go together"):
        Settings(demo=True, tls_cert=Path("a.pem"))  # type: ignore[call-arg]
