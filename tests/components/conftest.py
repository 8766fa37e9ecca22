"""What the tests of components share."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="session")
def base_url() -> str:
    """Stand in for the plugin's own fixture, which newer pytest warns of; these tests serve their own pages."""
    return ""
