"""Exceptions: what is wrong (`fact`), how to fix it (`remedy`), and how the call ended (`status`); and the warning of doubtful derivatives."""

import sys
import warnings
from collections.abc import Callable
from types import FrameType
from typing import Any


class DurometerError(Exception):
    """The base class of the exceptions of this package.

    >>> import durometer
    >>> try:
    ...     durometer.Scene.from_toml("no-such-scene.toml")
    ... except durometer.DurometerError as error:
    ...     error.status
    'Refused'
    """

    def __init__(self, fact: str, remedy: str = "", status: str = "Refused", *, result: Any = None):
        super().__init__(f"{fact}; {remedy}" if remedy else fact)
        self.fact = fact
        self.remedy = remedy
        self.status = status
        self.result = result

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        """Tells `pickle` how to rebuild the exception; its `result` is kept if it is a `Run`, a `Report` or a dictionary, and dropped otherwise."""
        from ._pickled import error, portable

        return error, (type(self), self.fact, self.remedy, self.status, portable(self.result))


class InputError(DurometerError, ValueError):
    """Input that is refused before anything is computed; the program ends with exit code 2."""


class RunError(DurometerError, RuntimeError):
    """A run, a search or a study that is not complete; `result` has the partial result. The program ends with exit code 3.

    Functions of `durometer.jax` and `durometer.torch` raise it for every design without an answer: also if the scene refuses the numbers
    (`status` is "Refused"), and if there is no derivative ("NoDerivative").
    """


class MissingExtra(DurometerError, ImportError):
    """A package that this function needs is not installed; `remedy` is the command that installs it."""


class OutOfDomain(DurometerError, ArithmeticError):
    """Raised by a law in Python where it is not defined: the step is then repeated with a fraction of its length, as for a number that is not finite."""

    def __init__(self, fact: str = "the law is not defined here", remedy: str = "", status: str = "Refused", *, result: Any = None):
        super().__init__(fact, remedy, status, result=result)


class DoubtfulDerivative(UserWarning):
    """Derivatives whose relative estimated error is above 1e-6; `doubtful` has key, value and estimated error of each."""

    def __init__(self, doubtful: list[tuple[str, float, float]]):
        texts = [f"by {key} {value:.6g} ± {error:.1g}" for key, value, error in doubtful]
        super().__init__(f"derivatives that are less accurate than 1e-6: {', '.join(texts)}")
        self.doubtful = doubtful

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        """Tells `pickle` to rebuild the warning from its derivatives, not from its text."""
        return type(self), (self.doubtful,)


#: Packages through which runs and derivatives are requested
BETWEEN = {"contextlib", "durometer", "functools", "jax", "jaxlib", "torch"}


def warn_of_limits(limits: list[str]) -> None:
    """Issues a warning for each limit on the use of the numbers of a run, at the line that asked for the run."""
    for limit in limits:
        warnings.warn(limit, UserWarning, stacklevel=level_of_user())


def warn_of_doubtful(doubtful: list[tuple[str, float, float]]) -> None:
    """Issues one warning for all doubtful derivatives, at the line that asked for them; no warning if there are none."""
    if doubtful:
        warnings.warn(DoubtfulDerivative(doubtful), stacklevel=level_of_user())


def level_of_user() -> int:
    """Returns the number of calls from the caller up to the user's code; 2, the next call, in a thread of JAX, which has no such code."""
    frame, level = sys._getframe(1), 1
    while is_between(frame):
        if frame.f_back is None:
            return 2
        frame, level = frame.f_back, level + 1
    return level


def is_between(frame: FrameType) -> bool:
    """Returns whether the code belongs to a package through which the user calls."""
    return frame.f_globals.get("__name__", "").split(".")[0] in BETWEEN


def raise_at_user(why: BaseException) -> None:
    """Raises the exception in the user's code as soon as that code continues, however a package in between handles it; does nothing under a debugger."""
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and is_between(frame):
        frame = frame.f_back
    if frame is None or sys.gettrace() is not None:
        return

    def going_on(frame: FrameType, event: str, argument: Any) -> None:
        sys.settrace(None)
        frame.f_trace = None
        raise why.with_traceback(None)

    frame.f_trace = going_on
    sys.settrace(lambda frame, event, argument: None)
