"""The body of this study: bellows with rounded folds and closed ends, as CAD.

    .venv/bin/python studies/bellows/make_body.py
"""

import math
from pathlib import Path

import gmsh

HERE = Path(__file__).parent
CAP, FOLD, FOLDS = 4.0, 14.0, 3  # mm: thickness of the ends, height of a fold; number of folds
MEAN, DEPTH, WALL = 14.0, 2.5, 1.6  # mm: middle radius of the wall, amplitude of the folds, thickness
LENGTH = 2 * CAP + FOLD * FOLDS


def wall(offset: float) -> list:
    """Points (r, z) of the wave of the wall, moved along its normal by `offset` [mm]."""
    points = []
    for k in range(24 * FOLDS + 1):
        phase = 2 * math.pi * k / 24
        r, z = MEAN - DEPTH * math.cos(phase), CAP + FOLD * k / 24
        slope = DEPTH * math.sin(phase) * 2 * math.pi / FOLD
        norm = math.hypot(1.0, slope)
        points.append((r + offset / norm, z - offset * slope / norm))
    return points


def revolved(wave: list, low: float, high: float) -> tuple:
    """The solid inside a wave of the wall, continued to planes at the heights `low` and `high`."""
    occ = gmsh.model.occ
    (first, start), (last, end) = wave[0], wave[-1]
    ends = [(last, high)] * (high > end) + [(0.0, high), (0.0, low)] + [(first, low)] * (low < start)
    points = [occ.addPoint(r, 0.0, z) for r, z in wave]
    around = [points[-1], *(occ.addPoint(r, 0.0, z) for r, z in ends), points[0]]
    lines = [occ.addBSpline(points)] + [occ.addLine(a, b) for a, b in zip(around, around[1:])]
    section = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    solid = next(entity for entity in occ.revolve([(2, section)], 0, 0, 0, 0, 0, 1, 2 * math.pi) if entity[0] == 3)
    occ.remove([(2, section)], recursive=True)
    return solid


def main() -> None:
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    occ = gmsh.model.occ
    solid = revolved(wall(+WALL / 2), 0.0, LENGTH)
    air = revolved(wall(-WALL / 2), CAP, LENGTH - CAP)
    occ.cut([solid], [air])
    occ.synchronize()
    gmsh.write(str(HERE / "bellows.step"))
    gmsh.finalize()


if __name__ == "__main__":
    main()
