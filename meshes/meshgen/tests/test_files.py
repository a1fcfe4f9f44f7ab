"""The body `file`: CAD, surfaces and volume meshes, good and bad."""

from pathlib import Path

import gmsh
import meshio
import numpy as np

from .common import Case, read_msh

TETRA = np.array([[0, 1, 2, 3]])
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


class Files(Case):
    def take(self, file: str, unit: float = 1e-3, **request) -> dict:
        return self.made("file", {"path": self.path(file), "unit_m": unit}, **request)

    def reject(self, words: str, file: str, unit: float = 1e-3, **request) -> None:
        self.refused(2, words, "file", {"path": self.path(file), "unit_m": unit}, **request)

    def export(self, *names: str) -> None:
        """A box of 30 x 20 x 10 mm with a hole, as CAD or surface files."""
        gmsh.initialize([], False, False)
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 4)
        gmsh.model.occ.cut([(3, gmsh.model.occ.addBox(0, 0, 0, 30, 20, 10))], [(3, gmsh.model.occ.addCylinder(15, 10, 0, 0, 0, 10, 5))])
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(2)
        for name in names:
            gmsh.write(self.path(name))
        gmsh.finalize()

    def test_cad(self):
        self.export("part.step", "part.brep")
        volume = (30 * 20 * 10 - np.pi * 25 * 10) * 1e-9
        for name in ("part.step", "part.brep"):
            manifest = self.take(name, size={"length": 0.003}, order=2)
            self.covers_boundary(manifest)
            self.assertEqual(set(manifest["regions"]), {"body"} | {f"face_{i}" for i in range(1, 8)})
            self.assertAlmostEqual(manifest["volume_m3"] / volume, 1, delta=1e-3)
        self.assertAlmostEqual(self.take("part.brep", unit=1.0, size={"length": 3})["volume_cad_m3"] / volume, 1e9, delta=1e3)
        self.reject("states its own unit", "part.step", unit=1.0, size={"length": 3})
        self.reject("no size", "part.step")
        Path(self.path("cut.step")).write_text(Path(self.path("part.step")).read_text()[:2000])
        self.reject("cut.step", "cut.step", size={"length": 0.003})

    def test_surface(self):
        self.export("part.stl")
        for generator, error in (("gmsh", 0.01), ("cgal", 0.03)):
            for order in (1, 2):
                manifest = self.take("part.stl", size={"length": 0.003}, generator=generator, order=order)
                self.covers_boundary(manifest, "face_")
                self.assertEqual(manifest["regions"]["outer"]["count"], manifest["facets"])
                self.assertLess(abs(manifest["volume_error"]), error)
                self.assertEqual(manifest["order"], order)
        self.reject("no CAD behind", "part.stl", size={"length": 0.003, "levels": 1}, order=2)

    def test_volume_mesh(self):
        self.made("dumbbell", name="first.msh", size={"length": 0.004})
        again = self.take("first.msh", unit=1.0, name="second.msh")
        self.assertEqual(read_msh(self.path("first.msh"))["nodes"].shape, read_msh(self.path("second.msh"))["nodes"].shape)
        first = self.made("dumbbell", name="first.msh", size={"length": 0.004})
        self.assertEqual(again["regions"], first["regions"])
        quadratic = self.made("cylinder", name="curved.msh", size={"length": 0.006}, order=2)
        taken = self.take("curved.msh", unit=1.0, order=2)
        self.assertAlmostEqual(taken["volume_m3"] / quadratic["volume_m3"], 1, delta=1e-12)
        self.reject("cells of order 2", "curved.msh", order=1)

    def test_labels(self):
        path = self.path("two.vtk")
        points = np.vstack([CORNERS, [[1, 1, 1]], [[9, 9, 9]]])
        meshio.write(path, meshio.Mesh(points, {"tetra": [[0, 1, 2, 3], [1, 2, 3, 4]]}, cell_data={"medit:ref": [[1, 7]]}))
        manifest = self.take("two.vtk")
        self.assertEqual(manifest["regions"]["cells_7"], {"dim": 3, "count": 1})
        self.assertEqual(manifest["regions"]["boundary"], {"dim": 2, "count": 6})
        self.assertEqual(manifest["unused_nodes"], 1)
        self.assertAlmostEqual(manifest["volume_m3"], 0.5e-9)

    def test_bad_meshes(self):
        def store(name, points, **cells):
            meshio.write(self.path(name), meshio.Mesh(points, {kind: np.array(rows) for kind, rows in cells.items()}))

        cube = np.array([[x, y, z] for z in (0.0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
        store("mixed.vtk", np.vstack([cube, cube + 5]), hexahedron=[range(8)], tetra=[[8, 9, 10, 12]])
        self.reject("1 hexahedron, 1 tetra", "mixed.vtk")
        store("shell.vtk", CORNERS, triangle=[[0, 1, 2]])
        self.reject("no volume cells", "shell.vtk")
        store("flat.vtk", np.vstack([CORNERS, [[1, 1, 0]]]), tetra=[[0, 1, 2, 3], [0, 1, 4, 2]])
        self.reject("inverted or flat", "flat.vtk")
        store("crack.vtk", np.vstack([CORNERS, CORNERS + [1, 0, 0]]), tetra=[[0, 1, 2, 3], [4, 5, 6, 7]])
        self.reject("doubled nodes", "crack.vtk")
        store("good.vtk", CORNERS, tetra=TETRA)
        Path(self.path("cut.vtk")).write_bytes(Path(self.path("good.vtk")).read_bytes()[:200])
        self.reject("cannot read", "cut.vtk")
        self.reject("taken over", "good.vtk", size={"length": 0.1})
        self.reject("no file", "nowhere.vtk")
        Path(self.path("what.xyz")).write_text("hello")
        self.reject("unknown extension", "what.xyz")
