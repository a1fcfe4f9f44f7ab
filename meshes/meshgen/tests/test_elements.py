"""One element of each type: its kind, its volume, its faces, and its nodes in the middle of edges."""

from pathlib import Path

import meshio
import numpy as np

from meshgen import convert
from meshgen.blocks import Blocks

from .common import Case

TET = [[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]]
BRICK = [[x, y, z] for z in (0, 3) for x, y in ((0, 0), (1, 0), (1, 2), (0, 2))]
WEDGE = [[x, y, z] for z in (0, 3) for x, y in ((0, 0), (1, 0), (0, 2))]
PYRAMID = [*BRICK[:4], [0, 0, 3]]
# Edges of the nodes behind the corners, in the order of Abaqus's manual
OF_TET = [(1, 2), (2, 3), (3, 1), (1, 4), (2, 4), (3, 4)]
OF_BRICK = [(1, 2), (2, 3), (3, 4), (4, 1), (5, 6), (6, 7), (7, 8), (8, 5), (1, 5), (2, 6), (3, 7), (4, 8)]
OF_WEDGE = [(1, 2), (2, 3), (3, 1), (4, 5), (5, 6), (6, 4), (1, 4), (2, 5), (3, 6)]
# Area times outward normal of the faces S1, S2, …
TET_FACES = [(0, 0, -1), (0, -1.5, 0), (3, 1.5, 1), (-3, 0, 0)]
BRICK_FACES = [(0, 0, -2), (0, 0, 2), (0, -3, 0), (6, 0, 0), (0, 3, 0), (-6, 0, 0)]
WEDGE_FACES = [(0, 0, -1), (0, 0, 1), (0, -3, 0), (6, 3, 0), (-6, 0, 0)]
PYRAMID_FACES = [(0, 0, -2), (0, -1.5, 0), (3, 0, 1), (0, 1.5, 1), (-3, 0, 0)]
# Type -> (gmsh's kind, corners, edges with a node, volume, faces)
TYPES = {
    "C3D4": (4, TET, [], 1, TET_FACES), "C3D10": (11, TET, OF_TET, 1, TET_FACES), "C3D8": (5, BRICK, [], 6, BRICK_FACES),
    "C3D20R": (17, BRICK, OF_BRICK, 6, BRICK_FACES), "C3D6": (6, WEDGE, [], 3, WEDGE_FACES), "C3D15": (18, WEDGE, OF_WEDGE, 3, WEDGE_FACES),
    "C3D5": (7, PYRAMID, [], 2, PYRAMID_FACES),
}  # fmt: skip


def area(corners: np.ndarray) -> np.ndarray:
    """Area times normal of a flat polygon."""
    return np.cross(corners[1:-1] - corners[0], corners[2:] - corners[0]).sum(axis=0) / 2


class Elements(Case):
    def abaqus(self, points: np.ndarray, elements: list, more: str = "") -> Blocks:
        """The blocks of a file with the elements (type, nodes from 1)."""
        text = "*Node\n" + "".join(f"{i}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(np.asarray(points).tolist(), 1))
        for label, (name, nodes) in enumerate(elements, 1):
            words = [label, *nodes]
            rows = [", ".join(map(str, words[start : start + 8])) for start in range(0, len(words), 8)]
            text += f"*Element, type={name}\n" + ",\n".join(rows) + "\n"
        Path(self.path("a.inp")).write_text(text + more)
        return convert.read(Path(self.path("a.inp")), "abaqus")

    def test_types(self):
        """Kind and volume; faces by their numbers, with area and outward normal."""
        for name, (kind, corners, edges, volume, faces) in TYPES.items():
            corners = np.array(corners, float)
            points = np.array([*corners, *(corners[np.array(edge) - 1].mean(axis=0) for edge in edges)])
            surfaces = "".join(f"*Surface, name=s{i}\n 1, S{i}\n" for i in range(1, len(faces) + 1))
            blocks = self.abaqus(points, [(name, range(1, len(points) + 1))], surfaces)
            (rows,) = [rows for of, rows in blocks.cells if of == kind]
            x = blocks.points[rows[0][: len(corners)]]
            self.assertEqual(len(rows[0]), len(points), name)
            flux = 0.0  # Of the position divided by 3, which is the volume
            for i, expected in enumerate(faces, 1):
                (nodes,) = [nodes for (_, facets), mask in zip(blocks.cells, blocks.sets[f"s{i}"]) for nodes in facets[mask]]
                face = blocks.points[nodes]
                outward = area(face) * np.sign(area(face) @ (face.mean(axis=0) - x.mean(axis=0)))
                np.testing.assert_allclose(outward, expected, atol=1e-12, err_msg=f"{name} S{i}")
                flux += outward @ face[0] / 3
            self.assertAlmostEqual(flux, volume, msg=name)
            self.assertEqual(set(map(tuple, x.tolist())), set(map(tuple, corners.tolist())), name)
            if kind in (4, 11):
                self.assertAlmostEqual(np.linalg.det(x[1:] - x[0]) / 6, volume, msg=name)

    def test_nodes_of_edges(self):
        """Each node of a curved tetrahedron stays on its edge, which is that of gmsh's order in the result."""
        corners = np.array(TET, float)
        moved = {edge: corners[np.array(edge) - 1].mean(axis=0) + 0.01 * np.array([i + 1, i * i, -i]) for i, edge in enumerate(OF_TET)}
        points = np.array([*corners, *moved.values()])
        blocks = self.abaqus(points, [("C3D10", range(1, 11))])
        meshio.write(self.path("a.vtu"), meshio.Mesh(points, {"tetra10": [list(range(10))]}))
        for found in (blocks, convert.read(Path(self.path("a.vtu")), "vtu")):
            (row,) = next(rows for kind, rows in found.cells if kind == 11)
            np.testing.assert_array_equal(found.points[row[:4]], corners)
            for node, edge in zip(row[4:], [(1, 2), (2, 3), (3, 1), (1, 4), (3, 4), (2, 4)], strict=True):
                np.testing.assert_allclose(found.points[node], moved[edge])

    def test_prisms_and_pyramids_of_meshio(self):
        """Wedges and pyramids keep their kind."""
        cells = [("wedge", [list(range(6))]), ("pyramid", [[6, 7, 8, 9, 10]]), ("hexahedron", [list(range(11, 19))])]
        meshio.write(self.path("a.vtu"), meshio.Mesh(np.array(WEDGE + PYRAMID + BRICK, float), cells))
        found = convert.read(Path(self.path("a.vtu")), "vtu")
        self.assertEqual([(kind, rows.tolist()) for kind, rows in found.cells], [(kind, rows) for kind, (_, rows) in zip((6, 7, 5), cells)])
