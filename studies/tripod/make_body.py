"""The body of this study: a platform on three legs, as an Abaqus input file with sets.

    .venv/bin/python studies/tripod/make_body.py
"""

import math
from pathlib import Path

import gmsh
import numpy as np

HERE = Path(__file__).parent
PLATFORM, LEG, HORN = 16.0, 58.0, 66.0  # mm: radius of the platform, ends of a leg and of its clamped end
WIDTH, THICK = 14.0, 5.0  # mm: section of a leg


def build() -> None:
    """Three legs and a platform in the current gmsh model; the clamped ends are cells of their own."""
    occ = gmsh.model.occ
    middle = [(3, occ.addCylinder(0, 0, 0, 0, 0, THICK, PLATFORM))]
    legs = [(3, occ.addBox(0, -WIDTH / 2, 0, LEG, WIDTH, THICK)) for _ in range(3)]
    horns = [(3, occ.addBox(LEG, -WIDTH / 2, 0, HORN - LEG, WIDTH, THICK)) for _ in range(3)]
    for k, parts in enumerate(zip(legs, horns)):
        occ.rotate(list(parts), 0, 0, 0, 0, 0, 1, 2 * math.pi * k / 3)
    body = occ.fuse(middle, legs)[0]
    occ.fragment(body, horns)
    occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMin", 4.0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 4.0)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    gmsh.model.mesh.optimize("HighOrder")


def mesh() -> tuple:
    """Points and cells of the current model, in the order of Abaqus."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    row = np.zeros(int(tags.max()) + 1, int)
    row[tags] = np.arange(len(tags))
    _, conn = gmsh.model.mesh.getElementsByType(11)
    cells = row[conn.reshape(-1, 10)[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]]]  # gmsh swaps the last two mid-nodes
    used, cells = np.unique(cells, return_inverse=True)
    return coordinates.reshape(-1, 3)[used], cells.reshape(-1, 10)


def sets(points: np.ndarray) -> dict:
    """Node sets: the clamped ends of the legs and the upper side of the platform."""
    found = {}
    for k in range(3):
        along = points[:, 0] * math.cos(2 * math.pi * k / 3) + points[:, 1] * math.sin(2 * math.pi * k / 3)
        found[f"HORN_{k + 1}"] = np.flatnonzero(along > LEG - 1e-6)
    inside = np.hypot(points[:, 0], points[:, 1]) < PLATFORM + 1e-6
    found["PLATFORM"] = np.flatnonzero(inside & (points[:, 2] > THICK - 1e-6))
    return found


def listing(title: str, rows: np.ndarray) -> str:
    """A node set, sixteen numbers a line."""
    lines = [", ".join(map(str, rows[k : k + 16] + 1)) for k in range(0, len(rows), 16)]
    return "\n".join([f"*NSET, NSET={title}", *lines, ""])


def main() -> None:
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    build()
    points, cells = mesh()
    gmsh.finalize()
    text = "*HEADING\nTripod, mm\n*NODE\n"
    text += "".join(f"{k}, {x:.6g}, {y:.6g}, {z:.6g}\n" for k, (x, y, z) in enumerate(points + 0.0, 1))
    text += "*ELEMENT, TYPE=C3D10, ELSET=RUBBER\n"
    text += "".join(f"{k}, " + ", ".join(map(str, cell + 1)) + "\n" for k, cell in enumerate(cells, 1))
    text += "".join(listing(name, rows) for name, rows in sets(points).items())
    (HERE / "tripod.inp").write_text(text)
    print(f"tripod.inp: {len(cells)} cells, {len(points)} nodes, {len(text) // 1000} kB")


if __name__ == "__main__":
    main()
