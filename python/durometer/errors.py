"""Exceptions: what is wrong (`fact`), what helps (`remedy`), and how it ended (`status`)."""

from typing import Any


class DurometerError(Exception):
    """Every exception of this package.

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


class InputError(DurometerError, ValueError):
    """Input that is refused before anything is computed; the program ends with exit code 2."""


class RunError(DurometerError, RuntimeError):
    """A run, a search or a study that is not complete; `result` has what was computed. The program ends with exit code 3."""


class MissingExtra(DurometerError, ImportError):
    """A package that this function needs is not installed; `remedy` is the command that installs it."""
