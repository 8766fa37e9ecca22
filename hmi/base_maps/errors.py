"""What goes wrong with a base map.

```
Exception
└── BadBaseMap    the file is refused as a whole, or cannot be used any more
```
"""

from __future__ import annotations


class BadBaseMap(Exception):
    """The file is refused.

    Attributes:
        code: for programs, for example ``no_coordinates``.
        text: for the planner: what is wrong and what to do.
    """

    def __init__(self, code: str, text: str) -> None:
        super().__init__(code, text)  # both, so that it comes whole out of another process
        self.code = code
        self.text = text

    def __str__(self) -> str:
        return self.text
