"""What can keep an installation from starting, each one sentence for a person."""

from __future__ import annotations


class StartError(Exception):
    """The installation cannot start; the message says what to do."""
