"""Surfaces as found in practice: each is meshed with the volume that it encloses, or refused with the place of its defect."""

import os
import struct
import time
import unittest
import unittest.mock
from pathlib import Path

import numpy as np

from meshgen import repair, surface_mesh
from meshgen.errors import BadRequest, MesherFailed
from meshgen.mesh import TetMesh, check_volume

from . import shapes
from .common import Case, read_msh
from .shapes import ball, binary_stl, blocks, box, joined, moved, prism, reversed_, torus

HOLLOW = joined(box(size=(12, 12, 12)), moved(box(size=(6, 6, 6)), (3, 3, 3)))
GENUS_2 = [(x, y, 0) for x in range(5) for y in range(3) if y != 1 or x % 2 == 0]
LIMIT_S = 20  # of CPU time for one surface, so that a busy machine does not count


def split(part: tuple, row: int, weights: tuple) -> tuple:
    """One triangle divided at a point of it; with a zero weight a node comes to lie on an edge."""
    points, triangles = part
    a, b, c = triangles[row]
    new = len(points)
    pieces = [t for t, w in (((new, b, c), weights[0]), ((a, new, c), weights[1]), ((a, b, new), weights[2])) if w]
    point = np.array(weights) @ points[triangles[row]]
    return np.vstack([points, point]), np.vstack([np.delete(triangles, row, axis=0), pieces])


class Surfaces(Case):
    def take(self, part: tuple | None = None, file: str = "a.stl", write=binary_stl, unit: float = 1e-3, length: float = 2.5, **request) -> dict:
        """The manifest of a surface that must be meshed; length in the unit of the file."""
        if part is not None:
            write(self.path(file), part)
        start = time.process_time()
        answer = self.made("file", self.parameters(file, unit), size={"length": length * unit}, **request)
        self.assertLess(time.process_time() - start, LIMIT_S)
        return answer

    def volume(self, part: tuple, expected: float, tolerance: float = 1e-6, **request) -> dict:
        """Meshed, and the mesh has this volume [file's unit³] within a relative tolerance; 1e-6 covers the STL's single precision."""
        answer = self.take(part, **request)
        self.assertAlmostEqual(answer["volume_m3"] / request.get("unit", 1e-3) ** 3 / expected, 1, delta=tolerance)
        self.assertAlmostEqual(answer["volume_cad_m3"] / request.get("unit", 1e-3) ** 3 / expected, 1, delta=1e-6)
        return answer

    def reject(self, words: str, part: tuple | None = None, file: str = "a.stl", write=binary_stl, at=None, **request) -> None:
        """Refused with these words and, if given, a place [file's unit] within 1e-3 of it."""
        if part is not None:
            write(self.path(file), part)
        start = time.process_time()
        answer = self.refused(2, words, "file", self.parameters(file), size={"length": 0.0025}, **request)
        self.assertLess(time.process_time() - start, LIMIT_S)
        if at is not None:
            told = answer["error"].split(words)[1].split("(")[1].split(")")[0]
            np.testing.assert_allclose([float(x) for x in told.split(",")], at, atol=1e-3)

    def repaired(self, words: str, part: tuple, expected: float, **request) -> None:
        """Meshed after a repair that the manifest states."""
        answer = self.volume(part, expected, **request)
        self.assertIn(words, "; ".join(answer["repairs"]))

    def test_bytes_after_a_binary_stl(self):
        binary_stl(self.path("a.stl"), box(size=(10, 10, 10)))
        whole = Path(self.path("a.stl")).read_bytes()
        for rest in (bytes(4), b"end.", bytes(512 - len(whole) % 512)):
            Path(self.path("a.stl")).write_bytes(whole + rest)
            self.assertAlmostEqual(self.take()["volume_cad_m3"] * 1e6, 1, delta=1e-6)
        for wrong in (whole + whole[-50:], whole[:-1]):
            Path(self.path("a.stl")).write_bytes(wrong)
            self.reject("neither a complete binary nor an ASCII STL")

    def test_hollow(self):
        for hollow in (HOLLOW, joined(box(size=(12, 12, 12)), reversed_(moved(box(size=(6, 6, 6)), (3, 3, 3))))):
            answer = self.volume(hollow, 12**3 - 6**3, file="hollow.stl")
            self.assertEqual(answer["repairs"], [])
            self.assertEqual(list(answer["volumes_cad_m3"]), ["cavity"])
            self.assertAlmostEqual(answer["volumes_cad_m3"]["cavity"] / 6e-3**3, 1, delta=1e-6)
        sizes = {name: region["count"] for name, region in answer["regions"].items()}
        self.assertEqual(sizes["outer"] + sizes["cavity"], answer["facets"])
        self.assertNotIn("cavity_1", sizes)
        raw = read_msh(self.path("mesh.msh.gz"))
        tag = raw["names"]["cavity"][1]
        walls = np.concatenate([raw["elements"][key] for key, groups in raw["groups"].items() if key[0] == 2 and tag in groups])
        x = raw["nodes"][walls]
        enclosed = np.einsum("ij,ij->", np.cross(x[:, 0], x[:, 1]), x[:, 2]) / 6
        self.assertAlmostEqual(enclosed, -(6e-3**3), delta=1e-12)  # normals point into the cavity, out of the body

    def test_nested(self):
        cube = lambda low, edge: moved(box((1, 1, 1), (edge, edge, edge)), (low, low, low))  # noqa: E731
        answer = self.volume(joined(cube(0, 12), cube(2, 8), cube(4, 4)), 12**3 - 8**3 + 4**3)
        counts = {name: region["count"] for name, region in answer["regions"].items() if region["dim"] == 3}
        self.assertEqual(counts["volume_1"] + counts["volume_2"], counts["body"])
        self.assertLessEqual({"outer", "outer_1", "outer_2", "cavity"}, set(answer["regions"]))
        answer = self.volume(joined(cube(0, 12), cube(1, 3), cube(7, 4), cube(20, 5)), 12**3 - 3**3 - 4**3 + 5**3)
        self.assertLessEqual({"outer_1", "outer_2", "cavity", "cavity_1", "cavity_2", "volume_2"}, set(answer["regions"]))

    def test_round_and_pierced(self):
        # A chord of length h over a radius R of curvature has the sag h²/8R; times the area it bounds the volume.
        sphere = 4 / 3 * np.pi * 125
        answer = self.take(ball(level=3), length=1.5)
        self.assertAlmostEqual(answer["volume_m3"] * 1e9 / sphere, 1, delta=3 / 5 * (1.5**2 + 0.7**2) / 8 / 5)
        answer = self.take(torus(), length=1.5)
        self.assertAlmostEqual(answer["volume_error"], 0, delta=2 / 3 * 1.5**2 / 8 / 3)
        self.volume(blocks(GENUS_2, (4, 4, 4)), 13 * 64, length=4)
        self.take(joined(ball(), moved(ball(2), (0, 0, 1))), length=1.5, order=2)

    def test_units_and_proportions(self):
        self.volume(box(size=(1e4, 1e4, 1e4)), 1e12, unit=1e-6, length=2500)
        self.volume(moved(box(), scale=1e-7), 1e-18, unit=1.0, length=2.5e-7)
        self.volume(moved(box(), (1000, 2000, 3000)), 1000, tolerance=1e-4)
        self.volume(box((8, 8, 1), (40, 40, 0.5)), 800, length=4)
        self.volume(box((1, 1, 1), (200, 2, 2)), 800, length=4)

    def test_formats(self):
        self.volume(box(), 1000, file="a.stl", write=shapes.ascii_stl)
        self.volume(box(), 1000, file="b.stl", write=lambda p, s: shapes.ascii_stl(p, s, "Körper ß", "latin-1", "\r\n"))
        self.volume(box(), 1000, file="c.STL", write=lambda p, s: binary_stl(p, s, b"solid that is binary"))
        self.volume(box(), 1000, file="Prüf körper ü.stl")
        for name, write in (("d.obj", shapes.obj), ("e.off", shapes.off), ("f.ply", shapes.ply)):
            self.volume(box(), 1000, file=name, write=write)
        binary_stl(self.path("cut.stl"), box())
        Path(self.path("cut.stl")).write_bytes(Path(self.path("cut.stl")).read_bytes()[:-30])
        self.reject("its header promises 48 triangles", file="cut.stl")
        Path(self.path("no.stl")).write_text("hello")
        self.reject("neither a complete binary nor an ASCII STL", file="no.stl")
        Path(self.path("empty.stl")).write_text("solid\nendsolid\n")
        self.reject("empty.stl", file="empty.stl")
        points, triangles = box()
        points[0, 0] = np.nan
        self.reject("not finite", (points, triangles))

    def test_polygons(self):
        """Faces with more than three corners, convex or not, with any first corner; self-crossing faces are refused."""
        bent = [(0, 0), (20, 0), (20, 10), (10, 10), (10, 20), (0, 20)]
        hexagon = [(10 * np.cos(a), 10 * np.sin(a)) for a in np.pi / 3 * np.arange(6)]
        for start in range(6):
            self.volume(prism(bent[start:] + bent[:start], 5), 1500, file="bent.obj", write=shapes.obj, length=8)
        for write in (shapes.obj, shapes.off, shapes.ply):
            self.volume(prism(bent[2:] + bent[:2], 5), 1500, file=f"bent.{write.__name__}", write=write, length=8)
            self.volume(prism(hexagon, 5), 750 * 3**0.5, file=f"six.{write.__name__}", write=write, length=8)
        more = [(0, 0), (10, 0), (20, 0), (20, 5), (20, 10), (10, 10), (10, 15), (10, 20), (5, 20), (0, 20), (0, 9)]
        self.volume(prism(more, 5), 1500, file="more.obj", write=shapes.obj, length=8)
        # Turned in space, with a hole that a cut joins to the outline: its two sides, the faces 6 and 11, are one and are left out
        points, faces = prism([(0, 0), (9, 0), (9, 9), (0, 9), (0, 0), (3, 3), (3, 6), (6, 6), (6, 3), (3, 3)], 4)
        points = points @ np.array([[1, 2, 2], [2, 1, -2], [2, -2, 1]]) / 3
        self.volume((points, faces[:6] + faces[7:11]), 4 * 72, file="holed.obj", write=shapes.obj, length=4)
        self.reject("is no closed surface", prism([(0, 0), (9, 9), (9, 0), (0, 5)], 4), file="crossed.obj", write=shapes.obj)
        # Negative numbers count back from the points so far
        points, faces = prism(bent, 5)
        self.volume((points, [[i - len(points) - 1 for i in face] for face in faces]), 1500, file="back.obj", write=shapes.obj, length=8)
        with open(self.path("back.obj"), "a") as file:
            file.write("v 9 9 9\n")
        self.assertAlmostEqual(self.take(file="back.obj", length=8)["volume_cad_m3"] * 1e9, 1500)
        for words, text in (("a face has 2 corners", "f 1 2"), ("refers to a node that is none of the 3", "f 1 2 4"), ("none of the 3", "f -1 -2 -9")):
            Path(self.path("bad.obj")).write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{text}\n")
            self.reject(words, file="bad.obj")

    def test_repairs(self):
        points, triangles = box()
        turned = triangles.copy()
        turned[::5] = turned[::5][:, [0, 2, 1]]
        self.repaired("10 triangles reversed", (points, turned), 1000)
        self.repaired("2 doubled triangles dropped", (points, np.vstack([triangles, triangles[:2]])), 1000)
        self.repaired("1 hole of three edges", (points, triangles[1:]), 1000)
        rng = np.random.default_rng(1)
        corners = shapes.corners((points, triangles)) + rng.uniform(-5e-6, 5e-6, (48, 3, 3))
        self.repaired("open edges joined", (corners.reshape(-1, 3), np.arange(144).reshape(-1, 3)), 1000, tolerance=1e-5, write=shapes.obj, file="gap.obj")
        # A node on an edge of the neighbour only (T-junction), and a flat triangle that closes it.
        t_junction = split((points, triangles), 0, (0.5, 0.5, 0))
        self.repaired("open edges joined", t_junction, 1000)
        a, b, _ = triangles[0]
        flat = (t_junction[0], np.vstack([t_junction[1], [a, b, len(points)]]))
        self.repaired("flat triangle", flat, 1000)
        # Two blocks with a common side: the side has no thickness.
        neighbours = joined(box((1, 1, 1)), moved(box((1, 1, 1)), (10, 0, 0)))
        self.repaired("4 doubled triangles dropped", neighbours, 2000)
        sheet = (np.array([[30.0, 0, 0], [31, 0, 0], [30, 1, 0], [30.3, 0.3, 1e-7]]), np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))
        self.repaired("parts without volume dropped", joined(box(), sheet), 1000, write=shapes.obj, file="sheet.obj")

    def test_cavities_are_kept(self):
        """A cavity is kept of a shell that is there twice, back to front; one of loose triangles is open, and not dropped with the triangles that would close it."""
        points, triangles = moved(box(size=(6, 6, 6)), (3, 3, 3))
        outer = box(size=(12, 12, 12))
        doubled = joined(outer, (points, np.vstack([triangles, triangles[:, ::-1]])))
        found = repair.closed("a", *doubled, False)
        self.assertAlmostEqual(found.volume(), 12**3 - 6**3)
        self.assertIn("48 doubled triangles dropped", found.repairs[0])
        corners = shapes.corners((points, triangles))
        loose = corners + 1e-3 * (corners.mean(axis=1, keepdims=True) - corners)
        with self.assertRaisesRegex(BadRequest, "open at 48 holes"):
            repair.closed("a", *joined(outer, (loose.reshape(-1, 3), np.arange(144).reshape(-1, 3))), False)

    def test_gaps(self):
        """Nodes of open edges closer than 1e-5 of the extent are joined, others are not."""
        points, triangles = box()
        lid = np.all(points[triangles][:, :, 2] == 10, axis=1)
        for gap, joins in ((0.9e-4, True), (1.1e-4, False), (1e-3, False)):
            lifted = joined((points, triangles[~lid]), (points + [0, 0, gap], triangles[lid]))
            if joins:
                found = repair.closed("a", *lifted, False)
                self.assertIn("16 open edges joined", found.repairs[0])
                self.assertAlmostEqual(found.volume(), 1000, delta=0.01)
            else:
                self.reject("it is open at", lifted, write=shapes.obj, file="lid.obj")

    def test_one_repair_alone(self):
        """A triangle that closes a hole, or is kept of several, is turned like its neighbours; nodes on an edge are met one after the other."""
        points, triangles = box()

        def closed(part: tuple, *words: str) -> None:
            found = repair.closed("a", *part, False)
            self.assertEqual(len(found.repairs), len(words), found.repairs)
            for word, line in zip(words, found.repairs):
                self.assertIn(word, line)
            self.assertAlmostEqual(found.volume(), 1000)

        for row in (0, 7, 20):
            closed((points, np.delete(triangles, row, axis=0)), "1 hole of three edges")
            one = triangles[[row]]
            closed((points, np.vstack([one[:, ::-1], triangles, one[:, [1, 2, 0]]])), "2 doubled triangles dropped")
        # Three nodes on an edge, in another order than their numbers
        part = split(box(), 0, (0.5, 0.5, 0))
        for weights in ((0.4, 0.6, 0), (0.7, 0.3, 0)):
            part = split(part, len(part[1]) - 2, weights)
        closed(part, "5 open edges joined")

    def test_cavity_of_a_solid_in_a_cavity(self):
        """A cavity belongs to the smallest solid around it, in any order of the shells."""
        cubes = [moved(box((1, 1, 1), (edge, edge, edge)), (-edge / 2,) * 3) for edge in (12.0, 10.0, 8.0, 6.0)]
        for order in ((0, 1, 2, 3), (3, 2, 1, 0), (2, 0, 3, 1)):
            found = repair.closed("a", *joined(*(cubes[i] for i in order)), False)
            solids = [[order[shell] for shell in solid] for solid in found.solids]
            self.assertEqual(sorted(solids), [[0, 1], [2, 3]])

    def test_creases(self):
        """A surface is cut into faces where it bends by more than 40 degrees, and gmsh keeps to that where it can."""
        for corners, faces in ((12, 3), (8, 10)):
            around = 2 * np.pi * np.arange(corners) / corners
            part = prism(np.stack([10 * np.cos(around), 10 * np.sin(around)], axis=1).tolist(), 10)
            answer = self.take(part, file="prism.obj", write=shapes.obj, length=5, generator="cgal")
            self.assertEqual(sum(name.startswith("face_") for name in answer["regions"]), faces)
        self.assertEqual(self.take(file="prism.obj", length=5)["route"], "faces cut at 40 degrees")

    def test_lost_walls(self):
        """A mesh of the outer walls alone is refused where the cavity is more than a quarter of the volume of the body."""
        outer = box((1, 1, 1), (10, 10, 10))
        for edge, is_lost in ((5.8, False), (5.9, True)):  # A cavity with an edge of 5.848 is a fifth of the whole and a quarter of the rest
            body = repair.closed("a", *joined(outer, moved(box((1, 1, 1), (edge, edge, edge)), (1, 1, 1))), False)
            enclosed = body.volume() * 1e-9
            made = TetMesh(outer[0] * 1e-3, np.zeros((0, 4), int), outer[1])
            if is_lost:
                with self.assertRaisesRegex(MesherFailed, "misses the enclosed volume by 26 %"):
                    check_volume(made, enclosed)
            else:
                check_volume(made, enclosed)

    def test_defects(self):
        points, triangles = box()
        self.reject("open at 1 hole", (points, triangles[4:]))
        for generator in ("gmsh", "cgal"):
            self.reject("parts cross or touch", joined(box(), moved(box(), (5.2, 5.3, 5.1))), generator=generator)
        points_in = points.copy()
        points_in[np.all(points == [0, 5, 5], axis=1)] = (12, 5.3, 5.2)  # the middle of a side pushed through the one opposite
        self.reject("of triangles cross or touch, one at", (points_in, triangles))
        self.reject("1 single node, one at", blocks([(0, 0, 0), (1, 1, 1)]), at=(1, 1, 1))
        self.reject("with more than two triangles, one at", blocks([(0, 0, 0), (1, 1, 0)]), at=(1, 1, 0.5))
        self.reject("parts cross or touch", joined(box(), moved(box((1, 1, 1), (4, 4, 4)), (10, 3, 3))))
        self.reject("parts cross or touch", joined(box(size=(12, 12, 12)), moved(box((1, 1, 1), (4, 4, 4)), (8, 3, 3))))
        u = 2 * np.pi * np.arange(24) / 24
        strip = [[(8 + w * np.cos(v / 2)) * np.cos(v), (8 + w * np.cos(v / 2)) * np.sin(v), w * np.sin(v / 2)] for v in u for w in (-2, 2)]
        self.reject("open at", (np.array(strip), np.array([t for i in range(23) for t in ((2 * i, 2 * i + 1, 2 * i + 2), (2 * i + 1, 2 * i + 3, 2 * i + 2))])))
        self.reject("encloses no volume", (np.array([[0.0, 0, 0], [9, 0, 0], [0, 9, 0], [3, 3, 1e-7]]), np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])), write=shapes.obj, file="flat.obj")
        self.reject("all points of the surface coincide", (np.zeros((3, 3)), np.array([[0, 1, 2]])))

    def test_cgal(self):
        # Volume: the creases are rounded within the facet's approximation, a tenth of the edge; that bounds it with the area.
        for part, volume, area in ((HOLLOW, 12**3 - 6**3, 6 * 144 + 6 * 36), (torus(), None, 4 * np.pi**2 * 24)):
            answer = self.take(part, length=1.5, generator="cgal")
            self.assertLess(abs(answer["volume_error"]), 0.15 * area / (answer["volume_cad_m3"] * 1e9))
            self.assertIn("outer", answer["regions"])
        points, triangles = box((4, 4, 4))
        points[np.all(points == [0, 5, 5], axis=1)] = (10.2, 5.3, 5.2)  # a thin spike through the opposite side
        crossed = self.take((points, triangles), length=1.5, generator="cgal")
        self.assertIn("left as they are", crossed["repairs"][0])
        two = self.take(joined(box(size=(5, 5, 5)), moved(box(size=(5, 5, 5)), (9, 0, 0))), length=1.5, generator="cgal", order=2)
        counts = {name: region["count"] for name, region in two["regions"].items() if region["dim"] == 3}
        self.assertEqual(counts["volume_1"] + counts["volume_2"], counts["body"])
        self.assertEqual(two["order"], 2)

    def test_space_that_a_surface_covers_twice(self):
        """Its inside is not defined where a tube crosses itself, here about the axis of a torus, in a wall as in a cavity, whichever way the normals point."""
        spindle = torus(4, 6)
        for part in (spindle, reversed_(spindle), joined(moved(box((1, 1, 1), (40, 40, 40)), (-20, -20, -20)), spindle)):
            for generator in ("gmsh", "cgal"):
                self.reject("of triangles cross or touch", part, generator=generator)
                answer = self.refused(2, "and cover space twice, as at", "file", self.parameters("a.stl"), size={"length": 0.0025}, generator=generator)
                self.assertNotIn("cgal", answer["hint"])
                told = np.array(answer["error"].split("twice, as at (")[1].split(")")[0].split(","), float)
                self.assertLess(np.hypot(*told[:2]), 2)  # The axis is within both of its sides up to a radius of 6 - 4

    def test_ply_files(self):
        """In every encoding, whatever else the file has: colours, lists of other things, elements of other kinds, and any order of them."""
        points, faces = prism([(0, 0), (30, 0), (30, 20), (0, 20)], 10)
        vertex = "element vertex 8\nproperty uchar red\nproperty double z\nproperty float32 x\nproperty float y\n"
        face = "element face 6\nproperty uchar flags\nproperty list uchar float texcoord\nproperty list ushort uint {}\nproperty float quality\n"
        other = "element edge 2\nproperty int vertex1\nproperty int vertex2\n"
        for encoding, order in (("ascii", ""), ("binary_little_endian", "<"), ("binary_big_endian", ">")):
            for name, end in (("vertex_indices", "\n"), ("vertex_index", "\r\n")):
                head = f"ply\nformat {encoding} 1.0\ncomment end_header is below\n{vertex}{other}{face.format(name)}end_header\n".replace("\n", end)
                rows = [("Bdff", (9, z, x, y)) for x, y, z in points.tolist()] + [("ii", (0, 1)), ("ii", (2, 3))]
                rows += [("BB2fH4If", (7, 2, 0.5, 0.25, 4, *corners, 0.5)) for corners in faces]
                if order:
                    body = b"".join(struct.pack(order + kinds, *values) for kinds, values in rows)
                else:
                    body = end.join(" ".join(map(str, values)) for _, values in rows).encode()
                Path(self.path("a.ply")).write_bytes(head.encode() + body)
                self.assertAlmostEqual(self.take(file="a.ply", length=8)["volume_cad_m3"] * 1e9, 6000, delta=1e-6)
                Path(self.path("a.ply")).write_bytes(head.encode() + body + b" " + body)
                self.reject("it goes on after its last element", file="a.ply")
                Path(self.path("a.ply")).write_bytes(head.encode() + body[:-9])
                self.reject("cannot read a.ply", file="a.ply")
        for words, rest in (
            ("no header", "format ascii 1.0\nelement vertex 8\n"),
            ("no header", "format text 1.0\nend_header\n"),
            ("needs the elements", "format ascii 1.0\nend_header\n"),
        ):
            text = f"ply\n{rest}"
            Path(self.path("bad.ply")).write_text(text)
            self.reject(words, file="bad.ply")

    def test_two_surfaces_in_one_file(self):
        """A cavity that follows the body in the same OFF file is not lost."""
        text = ""
        for points, triangles in (box(size=(12, 12, 12)), moved(box(size=(6, 6, 6)), (3, 3, 3))):
            rows = [" ".join(map(str, point)) for point in points.tolist()] + [f"3 {a} {b} {c}" for a, b, c in triangles.tolist()]
            text += "\n".join(["OFF", f"{len(points)} {len(triangles)} 0", *rows, ""])
        Path(self.path("two.off")).write_text(text)
        self.reject("write several surfaces with one list of points", file="two.off")

    def test_routes(self):
        """If gmsh cannot map the faces to the plane, CGAL remeshes them; if that fails too, all reasons are reported."""
        failing = unittest.mock.patch.object(surface_mesh, "parametrised", side_effect=MesherFailed("Wrong topology of boundary mesh"))
        with failing:
            for part, volume in ((HOLLOW, 12**3 - 6**3), (blocks(GENUS_2, (4, 4, 4)), 13 * 64)):
                answer = self.volume(part, volume, length=2)
                self.assertEqual(answer["route"], "triangles made anew by CGAL")
                self.covers_boundary(answer, "face_")
            with unittest.mock.patch.object(surface_mesh, "remeshed", side_effect=MesherFailed("no such luck")):
                words = ('makes no mesh of a.stl', "faces cut at 20 degrees: Wrong topology", "anew by CGAL: no such luck", 'try generator = "cgal"')
                answer = self.refused(3, words[0], "file", self.parameters("a.stl"), size={"length": 0.002})
                for word in words:
                    self.assertIn(word, answer["error"] + answer["hint"])

    @unittest.skipUnless("DUROMETER_SHARED" in os.environ, "DUROMETER_SHARED names the folder of the public data")
    def test_public(self):
        folder = Path(os.environ["DUROMETER_SHARED"]) / "data"
        for name, size in (("robots/pneunetCut", 5), ("robots/pneunetCavityCut", 3), ("robots/Springy_Cavity", 0.3), ("finger/finger", 4)):
            answer = self.take(file=str(folder / f"{name}.stl"), length=size)
            self.assertLess(abs(answer["volume_error"]), 0.01)
        answer = self.take(file=str(folder / "robots/pneunetCut.stl"), length=5, generator="cgal")
        self.assertLessEqual({"outer", "cavity"}, set(answer["regions"]))
        self.reject("6 pairs of triangles cross or touch, one at", file=str(folder / "robots/Springy.stl"), at=(-1.277, -0.859, 2.545))
        answer = self.take(file=str(folder / "robots/Springy.stl"), length=0.4, generator="cgal")
        self.assertLess(abs(answer["volume_error"]), 0.03)
        self.take(file=str(folder / "robots/soft-finger-design.stl"), unit=1.0, length=0.005)
