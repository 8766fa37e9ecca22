"""``python -m hmi.app``: the console process alone, as the keeper starts it; `headland console` is the same."""

from __future__ import annotations

from hmi.app import run_console
from hmi.keeper.failure import report_failures
from hmi.settings import Settings

if __name__ == "__main__":
    with report_failures():
        run_console(Settings())  # type: ignore[call-arg]  # every field comes from file or variables
