"""The request: the body, the size of its cells, the generator and the output. Lengths in metres."""

import contextlib
import difflib
import json
from dataclasses import dataclass, field, replace

import numpy as np

from . import bodies
from .errors import BadRequest

GENERATORS = ("gmsh", "cgal")
PLACES = ("feature", "points", "box")  # of grading
CGAL_LENGTHS = ("facet_size", "facet_approximation", "cell_size")
CGAL_NUMBERS = ("facet_angle", "cell_ratio") + CGAL_LENGTHS
CGAL_SWITCHES = ("odt", "lloyd", "perturb", "exude")


@dataclass
class Request:
    """A validated request. Exactly one of `length` [m] and `cells` is set, unless CGAL's criteria determine the size."""

    body: str
    parameters: dict
    output: str
    generator: str = "gmsh"
    length: float | None = None
    cells: int | None = None
    tolerance: float = 0.02
    levels: int = 0
    grading: list = field(default_factory=list)
    order: int = 1
    seed: int = 0
    optimise: bool = True
    cgal: dict = field(default_factory=dict)
    size_field: dict = field(default_factory=dict)
    raw: dict = field(default_factory=dict)

    def is_surface(self) -> bool:
        """Whether the body is the inside of a surface file."""
        return self.body == "file" and self.parameters["kind"] == "surface"

    def linear(self) -> "Request":
        """The same request for cells of order 1."""
        return replace(self, order=1)


def conversion(text: str) -> dict | None:
    """The path, format and output of a request to convert a mesh; None for any other request."""
    with contextlib.suppress(json.JSONDecodeError):
        raw = json.loads(text)
        if isinstance(raw, dict) and isinstance(asked := raw.get("convert"), dict):
            known_keys("convert", asked, ["path", "format", "output"])
            return {key: str(asked.get(key)) for key in ("path", "format", "output")}
    return None


def read(text: str) -> Request:
    """Parse and validate a request; refuses unknown keys with the nearest known one."""
    try:
        raw = json.loads(text)
    except json.JSONDecodeError as error:
        raise BadRequest(f"the request is not JSON: {error}", "send one JSON object on stdin") from None
    top = ["body", "version", "parameters", "generator", "size", "grading", "order", "seed", "optimise", "cgal", "field", "output"]
    known_keys("request", raw, top)
    body = choice("body", raw.get("body"), bodies.names() + ["file"])
    parameters = raw.get("parameters", {})
    if body == "file":
        parameters = file_parameters(parameters)
    else:
        known_keys(f"parameters of {body}", parameters, list(bodies.declaration(body)["parameters"]))
        parameters = bodies.check_parameters(body, parameters)
        version = bodies.declaration(body)["version"]
        if raw.get("version", version) != version:
            raise BadRequest(f"{body} has version {version}, the request wants {raw['version']!r}", f"use version {version}")
    output = raw.get("output")
    if not isinstance(output, str) or not output.endswith((".msh", ".msh.gz")):
        raise BadRequest(f"output = {output!r} must end in .msh or .msh.gz", "name the mesh file to write")
    request = Request(body, parameters, output, raw=raw)
    request.generator = choice("generator", raw.get("generator", "gmsh"), GENERATORS)
    request.order = choice("order", raw.get("order", 1), (1, 2))
    request.seed = integer("seed", raw.get("seed", 0))
    request.optimise = switch("optimise", raw.get("optimise", True))
    request.grading = [grading(entry) for entry in raw.get("grading", [])]
    request.cgal = cgal_criteria(raw.get("cgal", {}))
    request.size_field = size_field(raw.get("field", {}))
    read_size(request, raw.get("size", {}))
    check_combination(request)
    return request


def read_size(request: Request, size: dict) -> None:
    """`size`: {"length": m} or {"cells": N, "tolerance": 0.02}, both with optional "levels"."""
    known_keys("size", size, ["length", "cells", "tolerance", "levels"])
    if "length" in size and "cells" in size:
        raise BadRequest("size has both length and cells", "keep one of them")
    if "length" in size:
        request.length = positive("size.length", size["length"])
    if "cells" in size:
        request.cells = integer("size.cells", size["cells"], at_least=1)
    request.tolerance = positive("size.tolerance", size.get("tolerance", 0.02))
    request.levels = integer("size.levels", size.get("levels", 0))


def check_combination(request: Request) -> None:
    """Refuse options that the chosen generator does not have."""
    sized = request.length or request.cells
    if request.generator == "cgal":
        if not sized and not all(name in request.cgal for name in CGAL_LENGTHS):
            raise BadRequest("no size", f"give size.length, size.cells, or all of cgal's {', '.join(CGAL_LENGTHS)}")
        if request.cells and {"facet_size", "cell_size"} <= request.cgal.keys():
            raise BadRequest("cgal's facet_size and cell_size leave nothing that cells could change", "drop one of them, or cells")
        if (request.order == 2 and not request.is_surface()) or request.levels or request.grading or request.size_field:
            raise BadRequest("cgal makes uniform meshes only, and of CAD only order 1", "drop order, levels, grading and size field, or use gmsh")
    elif request.cgal:
        raise BadRequest("cgal criteria given, but the generator is gmsh", 'set generator = "cgal" or drop them')
    elif not sized:
        raise BadRequest("no size", "give size.length or size.cells")


def file_parameters(given: dict) -> dict:
    """Parameters of the body `file`: the path and its unit [m]."""
    known_keys("parameters of file", given, ["path", "unit_m", "kind", "format"])
    for key, hint in (("path", "name the CAD or surface file"), ("format", "give the name of the format, such as step or stl")):
        if not isinstance(given.get(key), str):
            raise BadRequest(f"file: parameter {key} is missing", hint)
    choice("kind", given.get("kind"), ("cad", "surface"))
    if "unit_m" not in given:
        raise BadRequest("file: parameter unit_m is missing", "say what one unit of the file is in metres, e.g. 0.001 for mm")
    return given | {"unit_m": positive("unit_m", given["unit_m"])}


def grading(entry: dict) -> dict:
    """One grading entry: within `distance` [m] of a place the edge length is `length` [m].

    The place is a `feature` of the body, `points` [m], or a `box` of two corners [m]."""
    known_keys("grading", entry, [*PLACES, "length", "distance"])
    places = [key for key in PLACES if key in entry]
    if len(places) != 1:
        raise BadRequest("grading needs one place", f"give one of {', '.join(PLACES)}")
    place = entry[places[0]]
    if places == ["feature"] and not isinstance(place, str):
        raise BadRequest("grading needs the name of a feature", "name one of the body's features")
    if places != ["feature"]:
        place = coordinates(f"grading.{places[0]}", place)
    if places == ["box"] and (len(place) != 2 or np.any(place[0] > place[1])):
        raise BadRequest("the box of grading needs its lower and its upper corner", "give two corners, the lower one first")
    return {
        places[0]: place,
        "length": positive("grading.length", entry.get("length")),
        "distance": positive("grading.distance", entry.get("distance")),
    }


def coordinates(name: str, given: list) -> np.ndarray:
    """Points as an array (n, 3), n > 0."""
    try:
        points = np.asarray(given, float)
    except (ValueError, TypeError):
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points) or not np.all(np.isfinite(points)):
        raise BadRequest(f"{name} is no list of points", "give three coordinates of each in metres")
    return points


def size_field(given: dict) -> dict:
    """Multiples of the edge length at the points [m] of a mesh of tetrahedra, linear in each: arrays `points`, `cells`, `sizes`."""
    known_keys("field", given, ["points", "cells", "sizes"])
    if not given:
        return {}
    try:
        points = np.asarray(given["points"], float).reshape(-1, 3)
        cells = np.asarray(given["cells"], int).reshape(-1, 4)
        sizes = np.asarray(given["sizes"], float)
    except (KeyError, ValueError, TypeError) as error:
        raise BadRequest(f"the size field is not complete: {error!r}", "give points, cells and sizes") from None
    if len(sizes) != len(points) or not len(cells) or cells.min() < 0 or cells.max() >= len(points):
        raise BadRequest(
            f"the size field has {len(points)} points, {len(sizes)} sizes and cells that do not fit", "give one size for each point"
        )
    if not np.all(np.isfinite(sizes) & (sizes > 0)):
        raise BadRequest("a size of the size field is not positive", "sizes are multiples of the edge length")
    return {"points": points, "cells": cells, "sizes": sizes}


def cgal_criteria(given: dict) -> dict:
    """Mesh_3 criteria and optimiser switches; lengths in metres, facet_angle in degrees."""
    known_keys("cgal", given, list(CGAL_NUMBERS + CGAL_SWITCHES))
    criteria = {name: positive(f"cgal.{name}", given[name]) for name in CGAL_NUMBERS if name in given}
    if criteria.get("facet_angle", 0) > 30:
        raise BadRequest("cgal.facet_angle must not exceed 30 degrees: refinement may not end", "use 30 or less")
    if criteria.get("cell_ratio", 3) <= 2:
        raise BadRequest("cgal.cell_ratio must exceed 2: refinement may not end", "use 3 or more")
    return criteria | {name: switch(f"cgal.{name}", given[name]) for name in CGAL_SWITCHES if name in given}


def known_keys(where: str, given, known: list) -> None:
    """Refuse anything that is not an object with known keys."""
    if not isinstance(given, dict):
        raise BadRequest(f"{where} must be an object, not {given!r}", "see the keys: " + ", ".join(known))
    for key in given:
        if key not in known:
            near = difflib.get_close_matches(key, known, 1, 0.5)
            hint = f"did you mean {near[0]}?" if near else "known: " + ", ".join(known)
            raise BadRequest(f"{where}: unknown key {key}", hint)


def choice(name: str, value, options):
    if isinstance(value, bool) or value not in options:
        near = difflib.get_close_matches(str(value), [str(o) for o in options], 1, 0.5)
        known = "one of " + ", ".join(map(str, options))
        raise BadRequest(f"{name} = {value!r} is unknown", f"did you mean {near[0]}?" if near else known)
    return value


def positive(name: str, value) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value < float("inf"):
        raise BadRequest(f"{name} = {value!r} must be a positive number", "lengths are in metres")
    return float(value)


def integer(name: str, value, at_least: int = 0) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < at_least:
        raise BadRequest(f"{name} = {value!r} must be a whole number of at least {at_least}", "")
    return value


def switch(name: str, value) -> bool:
    if not isinstance(value, bool):
        raise BadRequest(f"{name} = {value!r} must be true or false", "")
    return value
