"""How long pictures were under way: what waits behind a slow radio is old, however fresh its robot calls it."""

from __future__ import annotations

DRIFT = 1e-4  # two quartz clocks part by up to 100 ppm; seen as age that would be a second after three hours
STEP_MS = 250.0  # jitter of a loaded machine that is not yet a clock that was set
HIDES_MS = 1000.0  # a clock set forward by more could hide that a picture is frozen


class Transit:
    """How much longer than the quickest a part was under way. Times in ms.

    A robot writes the age of a picture when it begins to send it, and only then the picture waits in the robot's
    send buffer: for seconds, where the radio carries less than the camera sends. When a part was begun by the
    robot's clock, taken from when it came, is how far both clocks are apart and its way; nothing comes early, so the
    least of it is the quickest way, and what a part has on top it waited.

    That least is never forgotten: a line that is full for long would teach that waiting is normal. It rises by the
    drift of two clocks, a third of a second in an hour. A clock that is set back by more than the distance of two
    parts is seen by the next one; one that is set forward hides what waits now, and ``is_hidden`` says so.

    How long the quickest itself was under way no surplus tells: on a line that is full from the first picture on even
    that one waited. A robot that says when it heard the request cannot have heard it before it was sent, which tells
    how far both clocks are apart at most. ``way_ms`` is the most that the quickest was under way by that, ``None``
    where the robot does not say it.
    """

    def __init__(self) -> None:
        self.way_ms: float | None = None
        self._heard_ms: float | None = None
        self._least_ms: float | None = None
        self._came_ms = 0.0
        self._begun_ms = float("-inf")
        self._waited_ms = 0.0
        self._asked_ms: float | None = None
        self.is_hidden = False

    def asked(self, at_ms: float) -> None:
        """Note that pictures were asked for on a new connection, on which none waits yet."""
        if self.is_hidden:
            self.way_ms = None  # the robot's clock is another one
        self._asked_ms, self._heard_ms, self.is_hidden = at_ms, None, False

    def heard(self, robot_ms: float) -> None:
        """Note when the robot heard what was asked for last, by its clock; before the first part of its answer."""
        self._heard_ms = robot_ms

    def waited_ms(self, begun_ms: float, came_ms: float) -> float:
        """Return how much longer than the quickest a part was under way.

        Args:
            begun_ms: when it was begun on the robot's clock, whatever its zero.
            came_ms: when its first byte came on ours.
        """
        apart_ms, asked_ms, self._asked_ms = came_ms - begun_ms, self._asked_ms, None
        heard_ms, self._heard_ms, before_ms = self._heard_ms, None, self._least_ms
        if self._least_ms is not None and begun_ms < self._begun_ms:
            # parts are begun one after the other: its clock was set back, and this one waited as the one before
            self._least_ms, self._came_ms = apart_ms - self._waited_ms, came_ms
        self._begun_ms = begun_ms
        least_ms = apart_ms
        if self._least_ms is not None:
            least_ms = self._least_ms + DRIFT * (came_ms - self._came_ms)
            if asked_ms is None:
                self.is_hidden |= least_ms - apart_ms > HIDES_MS
            elif apart_ms - least_ms > came_ms - asked_ms + STEP_MS:
                least_ms = apart_ms  # begun before it was asked for? the robot's clock was set back
        self._least_ms, self._came_ms = min(least_ms, apart_ms), came_ms
        self._waited_ms = apart_ms - self._least_ms
        if heard_ms is not None and asked_ms is not None:
            most_ms = max(0.0, self._least_ms - (asked_ms - heard_ms))
            self.way_ms = most_ms if self.way_ms is None else min(self.way_ms, most_ms)
        elif self.way_ms is not None and before_ms is not None:
            self.way_ms -= min(self.way_ms, max(0.0, before_ms - self._least_ms))  # this one was quicker
        return self._waited_ms
