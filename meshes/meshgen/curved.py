"""Second-order meshes whose mid-nodes lie on the CAD: ensures that no curved cell is folded."""

import gmsh
import numpy as np

from .errors import MesherFailed
from .geometry import MM, SNAP
from .mesh import EDGES
from .quality import relative_jacobian

SMALLEST = 0.1  # smallest accepted det J relative to the straight cell
ROUNDS = 12


def untangle(collect_cells, log) -> np.ndarray:
    """Repair cells whose Jacobian is not safely positive; returns the distances [m] by which edges had to be moved off the CAD.

    Mid-nodes inside the body follow those on the boundary: a few rounds of averaging of their offset
    (distance from the middle of the edge) over the bad cells and their neighbours. The edges of cells that
    are still bad are then straightened by half repeatedly, on the boundary as well."""
    points, cells = collect_cells()
    bad = relative_jacobian(points, cells) < SMALLEST
    if not bad.any():
        return np.zeros(0)
    before = points.copy()
    ends = np.zeros((len(points), 2), int)
    ends[cells[:, 4:]] = cells[:, EDGES]
    mids = np.unique(cells[:, 4:])
    straight = points[ends[mids]].mean(axis=1)
    free = np.isin(mids, inner_nodes())
    neighbours = np.searchsorted(mids, cells[:, 4:])
    total = int(bad.sum())
    for attempt in range(2 * ROUNDS):
        bad = relative_jacobian(points, cells) < SMALLEST
        if not bad.any():
            break
        bulge = points[mids] - straight
        rows = np.unique(neighbours[bad])
        if attempt < ROUNDS:
            around = neighbours[np.isin(neighbours, rows).any(axis=1)]
            mean, weight = np.zeros_like(bulge), np.zeros(len(mids))
            np.add.at(mean, around, bulge[around].mean(axis=1, keepdims=True))
            np.add.at(weight, around, 1)
            rows = np.unique(around)
            rows = rows[free[rows]]
            bulge[rows] = mean[rows] / weight[rows, None]
        else:
            bulge[rows] /= 2
        points[mids[rows]] = straight[rows] + bulge[rows]
    else:
        raise MesherFailed("curved cells stay folded even with straight edges", "use a smaller length")
    moved = np.flatnonzero(np.any(points != before, axis=1))
    tags = np.sort(gmsh.model.mesh.getNodes()[0])
    for row in moved:
        gmsh.model.mesh.setNode(int(tags[row]), points[row] / MM, [])
    off = np.linalg.norm((points - before)[np.setdiff1d(moved, mids[free])], axis=1)
    off = off[off > SNAP * MM]
    log(f"repaired {total} folded curved cells; {len(off)} edges left the CAD")
    return off


def inner_nodes() -> np.ndarray:
    """Rows of the nodes inside the volumes, in the order of `collect_cells`."""
    tags = np.sort(gmsh.model.mesh.getNodes()[0])
    inside = np.concatenate([gmsh.model.mesh.getNodes(3, tag)[0] for _, tag in gmsh.model.getEntities(3)])
    return np.searchsorted(tags, inside)
