"""Texts that people read are whole: nothing of a merge is left in them."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
LEFT = re.compile(r"^(<{7} |>{7} |={7}$)", re.MULTILINE)


def test_no_page_of_the_documentation_has_two_versions_of_a_passage() -> None:
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    assert pages
    assert [page.name for page in pages if LEFT.search(page.read_text())] == []
