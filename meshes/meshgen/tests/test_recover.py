"""Recovery of the regions after CGAL: each cell is in one solid."""

import unittest

import gmsh
import numpy as np

from meshgen import recover
from meshgen.geometry import Geometry
from meshgen.gmsh_driver import session
from meshgen.importer import named


class Recover(unittest.TestCase):
    def test_solids_of_cells(self):
        """A centre in no solid, as that of a chord of a hollow, belongs to the nearest one."""
        with session():
            low, high = (gmsh.model.occ.addBox(0, 0, z, 10, 10, 5) for z in (0, 15))
            gmsh.model.occ.synchronize()
            geometry = named(Geometry([low, high], {}))
            skin = recover.skin(geometry, 1.0)
            heights = np.array([1.0, 4, 16, 19, 7, 9, 11, 13, -2, 22])
            found = recover.cell_regions(np.stack([np.full(10, 4.0), np.full(10, 6.0), heights], axis=1), skin, geometry)
        self.assertEqual(found["volume_1"].tolist(), (heights < 10).tolist())
        self.assertEqual(found["volume_2"].tolist(), (heights > 10).tolist())
        self.assertTrue(found["body"].all())
