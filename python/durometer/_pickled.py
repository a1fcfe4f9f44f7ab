"""Functions that `pickle` calls to rebuild scenes, runs and exceptions in another process."""

from typing import Any

import numpy

from ._native import Run, Scene
from .report import Report


def scene(file: Any, text: str) -> Scene:
    """Rebuilds a scene from its text; the paths of its files are relative to the folder of `file`."""
    return Scene._pickled(file, text)


def run(kept: dict[str, Any]) -> Run:
    """Rebuilds a run from its results, whose arrays are read-only as before."""
    for item in (kept, kept["fields"], kept["cell_fields"]):
        for array in item.values():
            if isinstance(array, numpy.ndarray):
                array.flags.writeable = False
    return Run._pickled(kept)


def portable(result: Any) -> Run | Report | dict[str, Any] | None:
    """Returns the result of an exception if it can be pickled, otherwise `None`."""
    return result if isinstance(result, (Run, Report, dict)) else None


def error(kind: type, fact: str, remedy: str, status: str, result: Any) -> Exception:
    """Rebuilds an exception of `durometer.errors`."""
    return kind(fact, remedy, status, result=result)
