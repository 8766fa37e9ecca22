"""A custom element that the browser draws from the live lane; Python only places it.

Live values never travel over the NiceGUI socket, so these elements have no server state: their script reads
``window.headland`` and writes the DOM at most once a frame.
"""

from __future__ import annotations

from nicegui.element import Element


class LiveElement(Element):
    """An ``<hl-...>`` element with plain attributes.

    Args:
        tag: name of the custom element, as defined in ``static/js/ui``.
        classes: CSS classes.
        hook: stable ``data-testid``.
        attributes: further attributes; ``data_robot="x"`` becomes ``data-robot="x"``.
    """

    def __init__(self, tag: str, *, classes: str = "", hook: str = "", **attributes: str) -> None:
        super().__init__(tag)
        self.classes(classes)
        if hook:
            self._props["data-testid"] = hook
        for name, value in attributes.items():
            self._props[name.rstrip("_").replace("_", "-")] = value
