"""A progress bar in terminals and notebooks, on the standard error."""

import sys
import time
from collections.abc import Callable
from typing import Any

from .errors import InputError

#: Width of the bar in characters, and least time between two updates [s]
WIDTH, OFTEN = 30, 0.2


class Bar:
    """Draws the progress of some work."""

    def __init__(self) -> None:
        self.start = time.monotonic()
        self.drawn = 0.0
        self.is_open = False

    def __call__(self, done: float, end: float) -> None:
        now, share = time.monotonic(), done / end if end > 0 else 0.0
        if now - self.drawn < OFTEN and share < 1.0:
            return
        self.drawn = now
        full = round(WIDTH * min(share, 1.0))
        bar = "#" * full + "." * (WIDTH - full)
        sys.stderr.write(f"\r{bar} {100 * share:5.1f} %  {now - self.start:6.1f} s")
        sys.stderr.flush()
        self.is_open = True

    def close(self) -> None:
        """Ends the line of the bar."""
        if self.is_open:
            sys.stderr.write("\n")
            sys.stderr.flush()
        self.is_open = False


def follower(progress: Any) -> Callable[[float, float], Any] | None:
    """Returns the function that is called with the work done and the total work; `None` if nothing shows the progress."""
    if progress is None or progress is False:
        return None
    if progress is True:
        return Bar()
    if not callable(progress):
        fact = f"progress of the type {type(progress).__name__} cannot be called"
        raise InputError(fact, "give True, or a function of what is done and what is to be done")
    return progress


def close(follower: Callable[[float, float], Any]) -> None:
    """Ends the line of a bar when the work that it follows has ended or was stopped."""
    if isinstance(follower, Bar):
        follower.close()
