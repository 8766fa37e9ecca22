"""``python -m hmi.stop_gateway``: the STOP process alone, from the settings of the installation."""

from __future__ import annotations

import sys

from hmi.lean_start import lean_start

with lean_start("httpx"):
    from hmi.settings import Settings
    from hmi.stop_gateway.errors import GatewayError
    from hmi.stop_gateway.process import run_gateway

if __name__ == "__main__":
    try:
        run_gateway(Settings())  # type: ignore[call-arg]
    except (GatewayError, OSError, ValueError) as error:
        sys.exit(f"headland stop: {error}")
