"""Mesh between the mesher and the file: nodes, tetrahedra, boundary triangles, regions. Metres, gmsh's node order."""

from dataclasses import dataclass, field

import numpy as np

from . import surface
from .errors import MesherFailed

# Outward faces of a positive tetrahedron: corners, then the nodes in the middle of their edges.
FACES = np.array([[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 9, 7], [1, 2, 3, 5, 8, 9], [0, 3, 2, 7, 8, 6]])
# Edges of a tetrahedron in the order of its mid-nodes 4..9.
EDGES = np.array([[0, 1], [1, 2], [2, 0], [3, 0], [3, 2], [3, 1]])
LOST = 0.25  # largest relative deviation of the volume of a mesh from that of its surface


@dataclass
class TetMesh:
    """points (n, 3) [m]; cells (N, 4 or 10); facets (M, 3 or 6), outward; regions name -> (dim, indices)."""

    points: np.ndarray
    cells: np.ndarray
    facets: np.ndarray
    regions: dict = field(default_factory=dict)

    @property
    def order(self) -> int:
        return 1 if self.cells.shape[1] == 4 else 2


def assemble(points, cells, cell_labels: dict, facet_labels: dict, exclusive: bool = True) -> TetMesh:
    """Make a clean mesh of raw mesher output.

    cell_labels   region -> boolean mask over cells
    facet_labels  region -> (k, 3) corner nodes of its triangles, in any orientation
    Drops unused nodes, makes cells positive and facets outward, rounds coordinates to 12 digits of the
    body's size, and ensures that the facet regions together form the boundary, each facet once (if exclusive).
    """
    used, inverse = np.unique(cells, return_inverse=True)
    cells = inverse.reshape(np.shape(cells))
    renumber = np.full(len(points), -1)
    renumber[used] = np.arange(len(used))
    points = rounded(points[used])
    cells = oriented(points, cells)
    facets = boundary(cells)
    regions = {name: (3, np.flatnonzero(mask)) for name, mask in cell_labels.items()}
    place = {key: i for i, key in enumerate(map(tuple, np.sort(facets[:, :3], axis=1).tolist()))}
    seen = np.zeros(len(facets), int)
    for name, corners in facet_labels.items():
        keys = map(tuple, np.sort(renumber[corners], axis=1).tolist())
        found = np.array(sorted(place.get(key, -1) for key in keys), int)
        if len(found) and found[0] < 0:
            raise MesherFailed(f"region {name} has {np.sum(found < 0)} triangles that are no boundary of the cells")
        seen[found] += 1
        regions[name] = (2, found)
    if exclusive and not np.all(seen == 1):
        raise MesherFailed(f"{np.sum(seen != 1)} of {len(seen)} boundary facets are not in exactly one facet region")
    return TetMesh(points, cells, facets, regions)


def check_volume(made: TetMesh, enclosed: float) -> None:
    """Refuse a mesh that has lost walls of its surface, which encloses this volume [m³]."""
    error = surface.volume(made.points, made.facets[:, :3]) / enclosed - 1
    if abs(error) > LOST:
        raise MesherFailed(f"the mesh misses the enclosed volume by {100 * error:.0f} %", "its cells are too coarse: use more cells or a smaller size")


def straight_second_order(mesh: TetMesh) -> TetMesh:
    """The mesh with a node in the middle of every edge."""
    edges = np.sort(mesh.cells[:, EDGES].reshape(-1, 2), axis=1)
    keys, place = np.unique(edges, axis=0, return_inverse=True)
    points = np.concatenate([mesh.points, rounded(mesh.points[keys].mean(axis=1))])
    cells = np.concatenate([mesh.cells, len(mesh.points) + place.reshape(-1, 6)], axis=1)
    facets = boundary(cells)
    row = {tuple(corners): i for i, corners in enumerate(np.sort(facets[:, :3], axis=1).tolist())}
    order = [row[tuple(corners)] for corners in np.sort(mesh.facets, axis=1).tolist()]
    return TetMesh(points, cells, facets[order], mesh.regions)


def rounded(points: np.ndarray) -> np.ndarray:
    """Coordinates rounded to 1e-12 of the body's size: files stay small, planes stay exact."""
    size = np.ptp(points, axis=0).max()
    return np.round(points, 12 - int(np.floor(np.log10(size)))) + 0.0


def oriented(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Cells of positive volume: all are reversed if all are negative; single inverted or flat cells are refused."""
    volumes = corner_volumes(points, cells)
    if np.all(volumes < 0):
        swap = [1, 0, 2, 3] if cells.shape[1] == 4 else [1, 0, 2, 3, 4, 6, 5, 9, 8, 7]
        return cells[:, swap]
    bad = np.flatnonzero(volumes <= 0)
    if len(bad):
        where = points[cells[bad[0], :4]].mean(axis=0)
        raise MesherFailed(
            f"{len(bad)} of {len(cells)} cells are inverted or flat; the first is cell {bad[0]} at {np.round(where, 6).tolist()} m",
            "try a slightly different size or seed, or repair the file",
        )
    return cells


def corner_volumes(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Signed volumes of the straight tetrahedra through the corners [m³]."""
    a, b, c, d = (points[cells[:, i]] for i in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6


def boundary(cells: np.ndarray) -> np.ndarray:
    """Faces that belong to one cell only, outward, in order of the cells."""
    nodes = 3 if cells.shape[1] == 4 else 6
    faces = cells[:, FACES[:, :nodes]].reshape(-1, nodes)
    key = np.sort(faces[:, :3], axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    if count.max() > 2:
        raise MesherFailed(f"{np.sum(count > 2)} faces belong to more than two cells")
    return faces[np.sort(first[count == 1])]
