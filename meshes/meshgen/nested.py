"""Uniform refinement: every cell is split into 8, with the new boundary nodes on the CAD."""

import gmsh
import numpy as np

from . import curved

POINT, LINE, TRIANGLE, TETRAHEDRON = 15, 8, 9, 11  # gmsh's second-order types
FIRST_ORDER = {POINT: 15, LINE: 1, TRIANGLE: 2, TETRAHEDRON: 4}
NODES = {POINT: 1, LINE: 3, TRIANGLE: 6, TETRAHEDRON: 10}
CHILDREN = {
    POINT: [(0,)],
    LINE: [(0, 2), (2, 1)],
    TRIANGLE: [(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)],
    TETRAHEDRON: [(0, 4, 6, 7), (4, 1, 5, 9), (6, 5, 2, 8), (7, 9, 8, 3)],
}
# The inner octahedron, cut along each of its three diagonals (between the middles of opposite edges).
DIAGONALS = [(4, 8), (5, 7), (6, 9)]
OCTAHEDRON = [
    [(4, 8, 9, 5), (4, 8, 7, 9), (4, 8, 6, 7), (4, 8, 5, 6)],
    [(5, 7, 6, 4), (5, 7, 8, 6), (5, 7, 9, 8), (5, 7, 4, 9)],
    [(6, 9, 4, 5), (6, 9, 7, 4), (6, 9, 8, 7), (6, 9, 5, 8)],
]


def refine(collect_cells, log) -> np.ndarray:
    """Refine the mesh of the current model once; returns the distances [m] from the CAD of the edges that `curved.untangle` has straightened.

    The mesh is converted to second order, folded cells are repaired, and its nodes become the
    corners of the children; nodes keep their CAD entity and parameters for the next level."""
    gmsh.model.mesh.setOrder(2)
    straightened = curved.untangle(collect_cells, log)
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    position = np.zeros((int(tags.max()) + 1, 3))
    position[tags.astype(int)] = xyz.reshape(-1, 3)
    entities = gmsh.model.getEntities()
    nodes = [gmsh.model.mesh.getNodes(*entity, returnParametricCoord=True) for entity in entities]
    elements = [gmsh.model.mesh.getElements(*entity) for entity in entities]
    gmsh.model.mesh.clear()
    for entity, (tags, xyz, parameters) in zip(entities, nodes):
        gmsh.model.mesh.addNodes(*entity, tags, xyz, parameters if entity[0] in (1, 2) else [])
    for (_, tag), (kinds, _, connectivity) in zip(entities, elements):
        for kind, flat in zip(kinds, connectivity):
            gmsh.model.mesh.addElementsByType(tag, FIRST_ORDER[kind], [], split(kind, flat.astype(int), position))
    return straightened


def split(kind: int, flat: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Corner nodes of the children of second-order elements, parent by parent, as a flat array."""
    pieces = np.array(CHILDREN[kind])
    parents = flat.reshape(-1, NODES[kind])
    children = parents[:, pieces]
    if kind == TETRAHEDRON:
        lengths = [np.linalg.norm(position[parents[:, a]] - position[parents[:, b]], axis=1) for a, b in DIAGONALS]
        shortest = np.argmin(np.round(lengths, 9), axis=0)
        inner = np.take_along_axis(parents, np.array(OCTAHEDRON)[shortest].reshape(-1, 16), axis=1)
        children = np.concatenate([children, inner.reshape(-1, 4, 4)], axis=1)
    return children.ravel()
