"""Second-order meshes whose mid-nodes lie on the CAD: make sure that no curved cell is folded."""

import gmsh
import numpy as np

from .errors import MesherFailed
from .mesh import EDGES
from .quality import relative_jacobian

SMALLEST = 0.1  # smallest accepted det J over that of the straight cell


def untangle(collect_cells, log) -> dict:
    """Repair cells whose Jacobian is not safely positive; returns what the manifest should say about it.

    First gmsh's high-order optimiser, then, for edges of cells that are still bad, half the way back to
    straight until they are good: such a mid-node leaves the CAD and is counted in the manifest."""
    if len(bad_cells(collect_cells)):
        log(f"{len(bad_cells(collect_cells))} curved cells are folded: optimising")
        gmsh.option.setNumber("Mesh.HighOrderThresholdMin", SMALLEST)
        gmsh.model.mesh.optimize("HighOrder")
    moved = set()
    for _ in range(8):
        bad = bad_cells(collect_cells)
        if not len(bad):
            return {"straightened_edges": len(moved)}
        moved |= halve(bad)
    raise MesherFailed("curved cells stay folded even with straight edges", "use a smaller length")


def bad_cells(collect_cells) -> np.ndarray:
    """Node tags of the cells whose Jacobian falls below the smallest accepted one."""
    points, cells = collect_cells()
    tags = np.sort(gmsh.model.mesh.getNodes()[0].astype(int))
    return tags[cells[relative_jacobian(points, cells) < SMALLEST]]


def halve(cells: np.ndarray) -> set:
    """Move the mid-nodes of some cells half the way to the middle of their edge; returns their tags."""
    ends = {int(cell[4 + i]): cell[EDGES[i]] for cell in cells for i in range(6)}
    for node, (a, b) in ends.items():
        xyz, a, b = (gmsh.model.mesh.getNode(int(tag))[0] for tag in (node, a, b))
        gmsh.model.mesh.setNode(node, (xyz + (a + b) / 2) / 2, [])
    return set(ends)
