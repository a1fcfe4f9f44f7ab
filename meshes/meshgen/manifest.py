"""The manifest: the request, the resulting mesh and its quality."""

import json
import re
from pathlib import Path

from . import quality
from .geometry import MM
from .mesh import TetMesh
from .versions import versions


def build(request, mesh: TetMesh, volume_cad: float | None, paths: dict, notes: dict) -> dict:
    """The manifest of a mesh. Lengths in metres; volume_cad is null when the input was a mesh already.

    The request is kept unchanged, except for the folder of its output, because the files may be moved."""
    volume = quality.volume(mesh)
    return {
        "request": request.raw | {"output": Path(request.output).name},
        "cells": len(mesh.cells),
        "nodes": len(mesh.points),
        "facets": len(mesh.facets),
        "order": mesh.order,
        "h_m": (volume / len(mesh.cells)) ** (1 / 3),
        "regions": {name: {"dim": dim, "count": len(rows)} for name, (dim, rows) in mesh.regions.items()},
        "quality": quality.report(mesh),
        "volume_m3": volume,
        "volume_cad_m3": volume_cad,
        "volume_error": volume / volume_cad - 1 if volume_cad else None,
        "edge_error_m": 0.0,
        "paths": {name: in_metres(path) for name, path in paths.items()},
        "versions": versions(),
    } | notes


def in_metres(path: dict) -> dict:
    """A path of the CAD [mm] in metres."""
    return {
        "guides": [[x * MM for x in point] for point in path["guides"]],
        "pull_point": [x * MM for x in path["pull_point"]],
        "guide_radius": path["guide_radius"] * MM,
    }


def path_for(output: str) -> Path:
    """The manifest's file, next to the mesh."""
    return Path(re.sub(r"\.msh(\.gz)?$", ".json", output))


def save(manifest: dict, output: str) -> None:
    """Write the manifest next to the mesh."""
    path_for(output).write_text(json.dumps(manifest, indent=1) + "\n")
