"""The body of this study: a round bladder with closed ends, as CAD.

    .venv/bin/python studies/wound-actuator/make_body.py
"""

from pathlib import Path

import gmsh

HERE = Path(__file__).parent
INNER, OUTER, LENGTH, CAP = 8.0, 10.0, 90.0, 5.0  # mm: radii, length along x with both ends, thickness of an end


def main() -> None:
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    occ = gmsh.model.occ
    solid = (3, occ.addCylinder(0, 0, 0, LENGTH, 0, 0, OUTER))
    air = (3, occ.addCylinder(CAP, 0, 0, LENGTH - 2 * CAP, 0, 0, INNER))
    occ.cut([solid], [air])
    occ.synchronize()
    gmsh.write(str(HERE / "bladder.step"))
    gmsh.finalize()


if __name__ == "__main__":
    main()
