"""Simulation of soft robots with error bars: scenes, studies, fits and calibrations, and the program `durometer`."""

import os
import signal
import sys
import threading
from collections.abc import Sequence

from . import _native
from ._version import VERSION
from .errors import DoubtfulDerivative, DurometerError, InputError, MissingExtra, OutOfDomain, RunError

if _native.__version__ != VERSION:
    raise ImportError(
        f"durometer {VERSION} has found the library of version {_native.__version__}; "
        "install it again: pip install --force-reinstall durometer"
    )
# The program starts itself and the mesher with this interpreter
if sys.executable:
    _native.set_python(sys.executable)

from ._native import (
    Calibration,
    Fit,
    Invariants,
    Observation,
    Run,
    Scene,
    Sensitivities,
    Study,
    Twin,
    check_law,
    register_law,
)
from .curve import Curve
from .law import Law, Parameter
from .report import Report

__version__ = VERSION
__all__ = [
    "Calibration",
    "Curve",
    "DoubtfulDerivative",
    "DurometerError",
    "Fit",
    "InputError",
    "Invariants",
    "Law",
    "MissingExtra",
    "Observation",
    "OutOfDomain",
    "Parameter",
    "Report",
    "Run",
    "RunError",
    "Scene",
    "Sensitivities",
    "Study",
    "Twin",
    "check_law",
    "main",
    "register_law",
]


def main(arguments: Sequence[str | os.PathLike[str]] | None = None) -> int:
    """Runs the command line with these arguments, by default those of the process, and returns its exit code: 0 done, 2 bad input, 3 not complete.

    Exceptions of a law in Python are propagated. Ctrl-C in a notebook stops the command, which keeps what is finished, and is raised as
    KeyboardInterrupt.
    """
    if isinstance(arguments, str):
        raise InputError("the arguments are one text", f"give a list, such as {arguments.split()}")
    given = [os.fspath(argument) for argument in (sys.argv[1:] if arguments is None else arguments)]
    in_session = threading.current_thread() is threading.main_thread() and callable(signal.getsignal(signal.SIGINT))
    return _native.main_in_session(given) if in_session else _native.main(given, False)
