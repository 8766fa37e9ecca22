"""The manual names every setting as the program knows it."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydantic import ValidationError

from hmi.keeper.settings_table import settings_table
from hmi.settings import Settings

MANUAL = Path(__file__).parents[3] / "docs" / "operations.md"


def test_the_manual_holds_the_table_of_settings() -> None:
    assert settings_table() in MANUAL.read_text(encoding="utf-8")


def test_the_default_secret_is_refused_outside_the_demo() -> None:
    with pytest.raises(ValidationError, match="secret is the default"):
        Settings(demo=False)  # type: ignore[call-arg]
    assert Settings(demo=True).demo  # type: ignore[call-arg]


def test_half_a_certificate_is_refused() -> None:
    with pytest.raises(ValidationError, match="go together"):
        Settings(demo=True, tls_cert=Path("a.pem"))  # type: ignore[call-arg]
