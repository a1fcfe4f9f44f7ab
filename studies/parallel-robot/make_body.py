"""The body of this study: four bent legs between a base and a platform, as a mesh of quadratic tetrahedra (VTU).

    .venv/bin/python studies/parallel-robot/make_body.py
"""

import math
from pathlib import Path

import gmsh
import meshio
import numpy as np

HERE = Path(__file__).parent
BASE, ELBOW, PLATFORM = (10.0, 4.0), (55.0, 30.0), (8.0, 62.0)  # mm: distance from the axis and height of the ends of a leg
WIDTH, THICK = 10.0, 6.0  # mm: section of a leg


def bar(start: tuple, end: tuple) -> tuple:
    """A straight piece of a leg in the plane y = 0, from point to point (x, z)."""
    occ = gmsh.model.occ
    length = math.dist(start, end)
    box = (3, occ.addBox(0, -WIDTH / 2, -THICK / 2, length, WIDTH, THICK))
    occ.rotate([box], 0, 0, 0, 0, 1, 0, -math.atan2(end[1] - start[1], end[0] - start[0]))
    occ.translate([box], start[0], 0, start[1])
    return box


def leg() -> list:
    """One leg to +x with its elbow."""
    occ = gmsh.model.occ
    elbow = (3, occ.addCylinder(ELBOW[0], -WIDTH / 2, ELBOW[1], 0, WIDTH, 0, THICK))
    return [bar(BASE, ELBOW), elbow, bar(ELBOW, PLATFORM)]


def main() -> None:
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    occ = gmsh.model.occ
    parts = [(3, occ.addCylinder(0, 0, 0, 0, 0, 8, 15)), (3, occ.addCylinder(0, 0, 58, 0, 0, 8, 12))]
    for k in range(4):
        pieces = leg()
        occ.rotate(pieces, 0, 0, 0, 0, 0, 1, k * math.pi / 2)
        parts += pieces
    occ.fuse(parts[:1], parts[1:])
    occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMin", 4.5)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 4.5)
    gmsh.option.setNumber("Mesh.HighOrderOptimize", 2)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    gmsh.model.mesh.optimize("HighOrder")
    write(HERE / "parallel-robot.vtu")
    gmsh.finalize()


def write(path: Path) -> None:
    """Write the quadratic tetrahedra of the current model."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    row = np.zeros(int(tags.max()) + 1, int)
    _, conn = gmsh.model.mesh.getElementsByType(11)
    cells = conn.reshape(-1, 10)[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]]  # gmsh swaps the last two mid-nodes
    used = np.unique(cells)
    row[used] = np.arange(len(used))
    row_of = {int(tag): k for k, tag in enumerate(tags)}
    points = coordinates.reshape(-1, 3)[[row_of[int(tag)] for tag in used]]
    meshio.write(path, meshio.Mesh(np.round(points, 6), [("tetra10", row[cells])]))
    print(f"{path.name}: {len(cells)} cells, {len(used)} nodes")


if __name__ == "__main__":
    main()
