"""The body `file`: CAD and surfaces, good and bad."""

import gzip
from pathlib import Path

import gmsh
import meshio
import numpy as np

from .common import Case, read_msh

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


class Files(Case):
    def take(self, file: str, unit: float = 1e-3, **request) -> dict:
        return self.made("file", self.parameters(file, unit), **request)

    def reject(self, words: str, file: str, unit: float = 1e-3, **request) -> None:
        self.refused(2, words, "file", self.parameters(file, unit), **request)

    def export(self, *names: str, radius: float = 5) -> None:
        """A box of 30 x 20 x 10 mm with a hole of this radius [mm], as CAD or surface files."""
        gmsh.initialize([], False, False)
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 4)
        gmsh.model.occ.cut([(3, gmsh.model.occ.addBox(0, 0, 0, 30, 20, 10))], [(3, gmsh.model.occ.addCylinder(15, 10, 0, 0, 0, 10, radius))])
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
        self.reject("--unit mm", "part.step", unit=1.0, size={"length": 3})
        self.reject("no size", "part.step")
        Path(self.path("cut.step")).write_text(Path(self.path("part.step")).read_text()[:2000])
        self.reject("cut.step", "cut.step", size={"length": 0.003})

    def test_levels_of_a_hole(self):
        """The error of the volume falls by 4 for each level where no node leaves the CAD; where some do, the manifest counts them."""
        for radius, leaves in ((5, False), (2, True)):
            self.export("part.step", radius=radius)
            errors = []
            for levels in (0, 1, 2):
                manifest = self.take("part.step", size={"length": 0.006, "levels": levels})
                self.assertEqual(manifest["straightened_edges"] > 0, leaves and levels > 0)
                errors.append(abs(manifest["volume_m3"] / manifest["volume_cad_m3"] - 1))
            for coarse, fine in zip(errors, errors[1:]):
                self.assertEqual(abs(coarse / fine - 4) < 0.4, not leaves)

    def store(self, name: str, *bodies: tuple) -> None:
        """Boxes (x, y, z, dx, dy, dz), balls (x, y, z, radius) and rectangles (x, y, z, dx, dy), as they are, in a CAD file."""
        gmsh.initialize([], False, False)
        gmsh.option.setNumber("General.Terminal", 0)
        for body in bodies:
            {6: gmsh.model.occ.addBox, 5: gmsh.model.occ.addRectangle, 4: gmsh.model.occ.addSphere}[len(body)](*body)
        gmsh.model.occ.synchronize()
        gmsh.write(self.path(name))
        gmsh.finalize()

    def concentric(self, name: str, combine, radius: float) -> None:
        """A ball with a radius of 10 mm, combined with a smaller one in it, in a CAD file."""
        gmsh.initialize([], False, False)
        gmsh.option.setNumber("General.Terminal", 0)
        combine(*([(3, gmsh.model.occ.addSphere(0, 0, 0, r))] for r in (10, radius)))
        gmsh.model.occ.synchronize()
        gmsh.write(self.path(name))
        gmsh.finalize()

    def test_iges(self):
        self.export("part.step", "part.iges")
        size = {"length": 0.003}
        volume = (30 * 20 * 10 - np.pi * 25 * 10) * 1e-9
        for name in ("part.iges", "part.step", "part.iges"):
            manifest = self.take(name, size=size, order=2)
            self.covers_boundary(manifest)
            self.assertEqual(set(manifest["regions"]), {"body"} | {f"face_{i}" for i in range(1, 8)})
            self.assertAlmostEqual(manifest["volume_cad_m3"] / volume, 1, delta=1e-6)
            self.assertAlmostEqual(manifest["volume_m3"] / volume, 1, delta=1e-3)
        self.reject("states its own unit", "part.iges", unit=1.0, size=size)
        self.store("touch.iges", (0, 0, 0, 60, 10, 10), (60, 0, 0, 40, 10, 10))
        self.reject("two faces at one place, (60, 0, 0) to (60, 10, 10) mm", "touch.iges", size=size)
        self.store("sheet.iges", (0, 0, 0, 5, 5))
        self.reject("holds no solid, only faces or curves", "sheet.iges", size=size)

    def test_several_bodies_of_an_iges_file(self):
        """Every closed shell counts, also one of a single face; shells within others are cavities, and bodies in these."""
        ball = 4 / 3 * np.pi
        for name, bodies, volumes in (
            ("apart", [(0, 0, 0, 60, 10, 10), (70, 0, 0, 40, 10, 10)], [6000, 4000]),
            ("balls", [(0, 0, 0, 5), (20, 0, 0, 3), (30, 0, 0, 4, 4, 4)], [ball * 125, ball * 27, 64]),
            ("part_of_a_face", [(0, 0, 0, 10, 10, 10), (10, 2, 2, 5, 5, 5)], [1000, 125]),
            ("hollow", [(0, 0, 0, 10, 10, 10), (2, 2, 2, 5, 5, 5)], [875]),
            ("nested", [(0, 0, 0, 10), (0, 0, 0, 8), (0, 0, 0, 5), (20, 0, 0, 3, 3, 3)], [ball * (1000 - 512), ball * 125, 27]),
        ):
            self.store(f"{name}.iges", *bodies)
            manifest = self.take(f"{name}.iges", size={"length": 0.003})
            self.covers_boundary(manifest)
            self.assertAlmostEqual(manifest["volume_cad_m3"] * 1e9 / sum(volumes), 1, delta=1e-6, msg=name)
            parts = [region for region in manifest["regions"] if region.startswith("volume_")]
            self.assertEqual(len(parts), len(volumes) if len(volumes) > 1 else 0, name)
            self.assertNotIn("dropped", manifest, name)
        self.store("overlap.iges", (0, 0, 0, 10, 10, 10), (5, 5, 5, 10, 10, 10))
        self.reject("share 125 mm³ within (5, 5, 5) to (10, 10, 10) mm", "overlap.iges", size={"length": 0.003})

    def test_faces_of_no_solid(self):
        """They are told, and the mesh is that of the solids alone."""
        size = {"length": 0.003}
        for ending in ("step", "brep", "iges"):
            self.store(f"solid.{ending}", (0, 0, 0, 10, 10, 10))
            self.store(f"sheets.{ending}", (0, 0, 0, 10, 10, 10), (0, 0, 20, 5, 5), (-5, -5, 5, 20, 20))
            alone, both = (self.take(f"{name}.{ending}", size=size) for name in ("solid", "sheets"))
            told = "2 faces bound no solid and are left out, one from (0, 0, 20) to (5, 5, 20) mm; only solids are meshed"
            self.assertEqual(both["dropped"], [told])
            self.assertNotIn("dropped", alone)
            for key in ("cells", "nodes", "facets", "regions"):
                self.assertEqual(alone[key], both[key], key)

    def test_solids_that_overlap(self):
        size, long = {"length": 0.003}, (0, 0, 0, 60, 10, 10)
        for ending in ("step", "brep"):
            self.store(f"overlap.{ending}", long, (50, 0, 0, 50, 10, 10))
            self.reject("solids 1 and 2 of 2 share 1000 mm³ within (50, 0, 0) to (60, 10, 10) mm", f"overlap.{ending}", size=size)
        self.store("inside.step", long, (20, 2, 2, 4, 4, 4))
        self.reject("share 64 mm³ within (20, 2, 2) to (24, 6, 6) mm", "inside.step", size=size)
        self.store("little.step", long, (59.99, 0, 0, 40.01, 10, 10))  # A share of 1e-4 of both
        self.reject("solids 1 and 2 of 2 share 1 mm³ within (59.99, 0, 0) to (60, 10, 10) mm", "little.step", size=size)
        # Far below a millionth of the volume: the piece would be a solid of its own, and shift the numbers of the others
        for overlap in (1e-5, 1e-6):
            self.store("layer.step", long, (60 - overlap, 0, 0, 40, 10, 10))
            self.reject("solids 1 and 2 of 2 share", "layer.step", size=size)
        self.store("twice.step", long, (80, 0, 0, 10, 10, 10), long)
        self.reject("solids 1 and 3 of 3 share 6000 mm³", "twice.step", size=size)
        for name, other in (("touch", (60, 0, 0, 40, 10, 10)), ("apart", (70, 0, 0, 40, 10, 10)), ("corner", (60, 10, 10, 40, 10, 10))):
            self.store(f"{name}.step", long, other)
            manifest = self.take(f"{name}.step", size=size)
            self.assertAlmostEqual(manifest["volume_m3"] * 1e9 / (6000 + 4000), 1, delta=1e-9, msg=name)
            self.assertEqual({name for name in manifest["regions"] if name.startswith("vol")}, {"volume_1", "volume_2"})
        self.store("tangent.step", (0, 0, 0, 5), (10, 0, 0, 5))
        self.assertAlmostEqual(self.take("tangent.step", size=size)["volume_cad_m3"] * 1e9 / (2 * np.pi / 6 * 1000), 1, delta=1e-6)

    def test_thin_walls(self):
        self.concentric("thin.step", gmsh.model.occ.cut, 9.7)
        told = self.refused(3, "If a wall is thinner than a cell", "file", self.parameters("thin.step"), size={"length": 0.009})
        self.assertIn('generator = "cgal" and element = "tet4"', told["hint"])

    def test_surface(self):
        self.export("part.stl")
        for generator, error in (("gmsh", 0.01), ("cgal", 0.03)):
            for order in (1, 2):
                manifest = self.take("part.stl", size={"length": 0.003}, generator=generator, order=order)
                self.covers_boundary(manifest, "face_")
                self.assertEqual(manifest["regions"]["outer"]["count"], manifest["facets"])
                self.assertLess(abs(manifest["volume_error"]), error)
                self.assertEqual(manifest["order"], order)

    def test_volumes_of_solids(self):
        """The manifest has that of each solid in the CAD, whether gmsh keeps the surface between them or CGAL does not; of one solid it has the whole alone."""
        self.concentric("filled.step", gmsh.model.occ.fragment, 6)
        inner, whole = (4 / 3 * np.pi * radius**3 for radius in (6, 10))
        for generator in ("gmsh", "cgal"):
            manifest = self.take("filled.step", size={"length": 0.006}, generator=generator)
            self.assertEqual(set(manifest["volumes_cad_m3"]), {"volume_1", "volume_2"})
            for volume, wanted in zip(sorted(manifest["volumes_cad_m3"].values()), sorted((inner, whole - inner)), strict=True):
                self.assertAlmostEqual(volume * 1e9 / wanted, 1, delta=1e-6)
        self.concentric("hollow.step", gmsh.model.occ.cut, 6)
        self.assertNotIn("volumes_cad_m3", self.take("hollow.step", size={"length": 0.006}))

    def test_cgal_meshes_every_shell_of_cad(self):
        """A small cavity, and a small solid apart from a large one, which CGAL's own first points miss; one without cells is refused."""
        gmsh.initialize([], False, False)
        gmsh.option.setNumber("General.Terminal", 0)
        occ = gmsh.model.occ
        occ.cut([(3, occ.addBox(0, 0, 0, 30, 30, 30))], [(3, occ.addSphere(22, 20, 18, 2.5))])
        occ.addBox(40, 10, 10, 3, 3, 3)
        occ.synchronize()
        gmsh.write(self.path("two.step"))
        gmsh.finalize()
        manifest = self.take("two.step", size={"length": 0.006}, generator="cgal")
        self.covers_boundary(manifest, "face_")
        mesh = read_msh(self.path("mesh.msh.gz"))
        x = mesh["nodes"][np.concatenate([rows for (dim, _), rows in mesh["elements"].items() if dim == 2])]
        near = np.abs(x.mean(axis=1) - np.array([0.022, 0.02, 0.018])).max(axis=1) < 0.0025
        area = np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1)[near].sum() / 2
        # Nodes are on the ball: the area of facets within the approximation of a tenth of their length is that of a smaller ball
        self.assertTrue(4 * np.pi * (2.5 - 0.6) ** 2 < area * 1e6 < 4 * np.pi * 2.5**2, area)
        ends = []
        for name in manifest["volumes_cad_m3"]:
            of_solid = [mesh["elements"][key] for key, groups in mesh["groups"].items() if key[0] == 3 and mesh["names"][name][1] in groups]
            ends.append(mesh["nodes"][np.concatenate(of_solid)][:, :, 0].max() > 0.035)
        self.assertEqual(sorted(ends), [False, True])
        self.concentric("seed.step", gmsh.model.occ.fragment, 0.3)
        request = {"size": {"length": 0.006}, "generator": "cgal"}
        self.refused(3, "no cell of CGAL's mesh has its centre in volume_", "file", self.parameters("seed.step"), **request)

    def test_packed_and_reversed_cad(self):
        self.export("part.step", "part.brep")
        Path(self.path("packed.step.gz")).write_bytes(gzip.compress(Path(self.path("part.step")).read_bytes()))
        text = Path(self.path("part.brep")).read_text().rstrip()
        self.assertIn("\n+1 ", text)
        whole = self.take("part.step", size={"length": 0.004})
        head, _, root = text.rpartition("+")
        Path(self.path("reversed.brep")).write_text(f"{head}-{root}\n")
        for name in ("packed.step.gz", "reversed.brep"):
            manifest = self.take(name, size={"cells": whole["cells"]})
            self.assertAlmostEqual(manifest["volume_cad_m3"] / whole["volume_cad_m3"], 1, delta=1e-9)
            self.assertAlmostEqual(manifest["volume_error"], whole["volume_error"], delta=0.01)

    def test_cells_of_solids(self):
        """CGAL's cells are each in one solid, also the chords of a hole, whose centres lie in none, and those of a solid lie where it does."""
        gmsh.initialize([], False, False)
        gmsh.option.setNumber("General.Terminal", 0)
        occ, heights = gmsh.model.occ, (20, 30)
        tubes = [(3, occ.addCylinder(0, 0, z, 0, 0, height, 10)) for z, height in zip((0, 20), heights)]
        occ.cut(tubes, [(3, occ.addCylinder(0, 0, -1, 0, 0, 52, 5))])
        occ.synchronize()
        gmsh.write(self.path("tubes.step"))
        gmsh.finalize()
        manifest = self.take("tubes.step", size={"length": 0.018}, generator="cgal")
        mesh, whole = read_msh(self.path("mesh.msh.gz")), 0
        for name, height in zip(("volume_1", "volume_2"), heights):
            of_solid = [mesh["elements"][key] for key, groups in mesh["groups"].items() if key[0] == 3 and mesh["names"][name][1] in groups]
            x = mesh["nodes"][np.concatenate(of_solid)]
            self.assertAlmostEqual(np.linalg.det(x[:, 1:] - x[:, :1]).sum() / 6 * 1e9 / (np.pi * 75 * height), 1, delta=0.12)
            whole += len(x)
        self.assertEqual(whole, manifest["cells"])

    def test_levels_of_a_surface(self):
        """Each cell of a surface file becomes eight; those of order 2 are the ones of order 1 with mid-edge nodes on straight edges."""
        self.export("part.stl")
        coarse = self.take("part.stl", size={"length": 0.004})
        linear, quadratic = (self.take("part.stl", size={"length": 0.004, "levels": 1}, order=order) for order in (1, 2))
        for fine in (linear, quadratic):
            self.assertEqual(fine["cells"], 8 * coarse["cells"])
            self.assertEqual(fine["facets"], 4 * coarse["facets"])
            self.assertLess(abs(fine["volume_error"]), abs(coarse["volume_error"]))
        self.assertEqual(quadratic["regions"], linear["regions"])
        self.assertAlmostEqual(quadratic["volume_m3"] / linear["volume_m3"], 1, delta=1e-9)
        self.assertAlmostEqual(quadratic["quality"]["jacobian_min"], 1, delta=1e-6)
        self.covers_boundary(quadratic, "face_")

    def test_bad_surfaces(self):
        def store(name, points, **cells):
            meshio.write(self.path(name), meshio.Mesh(points, {kind: np.array(rows) for kind, rows in cells.items()}))

        size = {"length": 0.1}
        store("good.vtk", CORNERS, tetra=[[0, 1, 2, 3]])
        self.reject("taken over", "good.vtk", size=size)
        Path(self.path("cut.vtk")).write_bytes(Path(self.path("good.vtk")).read_bytes()[:200])
        self.reject("cannot read", "cut.vtk", size=size)
        self.reject("cannot read nowhere.stl", "nowhere.stl", size=size)
        store("square.vtk", CORNERS, quad=[[0, 1, 2, 3]])
        self.reject("made of triangles", "square.vtk", size=size)
        self.refused(2, "kind", "file", {"path": "a.stl", "unit_m": 1.0, "format": "stl", "kind": "drawing"}, size=size)
