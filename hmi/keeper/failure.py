"""Foreseen failures as one sentence on stderr and a non-zero exit code."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from pydantic import ValidationError

from hmi.keeper.errors import StartError

EXIT_CANNOT_START = 2
EXIT_BAD_SETTINGS = 3


@contextmanager
def report_failures() -> Iterator[None]:
    """Turn ``StartError`` and refused settings into a sentence and an exit code."""
    try:
        yield
    except StartError as error:
        print(f"Headland cannot start. {error}", file=sys.stderr)
        sys.exit(EXIT_CANNOT_START)
    except ValidationError as error:
        if error.title != "Settings":
            raise
        for problem in error.errors():
            name = "_".join(str(part) for part in problem["loc"])
            message = problem["msg"].removeprefix("Value error, ")
            print(f"Setting {f'HEADLAND_{name.upper()}: ' if name else ''}{message}", file=sys.stderr)
        sys.exit(EXIT_BAD_SETTINGS)
