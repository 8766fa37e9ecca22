"""``python -m hmi`` is ``headland``."""

from hmi.cli import main

main()
