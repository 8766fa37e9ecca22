"""A person in front of a screen: finds things by their stable hooks, acts by touch, reads what is shown."""

from __future__ import annotations

import re
import time
from typing import Any

from playwright.sync_api import BrowserContext, Locator, Page, expect

from tests.e2e.installation import Installation

SLAB_POINTS = ((0.5, 0.5), (0.03, 0.08), (0.97, 0.08), (0.03, 0.92), (0.97, 0.92))
STOP_WORKS = "ready|standstill|sent"


class Person:
    """One browser and the hands on it."""

    def __init__(self, name: str, context: BrowserContext, installation: Installation) -> None:
        self.name = name
        self.context = context
        self.installation = installation
        self.page: Page = context.new_page()
        self._note_troubles()

    def _note_troubles(self) -> None:
        """Print what goes wrong in the browser: shown with a test that fails."""
        self.page.on("pageerror", lambda error: print(f"[{self.name}'s page] {error}"))
        self.page.on("requestfailed", lambda request: print(f"[{self.name} lost] {request.url}: {request.failure}"))
        self.page.on("framenavigated", lambda frame: print(f"[{self.name} at] {time.monotonic():.1f} {frame.url}"))
        self.page.on(
            "response",
            lambda answer: answer.status < 400 or print(f"[{self.name} refused] {answer.status} {answer.url}"),
        )

    def sign_in(self) -> None:
        """Sign in with name and password, which are the same in the demo."""
        self.page.goto("/login")
        if self.hook("login-name").count() == 0 or not self.hook("login-name").is_visible():
            self.page.get_by_text("another name").click()
        self.hook("login-name").fill(self.name)
        self.hook("login-password").fill(self.name)
        self.hook("login-submit").click()
        self.sees("stop", STOP_WORKS, within_s=15)

    def come_in(self) -> None:
        """Be signed in without the form: as the page does it, but without the two pages it takes."""
        answer = self.context.request.post("/api/v1/session", data={"name": self.name, "password": self.name})
        assert answer.ok, answer.text()
        self.page.goto("/api/v1/health")  # any answer of this origin
        self.page.evaluate("token => localStorage.setItem('headland.stop_token', token)", answer.json()["stop_token"])

    def open(self, path: str) -> None:
        """Go to a screen by its address."""
        self.page.goto(path)

    def operate(self, robot: str) -> None:
        """Open the Operate screen of a robot and wait until it shows live values."""
        self.page.goto(f"/operate/{robot}")
        self.sees("stop", STOP_WORKS, within_s=15)
        expect(self.hook("value-speed")).to_have_attribute("data-value", re.compile(r"\d"), timeout=15_000)

    def hook(self, name: str) -> Locator:
        """Return the element with a ``data-testid``."""
        return self.page.get_by_test_id(name)

    def state(self, hook: str) -> str | None:
        """Return what an element says it is."""
        return self.hook(hook).get_attribute("data-state")

    def value(self, hook: str) -> float:
        """Return the SI value that an element shows."""
        return float(self.hook(hook).get_attribute("data-value") or "nan")

    def sees(self, hook: str, state: str, *, within_s: float = 10.0) -> None:
        """Wait until an element is in one of the states of the pattern ``state``."""
        expect(self.hook(hook)).to_have_attribute("data-state", re.compile(f"^({state})$"), timeout=within_s * 1000)

    def press_stop(self) -> None:
        """Put a finger on STOP."""
        self.press("stop")

    def press(self, hook: str) -> None:
        """Press an element as a finger does, where it really is on the screen."""
        box = self.box(hook)
        self.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        self.page.mouse.down()
        self.page.mouse.up()

    def order(self, hook: str, *, into: str) -> None:
        """Press a button until the robot is in a mode; a press that was refused, or met no button, is made anew.

        A screen that a busy machine painted late is older than the 2 s that the console allows: the refusal is right,
        and a person presses again. So she does when the dock was laid out anew under her finger.
        """
        for _ in range(3):
            self.hook(hook).click()
            try:
                self.sees("robot-mode", into, within_s=6)
            except AssertionError:
                if self.hook(hook).count() and self.state(hook) == "accepted":
                    raise
            else:
                return
        raise AssertionError(f"{hook} is refused again and again: {self.hook(hook).inner_text()}")

    def slide(self, hook: str) -> None:
        """Drag the thumb of a slide-to-confirm past its flag and let go."""
        if hook in ("mission-start", "mission-resume"):
            self.tick_list()
        expect(self.hook(f"{hook}-thumb")).to_be_visible()
        track, thumb = self.box(hook), self.box(f"{hook}-thumb")
        y = thumb["y"] + thumb["height"] / 2
        self.page.mouse.move(thumb["x"] + thumb["width"] / 2, y)
        self.page.mouse.down()
        self.page.mouse.move(track["x"] + track["width"] - 4, y, steps=12)
        self.page.mouse.up()

    def slide_into(self, hook: str, mode: str) -> None:
        """Slide until the robot is in a mode; as with ``order``, one that a busy machine let pass is made anew."""
        for _ in range(3):
            self.slide(hook)
            try:
                self.sees("robot-mode", mode, within_s=6)
            except AssertionError:
                if self.hook(hook).count() == 0 or self.state(hook) == "accepted":
                    raise
            else:
                return
        raise AssertionError(f"{hook} starts nothing: {self.hook(hook).inner_text()}")

    def tick_list(self) -> None:
        """Tick the list before a start, if this screen asks for it and it is not ticked yet."""
        button = self.hook("mission-checks")
        if button.count() == 0:
            return
        expect(button).to_contain_text(re.compile(r"\d of \d(?!.*loading)"), timeout=10_000)
        if "list open" not in button.inner_text():
            return
        button.click()
        sheet = self.hook("start-sheet")
        expect(sheet.get_by_role("checkbox").first).to_be_visible()
        for line in sheet.get_by_role("checkbox").all():
            line.click()
        expect(sheet.get_by_test_id("checklist-state")).to_contain_text("Ticked by", timeout=10_000)
        sheet.get_by_role("button", name="Close").click()

    def hold(self, hook: str) -> None:
        """Put a finger on an element and leave it there; ``let_go`` lifts it."""
        box = self.box(hook)
        self.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        self.page.mouse.down()

    def let_go(self) -> None:
        """Lift the finger."""
        self.page.mouse.up()

    def box(self, hook: str) -> Any:
        """Return the place of a visible element."""
        expect(self.hook(hook)).to_be_visible()
        box = self.hook(hook).bounding_box()
        assert box is not None
        return box

    def covers_of_stop(self) -> list[str]:
        """Return what lies over STOP at five points; empty when nothing does."""
        found: list[str] = self.page.evaluate(
            """(points) => {
                const slab = document.querySelector('[data-testid=stop]');
                const box = slab.getBoundingClientRect();
                return points.map(([u, v]) => document.elementFromPoint(box.x + u * box.width, box.y + v * box.height))
                    .filter(e => !(e && (e === slab || slab.contains(e))))
                    .map(e => e ? e.tagName + '.' + e.className : 'nothing');
            }""",
            [list(point) for point in SLAB_POINTS],
        )
        return found


def wait_for(condition: Any, *, within_s: float, what: str) -> float:
    """Poll ``condition`` until it holds; return the seconds it took.

    For ground truth in the simulator, which no browser event announces.
    """
    started_s = time.monotonic()
    while time.monotonic() - started_s < within_s:
        if condition():
            return time.monotonic() - started_s
        time.sleep(0.02)
    raise AssertionError(f"not within {within_s} s: {what}")
