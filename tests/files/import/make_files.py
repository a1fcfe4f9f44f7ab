"""Writes the same bar of 40 x 10 x 10 mm in every format that gmsh and meshio write, and variations of it: `make_files.py FOLDER`."""

import gzip
import sys
from pathlib import Path

import gmsh
import meshio
import numpy as np

FOLDER = Path(sys.argv[1])


def path(name: str) -> str:
    return str(FOLDER / name)


def by_gmsh() -> None:
    """Files that gmsh writes, with the groups `root` and `bar`."""
    gmsh.initialize([], False, False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 5)
    gmsh.model.occ.addBox(0, 0, 0, 40, 10, 10)
    gmsh.model.occ.synchronize()
    gmsh.write(path("cad.step"))
    gmsh.write(path("cad.brep"))
    root = next(tag for dim, tag in gmsh.model.getEntities(2) if gmsh.model.occ.getCenterOfMass(2, tag)[0] < 1e-6)
    gmsh.model.addPhysicalGroup(2, [root], name="root")
    gmsh.model.addPhysicalGroup(3, [1], name="bar")
    gmsh.model.mesh.generate(3)
    for name, version, binary in [("new", 4.1, 0), ("new-binary", 4.1, 1), ("old", 2.2, 0), ("old-binary", 2.2, 1), ("between", 4.0, 0)]:
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.write(path(f"{name}.msh"))
        if name.startswith("new"):
            gmsh.write(path(f"{name}.vtk"))
    gmsh.option.setNumber("Mesh.Binary", 0)
    for name in ["groups.unv", "groups.mesh", "groups.bdf"]:
        gmsh.write(path(name))
    gmsh.model.mesh.setOrder(2)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.write(path("quadratic.msh"))
    gmsh.finalize()


def by_meshio() -> None:
    """Files that meshio writes."""
    raw = meshio.read(path("new.msh"))
    points, cells = raw.points, raw.cells_dict["tetra"]
    bar = meshio.Mesh(points, {"tetra": cells})
    for name in ["plain.mesh", "plain.inp", "plain.bdf", "plain.vol", "plain.ele", "plain.su2", "plain.avs", "plain.f3grid"]:
        meshio.write(path(name), bar)
    meshio.write(path("plain.vtu"), bar, binary=True, compression="zlib")
    meshio.write(path("plain-text.vtu"), bar, binary=False)
    root = np.flatnonzero(points[:, 0] < 1e-6)
    half = np.flatnonzero(points[cells].mean(axis=1)[:, 0] < 20)
    meshio.write(path("sets.inp"), meshio.Mesh(points, {"tetra": cells}, point_sets={"root": root}, cell_sets={"half": [half]}))
    Path(path("xml.vtk")).write_bytes(Path(path("plain.vtu")).read_bytes())
    Path(path("packed.msh.gz")).write_bytes(gzip.compress(Path(path("new.msh")).read_bytes()))
    meshio.write(path("surface.stl"), meshio.Mesh(points, {"triangle": outer(cells)}), binary=True)
    orphans = np.vstack([points, [[99.0, 0, 0], [98, 0, 0]]])
    meshio.write(path("orphans.vtu"), meshio.Mesh(orphans, {"tetra": cells}))
    left, right = cells[half], np.delete(cells, half, axis=0)
    meshio.write(path("doubled.vtk"), meshio.Mesh(np.vstack([points, points]), {"tetra": np.vstack([left, right + len(points)])}), file_format="vtk42")
    units = {"metres": 1e-3, "inches": 1 / 25.4}
    for name, factor in units.items():
        meshio.write(path(f"{name}.vtu"), meshio.Mesh(points * factor, {"tetra": cells}))


def bricks() -> None:
    """Hexahedra, wedges and pyramids."""
    n = (8, 2, 2)
    x = np.array([[5.0 * i, 5 * j, 5 * k] for k in range(n[2] + 1) for j in range(n[1] + 1) for i in range(n[0] + 1)])
    at = lambda i, j, k: i + (n[0] + 1) * (j + (n[1] + 1) * k)  # noqa: E731
    square = ((0, 0), (1, 0), (1, 1), (0, 1))
    hexes = np.array([[at(i + a, j + b, k + c) for c in (0, 1) for a, b in square] for i in range(n[0]) for j in range(n[1]) for k in range(n[2])])
    meshio.write(path("bricks.vtk"), meshio.Mesh(x, {"hexahedron": hexes}), file_format="vtk42")
    meshio.write(path("bricks.inp"), meshio.Mesh(x, {"hexahedron": hexes}))
    wedges = np.vstack([hexes[:, [0, 1, 2, 4, 5, 6]], hexes[:, [0, 2, 3, 4, 6, 7]]])
    meshio.write(path("wedges.vtu"), meshio.Mesh(x, {"wedge": wedges}))
    apex = np.arange(len(hexes)) + len(x)
    sides = [(0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)]
    pyramids = np.vstack([np.column_stack([hexes[:, side], apex]) for side in sides])
    meshio.write(path("pyramids.vtu"), meshio.Mesh(np.vstack([x, x[hexes].mean(axis=1)]), {"pyramid": pyramids}))


def bad() -> None:
    """Files that must be refused."""
    good = Path(path("plain-text.vtu")).read_bytes()
    Path(path("bad-cut.vtu")).write_bytes(good[: len(good) // 2])
    Path(path("bad-utf16.inp")).write_text(Path(path("plain.inp")).read_text(), encoding="utf-16")
    Path(path("bad-empty.msh")).write_bytes(b"")
    raw = meshio.read(path("plain.vtu"))
    cells = raw.cells_dict["tetra"].copy()
    cells[0] = cells[0][[1, 0, 2, 3]]
    meshio.write(path("bad-inverted.vtk"), meshio.Mesh(raw.points, {"tetra": cells}), file_format="vtk42")
    Path(path("notes.txt")).write_text("This is no mesh.\n")


def outer(cells: np.ndarray) -> np.ndarray:
    """Faces that belong to one cell only, outward."""
    faces = cells[:, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]].reshape(-1, 3)
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return faces[first[count == 1]]


by_gmsh()
by_meshio()
bricks()
bad()
