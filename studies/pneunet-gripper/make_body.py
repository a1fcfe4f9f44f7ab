"""The body of this study: a finger with a row of air chambers, as a surface of two shells (STL).

    .venv/bin/python studies/pneunet-gripper/make_body.py
"""

from pathlib import Path

import gmsh

HERE = Path(__file__).parent
WIDTH, BASE, WALL, TOP = 16.0, 5.0, 2.0, 20.0  # mm: width, floor, walls, height of the chambers' roof
CHAMBERS, AIR, PITCH, START = 7, 6.0, 12.0, 8.0  # number of chambers, their length, their distance, the clamped end
LENGTH = START + CHAMBERS * PITCH + 4.0


def build() -> None:
    """Chambers on a base, joined by a channel, in the current gmsh model."""
    occ = gmsh.model.occ
    starts = [START + PITCH * k for k in range(CHAMBERS)]
    solid = [(3, occ.addBox(0, 0, 0, LENGTH, WIDTH, BASE + 5))]
    solid += [(3, occ.addBox(x - WALL, 0, 0, AIR + 2 * WALL, WIDTH, TOP)) for x in starts]
    air = [(3, occ.addBox(starts[0], WIDTH / 2 - 2, BASE, starts[-1] - starts[0], 4, 3))]
    air += [(3, occ.addBox(x, WALL, BASE, AIR, WIDTH - 2 * WALL, TOP - WALL - BASE)) for x in starts]
    body = occ.fuse(solid[:1], solid[1:])[0]
    hollow = occ.fuse(air[:1], air[1:])[0]
    occ.cut(body, hollow)
    occ.synchronize()


def main() -> None:
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    build()
    gmsh.option.setNumber("Mesh.MeshSizeMax", 5.0)
    gmsh.option.setNumber("Mesh.MeshSizeMin", 5.0)
    gmsh.option.setNumber("Mesh.Binary", 1)
    gmsh.model.mesh.generate(2)
    gmsh.write(str(HERE / "finger.stl"))
    gmsh.finalize()


if __name__ == "__main__":
    main()
