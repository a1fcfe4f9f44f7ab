"""Recovery after CGAL: each cell is in one solid, and edges are sharp or not."""

import unittest

import gmsh
import numpy as np

from meshgen import polygons, recover
from meshgen.geometry import Geometry
from meshgen.gmsh_driver import session
from meshgen.importer import named

from .shapes import prism


class Recover(unittest.TestCase):
    def test_solids_of_cells(self):
        """A centre outside of all solids, such as that of a chord of a hollow surface, belongs to the nearest solid."""
        with session():
            low, high = (gmsh.model.occ.addBox(0, 0, z, 10, 10, 5) for z in (0, 15))
            gmsh.model.occ.synchronize()
            geometry = named(Geometry([low, high], {}))
            _, skin = recover.skin(geometry, 1.0)
            heights = np.array([1.0, 4, 16, 19, 7, 9, 11, 13, -2, 22])
            found = recover.cell_regions(np.stack([np.full(10, 4.0), np.full(10, 6.0), heights], axis=1), skin, geometry)
        self.assertEqual(found["volume_1"].tolist(), (heights < 10).tolist())
        self.assertEqual(found["volume_2"].tolist(), (heights > 10).tolist())
        self.assertTrue(found["body"].all())

    def test_sharp_edges(self):
        """Edges at which a surface turns by more than 20 degrees."""
        for corners, sharp in ((8, 16 + 8), (12, 24 + 12), (24, 48)):
            around = 2 * np.pi * np.arange(corners) / corners
            points, faces = prism(np.stack([np.cos(around), np.sin(around)], axis=1).tolist(), 1)
            self.assertEqual(len(recover.sharp_middles(points, polygons.triangles(points, faces))), sharp)
