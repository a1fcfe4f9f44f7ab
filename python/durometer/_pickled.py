"""What `pickle` calls to make scenes, runs and exceptions again in another process."""

from typing import Any

import numpy

from ._native import Run, Scene
from .report import Report


def scene(file: Any, text: str) -> Scene:
    """A scene of its text, whose files are found from the folder of `file`."""
    return Scene._pickled(file, text)


def run(kept: dict[str, Any]) -> Run:
    """A run of its results, for reading only as before."""
    for item in (kept, kept["fields"], kept["cell_fields"]):
        for array in item.values():
            if isinstance(array, numpy.ndarray):
                array.flags.writeable = False
    return Run._pickled(kept)


def portable(result: Any) -> Run | Report | dict[str, Any] | None:
    """The result of an exception, where it can be pickled."""
    return result if isinstance(result, (Run, Report, dict)) else None


def error(kind: type, fact: str, remedy: str, status: str, result: Any) -> Exception:
    """An exception of `durometer.errors`."""
    return kind(fact, remedy, status, result=result)
