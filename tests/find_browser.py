"""Prints the browser that the tests use: Chromium on the PATH, else Playwright's own."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path


def find_browser() -> str | None:
    """Return the path of Chromium, or ``None`` if only Playwright may know one."""
    return shutil.which("chromium") or shutil.which("chromium-browser")


def main() -> int:
    """Print the path; exit code 1 if there is no browser at all."""
    path = find_browser()
    if path is None:
        from playwright.sync_api import sync_playwright

        with sync_playwright() as playwright:
            path = playwright.chromium.executable_path
    if not Path(path).exists():
        return 1
    print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
