"""The routed part of the shell, which says in our words that a screen does not exist or did not open."""

from __future__ import annotations

from nicegui import ui

from hmi.pages import notice


class RoutedScreens(ui.sub_pages):
    """``ui.sub_pages`` with our notices instead of a bare line; frame, lane and STOP stay as they are."""

    def _render_404(self) -> None:
        text = "The address may be mistyped, or what it named was removed."
        notice.build("none", "help", "There is no such screen", text, "/operate", "Operate")

    def _render_error(self, error: Exception) -> None:
        super()._render_error(error)  # logs it
        self.clear()
        text = "The console made a mistake and has written it down. Robots and STOP are not affected. Open it again."
        with self:
            notice.build("none", "error", "This screen did not open", text, "/operate", "Operate")
