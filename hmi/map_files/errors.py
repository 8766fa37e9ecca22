"""What goes wrong with a map file.

```
Exception
└── BadMapFile    the file, or the wish to write one, is refused as a whole
```
"""

from __future__ import annotations


class BadMapFile(Exception):
    """The whole file is refused.

    Attributes:
        code: for programs, for example ``not_a_map``.
        text: for the operator: what is wrong and what to do.
    """

    def __init__(self, code: str, text: str) -> None:
        super().__init__(code, text)  # both, so that it comes whole out of another process
        self.code = code
        self.text = text

    def __str__(self) -> str:
        return self.text
