"""Result of a body's `geometry.py`, and functions that distinguish CAD faces.

The CAD is built in millimetres, because OpenCASCADE's tolerances are absolute (1e-7).
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import gmsh

MM = 1e-3  # metres per CAD unit
SNAP = 1e-5  # mm: two coordinates of the CAD closer than this are the same


@dataclass
class Geometry:
    """A body in the current gmsh model.

    volumes   volume tags
    regions   name -> (dim, entity tags); facet regions share no face
    paths     name -> {"guides": [[x, y, z]], "pull_point": [x, y, z], "guide_radius": r}, in mm
    features  grading feature -> list of face tags, or of points [x, y, z] in mm
    volume    enclosed volume in mm³, where the CAD kernel does not know it (surfaces without CAD)
    rebuild   builds the same model again for an edge length in mm, where clearing the mesh would destroy it (surfaces without CAD)
    unions    further facet regions: name -> names of facet regions
    dropped   faces that bound no solid, or that no facet is of, in words
    """

    volumes: list
    regions: dict
    paths: dict = field(default_factory=dict)
    features: dict = field(default_factory=dict)
    volume: float | None = None
    rebuild: Callable | None = None
    unions: dict = field(default_factory=dict)
    dropped: list = field(default_factory=list)

    def clear_mesh(self, length: float | None = None) -> None:
        """Restore the geometry without a mesh, for the given edge length [mm]."""
        if self.rebuild:
            self.rebuild(length)
        else:
            gmsh.model.mesh.clear()


def boundary_faces(volumes: list) -> list:
    """Tags of the outer faces of a set of volumes; faces between two volumes are left out."""
    pairs = gmsh.model.getBoundary([(3, v) for v in volumes], combined=True, oriented=False)
    return sorted(tag for _, tag in pairs)


def face_box(face: int) -> tuple:
    """Exact bounds (xmin, ymin, zmin, xmax, ymax, zmax) of a face [mm], without OpenCASCADE's margin."""
    return gmsh.model.occ.getBoundingBox(2, face)


def lies_in_plane(face: int, axis: int, value: float) -> bool:
    """Whether the whole face has coordinate `axis` equal to `value` [mm]."""
    box = face_box(face)
    return abs(box[axis] - value) < SNAP and abs(box[axis + 3] - value) < SNAP


def lies_between(face: int, axis: int, low: float, high: float) -> bool:
    """Whether the face stays within [low, high] along `axis` [mm]."""
    box = face_box(face)
    return box[axis] > low - SNAP and box[axis + 3] < high + SNAP


def sort_faces(volumes: list, rules: list, rest: str) -> dict:
    """Assign every outer face to the first rule (name, predicate) that accepts it, otherwise to `rest`."""
    regions = {name: (2, []) for name, _ in rules}
    regions[rest] = (2, [])
    for face in boundary_faces(volumes):
        name = next((name for name, wants in rules if wants(face)), rest)
        regions[name][1].append(face)
    return {name: region for name, region in regions.items() if region[1]}


def plane_rules(planes: dict) -> list:
    """Rules for `sort_faces` from name -> (axis, value in mm)."""
    return [(name, lambda face, at=at: lies_in_plane(face, *at)) for name, at in planes.items()]


def point_on(face: int) -> tuple:
    """A point of a face [mm]: the middle of its parameters, which lies on a face without holes."""
    low, high = gmsh.model.getParametrizationBounds(2, face)
    return tuple(gmsh.model.getValue(2, face, [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2]))
