"""Optional packages, which only some functions need."""

import importlib
from types import ModuleType

from .errors import MissingExtra


def extra(module: str, name: str) -> ModuleType:
    """Imports a module, or raises the exception that says how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError as missing:
        raise MissingExtra(f"{module} is not installed ({missing})", f'pip install "durometer[{name}]"') from missing
