"""``python -m hmi.media``: the media process alone, from the settings of the installation."""

from __future__ import annotations

from hmi.media.process import run_media
from hmi.settings import Settings

if __name__ == "__main__":
    run_media(Settings())  # type: ignore[call-arg]  # every field comes from file or variables
