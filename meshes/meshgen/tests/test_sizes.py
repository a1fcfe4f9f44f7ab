"""Target counts, grading, nested families, seeds, reproducibility, both generators."""

import math
from pathlib import Path

import numpy as np

from .common import Case, read_msh

from meshgen import sizing
from meshgen.errors import SizeNotReached


class Sizes(Case):
    def test_target_counts(self):
        for cells, tolerance in ((1100, 0.1), (4500, 0.02)):  # the count of the coarse finger jumps
            manifest = self.made("finger", size={"cells": cells})
            self.assertAlmostEqual(manifest["cells"], cells, delta=tolerance * cells)

    def test_a_bound_of_the_count_is_noticed(self):
        """The faces of a body allow no fewer than some 2700 cells, with a scatter of 4 %."""
        lengths = []

        def generate(length: float, _jitter: int) -> int:
            lengths.append(length)
            return round(2720 + 110 * abs(math.sin(7 * len(lengths))) + (0.003 / length) ** 3 * 20000)

        with self.assertRaises(SizeNotReached) as refused:
            sizing.find_length(generate, 4e-5, 1500, 0.02, lambda _: None)
        self.assertLessEqual(len(lengths), 7)
        self.assertLess(lengths[-1], 0.3)
        self.assertRegex(refused.exception.error, "not reached .* the faces of the body allow no fewer than about 27.. cells")
        self.assertRegex(refused.exception.hint, "ask for cells = 3[34]00 or more")
        with self.assertRaises(SizeNotReached) as refused:
            sizing.find_length(generate, 4e-5, 1500, 0.02, lambda _: None, "the graded lengths")
        self.assertIn("the graded lengths", refused.exception.error)
        self.assertTrue(sizing.find_length(generate, 4e-5, 3300, 0.02, lambda _: None))

    def test_same_request_same_bytes(self):
        for generator in ("gmsh", "cgal"):
            for name in ("a.msh.gz", "b.msh.gz"):
                self.made("finger", name=name, generator=generator, size={"length": 0.006}, seed=3)
            self.assertEqual(Path(self.path("a.msh.gz")).read_bytes(), Path(self.path("b.msh.gz")).read_bytes())

    def test_seeds_are_samples_of_one_size(self):
        for generator in ("gmsh", "cgal"):
            counts = [self.made("finger", generator=generator, size={"length": 0.005}, seed=seed)["cells"] for seed in (0, 1, 2)]
            self.assertEqual(len(set(counts)), 3)
            self.assertLess(max(counts) / min(counts), 1.25)

    def test_nested(self):
        base = self.made("cylinder", size={"length": 0.006})
        nested = self.made("cylinder", size={"length": 0.006, "levels": 2})
        self.assertEqual(nested["cells"], 64 * base["cells"])
        for name, region in base["regions"].items():
            factor = 64 if region["dim"] == 3 else 16
            self.assertEqual(nested["regions"][name]["count"], factor * region["count"])
        self.assertAlmostEqual(base["volume_error"] / nested["volume_error"], 16, delta=3)  # nodes are on the CAD
        self.assertGreater(self.made("thick_sphere", size={"length": 0.006, "levels": 1}, order=2)["quality"]["jacobian_min"], 0)

    def test_curved_cells_of_a_coarse_finger_are_valid(self):
        manifest = self.made("finger", size={"length": 0.005, "levels": 1}, order=2)
        self.assertGreaterEqual(manifest["quality"]["jacobian_min"], 0.0999)
        self.assertGreater(manifest["straightened_edges"], 0)
        self.assertTrue(1e-5 < manifest["straightened_m"] < 0.0025)  # half of an edge

    def test_grading(self):
        plain = self.made("finger", size={"length": 0.006})
        fine = [{"feature": name, "length": 0.002, "distance": 0.003} for name in ("notches", "guides")]
        graded = self.made("finger", size={"length": 0.006}, grading=fine)
        self.assertGreater(graded["regions"]["notches"]["count"], 3 * plain["regions"]["notches"]["count"])
        self.assertLess(graded["regions"]["root"]["count"], 3 * plain["regions"]["root"]["count"])
        self.refused(2, "no grading feature", "finger", size={"length": 0.006}, grading=[fine[0] | {"feature": "nose"}])

    def test_grading_at_a_face_is_even(self):
        """All facets of a graded face have the length also where the distance is small against the face."""
        fine = {"feature": "xmin", "length": 0.01}
        for distance in (0.001, 0.02):
            manifest = self.made("block", size={"length": 0.03}, grading=[fine | {"distance": distance}])
            mesh = read_msh(self.path("mesh.msh.gz"))
            tag = mesh["names"]["xmin"][1]
            x = mesh["nodes"][np.concatenate([rows for key, rows in mesh["elements"].items() if key[0] == 2 and tag in mesh["groups"][key]])]
            self.assertLess(np.linalg.norm(x - x[:, [1, 2, 0]], axis=2).max(), 0.02)
            self.assertGreater(manifest["regions"]["xmin"]["count"], 3 * manifest["regions"]["xmax"]["count"])
        self.refused(2, "is less than a 500th of the diagonal", "block", size={"length": 0.03}, grading=[fine | {"distance": 1e-4}])

    def test_grading_at_points_and_in_a_box(self):
        size, fine = {"length": 0.012}, {"length": 0.002, "distance": 0.006}

        def corner(grading: list) -> tuple:
            """All nodes, and the number of cells whose middle is within 6 mm of the lower corner."""
            self.made("block", size=size, grading=grading)
            mesh = read_msh(self.path("mesh.msh.gz"))
            corners = np.concatenate([e for (dim, _), e in mesh["elements"].items() if dim == 3])
            middles = mesh["nodes"][corners].mean(axis=1)
            return mesh["nodes"], np.sum(np.max(middles - mesh["nodes"].min(axis=0), axis=1) < 0.006)

        nodes, coarse = corner([])
        low, high = nodes.min(axis=0), nodes.max(axis=0)
        for place in ({"points": [low.tolist()]}, {"box": [low.tolist(), (low + 0.002).tolist()]}):
            # Lengths of 2 in place of 12 mm: a cube of 6 mm has some 5.5·3³ cells in place of less than one
            self.assertGreater(corner([fine | place])[1], 60 + coarse)
        far = (high + 1).tolist()
        self.refused(2, "does not reach the body", "block", size=size, grading=[fine | {"points": [far]}])
        self.refused(2, "does not reach the body", "block", size=size, grading=[fine | {"box": [far, far]}])
        for place in ({"points": []}, {"points": [[0, 0]]}, {"box": [far, low.tolist()]}, {"feature": 1}, {}, {"feature": "xmin", "points": [far]}):
            self.refused(2, "grading", "block", size=size, grading=[fine | place])

    def test_a_size_field_multiplies_the_length(self):
        even = self.made("block", size={"length": 0.012})
        mesh = read_msh(self.path("mesh.msh.gz"))
        cells = np.concatenate([e for (dim, _), e in mesh["elements"].items() if dim == 3])
        x = mesh["nodes"][:, 0]
        share = (x - x.min()) / np.ptp(x)
        field = {"points": mesh["nodes"].tolist(), "cells": cells.tolist()}
        half = self.made("block", size={"length": 0.024}, field=field | {"sizes": [0.5] * len(x)})
        self.assertAlmostEqual(half["cells"] / even["cells"], 1, delta=0.1)
        self.made("block", size={"length": 0.012}, field=field | {"sizes": (0.4 + share).tolist()})
        graded = read_msh(self.path("mesh.msh.gz"))
        corners = np.concatenate([e for (dim, _), e in graded["elements"].items() if dim == 3])
        middle = (graded["nodes"][corners].mean(axis=1)[:, 0] - x.min()) / np.ptp(x)
        # Edge lengths of .4 to .9 and of .9 to 1.4: the mean of 1/h³ over the halves differs by a factor of 5.
        self.assertGreater(np.sum(middle < 0.5), 3 * np.sum(middle > 0.5))

    def test_cgal(self):
        manifest = self.made("finger", generator="cgal", size={"cells": 3000})
        self.covers_boundary(manifest)
        self.assertAlmostEqual(manifest["cells"], 3000, delta=60)
        self.assertLess(abs(manifest["volume_error"]), 0.03)
        self.assertTrue(0 < manifest["edge_error_m"] < 0.003)
        mesh = read_msh(self.path("mesh.msh.gz"))
        dim, tag = mesh["names"]["root"]
        root = np.concatenate([e for key, e in mesh["elements"].items() if key[0] == dim and tag in mesh["groups"][key]])
        self.assertLess(mesh["nodes"][root][:, :, 0].mean(), 5e-4)
        x = mesh["nodes"][root]
        area = np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1).sum() / 2
        self.assertAlmostEqual(area / 4e-4, 1, delta=0.1)

    def test_cgal_criteria(self):
        """Those of a request are kept also where a number of cells is wanted."""
        given = {"facet_approximation": 0.003}
        manifest = self.made("block", generator="cgal", cgal=given, size={"cells": 1500})
        self.assertEqual(manifest["cgal"]["facet_approximation"], 0.003)
        self.assertEqual(manifest["cgal"]["cell_size"], manifest["length_m"])
        self.refused(2, "nothing that cells could change", "dumbbell", generator="cgal", cgal={"facet_size": 0.01, "cell_size": 0.01}, size={"cells": 600})
        sizes = {"facet_size": 0.004, "facet_approximation": 0.0005, "cell_size": 0.004}
        manifest = self.made("dumbbell", generator="cgal", cgal=sizes | {"facet_angle": 30, "odt": True, "perturb": False})
        self.assertEqual(manifest["cgal"]["facet_size"], 0.004)
        self.assertEqual((manifest["cgal"]["odt"], manifest["cgal"]["perturb"], manifest["cgal"]["lloyd"]), (True, False, False))
        self.assertAlmostEqual(manifest["regions"]["gauge"]["count"] / manifest["cells"], 0.12, delta=0.08)
