"""Packages that only some functions need."""

import importlib
from types import ModuleType

from .errors import MissingExtra


def extra(module: str, name: str) -> ModuleType:
    """The module, or the exception that says how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError as missing:
        raise MissingExtra(f"{module} is not installed ({missing})", f'pip install "durometer[{name}]"') from missing
