"""``python -m hmi.cameras``: the camera process alone, from the settings of the installation."""

from __future__ import annotations

from hmi.cameras.process import run_cameras
from hmi.settings import Settings

if __name__ == "__main__":
    run_cameras(Settings())  # type: ignore[call-arg]  # every field comes from file or variables
