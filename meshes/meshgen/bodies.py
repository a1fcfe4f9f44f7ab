"""The parametric bodies: folders next to `meshgen` with a `body.toml` and a `geometry.py`."""

import importlib
import tomllib
from functools import cache
from pathlib import Path

from .errors import BadRequest

HOME = Path(__file__).absolute().parent.parent


@cache
def declaration(body: str) -> dict:
    """The parsed `body.toml` of a body."""
    with open(HOME / body / "body.toml", "rb") as file:
        return tomllib.load(file)


def names() -> list:
    """Names of all parametric bodies."""
    return sorted(path.parent.name for path in HOME.glob("*/body.toml"))


def is_length(body: str, parameter: str) -> bool:
    """Whether a parameter is a length (its default carries a unit) and not a plain number."""
    return declaration(body)["parameters"][parameter]["default"].endswith("m")


def build(body: str, parameters: dict):
    """Build a body in the current gmsh model from parameters in SI units. Returns its Geometry, in mm."""
    in_mm = {name: value * 1e3 if is_length(body, name) else value for name, value in parameters.items()}
    try:
        module = importlib.import_module(f"{body}.geometry")
    except (ImportError, SyntaxError) as error:
        raise BadRequest(f"{body}/geometry.py cannot be loaded: {error}", "correct it, or install what it imports in the Python of the mesher") from error
    geometry = module.build(in_mm)
    unknown = set(geometry.regions) - set(declaration(body)["regions"])
    assert not unknown, f"{body}/body.toml does not declare the regions {sorted(unknown)}"
    return geometry


def check_parameters(body: str, given: dict) -> dict:
    """Check that the parameters are complete, known and positive numbers; returns them as floats."""
    known = declaration(body)["parameters"]
    missing = [name for name in known if name not in given]
    if missing:
        raise BadRequest(f"{body}: missing parameters {', '.join(missing)}", "a request carries every parameter, in SI units")
    values = {}
    for name, value in given.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < float("inf"):
            raise BadRequest(f"{body}: parameter {name} = {value!r} is not a number", "lengths are plain numbers in metres")
        if value < 0 or (value == 0 and not known[name].get("zero", False)):
            raise BadRequest(f"{body}: parameter {name} = {value:g} must be positive", "change the parameters of the body")
        if not is_length(body, name) and value != int(value):
            raise BadRequest(f"{body}: parameter {name} = {value:g} must be a whole number", "it counts something")
        values[name] = float(value)
    return values
