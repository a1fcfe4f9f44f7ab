"""Cells: their shapes against values computed by hand, their order, and the regions of their facets."""

import unittest

import numpy as np

from meshgen import mesh, quality
from meshgen.errors import MesherFailed

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
CELL = np.array([[0, 1, 2, 3]])
FACETS = {"a": np.array([[0, 1, 2], [0, 1, 3]]), "b": np.array([[1, 2, 3], [2, 0, 3]])}


def quadratic(points: np.ndarray) -> np.ndarray:
    """The ten nodes of a cell with straight edges."""
    return np.vstack([points, points[mesh.EDGES].mean(axis=1)])


class Cells(unittest.TestCase):
    def shapes(self, points: list, sicn: float, ratio: float, angles: list) -> None:
        """Those of a cell in this order of its corners, in any size."""
        for scale in (1, 1e-3):
            found = quality.shapes(scale * np.array(points, float), CELL)
            self.assertAlmostEqual(found[0][0], sicn)
            self.assertAlmostEqual(found[1][0], ratio)
            np.testing.assert_allclose(np.sort(found[2][0]), np.sort(angles), atol=1e-6)

    def test_shapes(self):
        self.shapes([[1, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]], 1, 1, [np.degrees(np.arccos(1 / 3))] * 6)
        # Edges of 1, 2, 3 at right angles: V = 1, areas 1, 3/2, 3, 7/2 with r = 3 V / 9, R = sqrt(1 + 4 + 9) / 2. The Jacobian to the regular cell is
        # S = diag(1, 2, 3) W^-1, where columns of W have length 1 and rows of W^-1 1/height = sqrt(3/2): |S|^2 = 14 * 3/2, |S^-1|^2 = 1 + 1/4 + 1/9
        slanted = np.degrees(np.arccos(np.array([2, 3, 6]) / 7))
        right = np.diag([1.0, 2, 3])
        self.shapes([[0, 0, 0], *right], 18 / (7 * 21**0.5), 2 / 14**0.5, [90, 90, 90, *slanted])
        flipped, _, _ = quality.shapes(np.array([[0, 0, 0], *right[[1, 0, 2]]]), CELL)
        self.assertAlmostEqual(flipped[0], -18 / (7 * 21**0.5))

    def test_curved_cell(self):
        """With the node of the edge 0-1 moved by h along z, det J = 1 - 4 h x: from 1 to 1 - 4 h, with the mean 1 - h."""
        points = quadratic(CORNERS)
        points[4, 2] += 0.1
        curved = mesh.TetMesh(points, np.arange(10).reshape(1, 10), mesh.boundary(np.arange(10).reshape(1, 10)))
        self.assertAlmostEqual(quality.report(curved)["jacobian_min"], 0.6)
        self.assertAlmostEqual(quality.volume(curved), 0.9 / 6)

    def test_cells_that_are_reversed(self):
        """All cells are turned if all are negative, with the nodes on their edges; single ones are refused with their place."""
        for nodes in (4, 10):
            points = quadratic(CORNERS * [-1, 1, 1])[:nodes]
            (cell,) = mesh.oriented(points, np.arange(nodes).reshape(1, -1))
            self.assertAlmostEqual(mesh.corner_volumes(points, cell[None])[0], 1 / 6)
            np.testing.assert_array_equal(points[cell[4:]], points[cell[mesh.EDGES]].mean(axis=1)[: nodes - 4])
            self.assertEqual(sorted(cell), list(range(nodes)))
        points = np.vstack([CORNERS, [[1, 1, 0]]])
        for bad in ([0, 2, 1, 3], [0, 1, 2, 4]):
            with self.assertRaisesRegex(MesherFailed, "1 of 2 cells are inverted or flat; the first is cell 1 at"):
                mesh.oriented(points, np.array([[0, 1, 2, 3], bad]))

    def test_regions_of_facets(self):
        """Each facet is in one region; others may have it too only where that is wanted."""
        made = mesh.assemble(CORNERS, CELL, {"body": np.array([True])}, FACETS)
        self.assertEqual({name: (dim, len(rows)) for name, (dim, rows) in made.regions.items()}, {"body": (3, 1), "a": (2, 2), "b": (2, 2)})
        twice, lost = FACETS | {"c": FACETS["b"][:1]}, {"a": FACETS["a"]}
        for facets, count in ((twice, 1), (lost, 2)):
            with self.assertRaisesRegex(MesherFailed, f"{count} of 4 boundary facets are not in exactly one facet region"):
                mesh.assemble(CORNERS, CELL, {}, facets)
            self.assertEqual(set(mesh.assemble(CORNERS, CELL, {}, facets, exclusive=False).regions), set(facets))
        two = np.vstack([CORNERS, [[1, 1, 1]]]), np.array([[0, 1, 2, 3], [1, 2, 3, 4]])
        with self.assertRaisesRegex(MesherFailed, "region a has 1 triangles that are no boundary of the cells"):
            mesh.assemble(*two, {}, {"a": np.array([[1, 2, 3], [0, 1, 2]])})
