"""The body of this study: a tapered trunk of discs on a core, as CAD, and the guides of its eight cables.

    .venv/bin/python studies/trunk/make_body.py
"""

import math
from pathlib import Path

import gmsh

HERE = Path(__file__).parent
LENGTH, BASE, PITCH, DISC = 180.0, 15.0, 15.0, 7.0  # mm: trunk, base, distance of the discs, their thickness
DISCS = 11


def outer(z: float) -> float:
    """Radius of a disc at height z [mm]."""
    return 20.0 - 10.0 * z / LENGTH


def profile() -> list:
    """Half of the section through the axis, as points (r, z) [mm]."""
    points = [(0.0, 0.0), (outer(0.0), 0.0), (outer(BASE), BASE)]
    for k in range(DISCS):
        top = BASE + PITCH * (k + 1)
        bottom = top - DISC
        below = top - PITCH
        points += [(0.5 * outer(below), below), (0.5 * outer(bottom), bottom), (outer(bottom), bottom), (outer(top), top)]
    return points + [(0.0, LENGTH)]


def guides(angle: float, discs: int) -> list:
    """Guides of a cable in the middle of the first discs, at three quarters of their radius [mm]."""
    heights = [BASE + PITCH * (k + 1) - DISC / 2 for k in range(discs)]
    return [[0.75 * outer(z) * math.cos(angle), 0.75 * outer(z) * math.sin(angle), z] for z in heights]


def main() -> None:
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    occ = gmsh.model.occ
    points = [occ.addPoint(r, 0.0, z) for r, z in profile()]
    lines = [occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1])]
    section = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    occ.revolve([(2, section)], 0, 0, 0, 0, 0, 1, 2 * math.pi)
    occ.remove([(2, section)], recursive=True)
    occ.synchronize()
    gmsh.write(str(HERE / "trunk.step"))
    gmsh.finalize()


if __name__ == "__main__":
    main()
