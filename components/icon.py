"""An icon of the bundled font, as markup; names are listed in static/icons/icons.txt."""

from __future__ import annotations


def icon(name: str, look: str = "") -> str:
    """Return the markup of an icon; ``look`` adds size (s, m, l, big) and fill (f).

    Args:
        name: a name of static/icons/icons.txt; never text from outside, for it is not escaped.
    """
    classes = f"h-i {look}".strip()
    return f'<i class="{classes}" aria-hidden="true">{name}</i>'
