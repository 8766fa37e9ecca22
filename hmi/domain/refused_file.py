"""A file that a person gave and that cannot be taken.

```
Exception
└── RefusedFile      the file is refused as a whole
    ├── BadMapFile   hmi.map_files: a map to import, or the wish to write one
    └── BadBaseMap   hmi.base_maps: a photo or a map to lie under the farm's own
```
"""

from __future__ import annotations


class RefusedFile(Exception):
    """The whole file is refused.

    Attributes:
        code: for programs, for example ``not_a_map``.
        text: for the person: what is wrong and what to do.
    """

    def __init__(self, code: str, text: str) -> None:
        super().__init__(code, text)  # both, so that it comes whole out of another process
        self.code = code
        self.text = text

    def __str__(self) -> str:
        return self.text
