"""Every body: volume, regions, shape of the file."""

import math
import unittest.mock
from pathlib import Path

import numpy as np

from .common import Case, defaults, read_msh

from meshgen import bodies


class Bodies(Case):
    def check(self, manifest: dict, body: str, volume: float, places: float) -> None:
        self.covers_boundary(manifest)
        self.assertEqual(set(manifest["regions"]), set(bodies.declaration(body)["regions"]))
        self.assertAlmostEqual(manifest["volume_cad_m3"] / volume, 1, delta=1e-9)
        self.assertAlmostEqual(manifest["volume_m3"] / volume, 1, delta=places)
        self.assertGreater(manifest["quality"]["sicn_min"], 0.1)
        self.assertAlmostEqual(manifest["h_m"], (manifest["volume_m3"] / manifest["cells"]) ** (1 / 3))

    def test_block_and_beam_are_exact(self):
        self.check(self.made("block", size={"length": 0.04}), "block", 1e-3, 1e-12)
        self.check(self.made("beam", size={"length": 0.005}, order=2), "beam", 1e-5, 1e-9)

    def test_python_that_cannot_be_loaded(self):
        with unittest.mock.patch.object(bodies.importlib, "import_module", side_effect=ModuleNotFoundError("No module named 'cadquery'")):
            self.refused(2, "block/geometry.py cannot be loaded: No module named 'cadquery'", "block", size={"length": 0.04})

    def test_cylinder(self):
        volume = math.pi * 0.01**2 * 0.04
        self.check(self.made("cylinder", size={"length": 0.004}), "cylinder", volume, 0.03)
        self.check(self.made("cylinder", size={"length": 0.004}, order=2), "cylinder", volume, 1e-4)

    def test_thick_sphere(self):
        volume = math.pi / 6 * (0.02**3 - 0.01**3)
        self.check(self.made("thick_sphere", size={"length": 0.004}, order=2), "thick_sphere", volume, 1e-4)

    def test_pneunet(self):
        # Plate and the bellows above it, less five chambers and the four pieces of channel between them
        volume = (56 * 16 * 7 + 5 * 8 * 16 * 10 - 5 * 4 * 12 * 12 - 4 * 6 * 3 * 2) * 1e-9
        self.check(self.made("pneunet", size={"length": 0.003}), "pneunet", volume, 1e-12)

    def quadrant(self, p, half):
        """Area of a quarter of a dumbbell up to x = half, beyond its arcs."""
        # Gauge, rising arcs (the outline is point-symmetric in slope, not in height), end.
        big, small = p["inner_radius"], p["outer_radius"]
        angle = math.acos(1 - (p["grip_width"] - p["gauge_width"]) / 2 / (big + small))
        run1, run2 = big * math.sin(angle), small * math.sin(angle)
        under_arc1 = run1 * (p["gauge_width"] / 2 + big) - (big**2 / 2) * (angle + math.sin(2 * angle) / 2)
        under_arc2 = run2 * (p["grip_width"] / 2 - small) + (small**2 / 2) * (angle + math.sin(2 * angle) / 2)
        straight = p["gauge_length"] / 2 * p["gauge_width"] / 2
        end = (half - p["gauge_length"] / 2 - run1 - run2) * p["grip_width"] / 2
        return straight + under_arc1 + under_arc2 + end

    def test_dumbbell_octant(self):
        p = defaults("dumbbell_octant")
        volume = self.quadrant(p, p["grip_distance"] / 2) * p["thickness"] / 2
        self.check(self.made("dumbbell_octant", size={"length": 0.002}), "dumbbell_octant", volume, 1e-3)

    def test_dumbbell(self):
        p = defaults("dumbbell")
        volume = 4 * self.quadrant(p, p["length"] / 2) * p["thickness"]
        manifest = self.made("dumbbell", size={"length": 0.003})
        self.check(manifest, "dumbbell", volume, 1e-3)
        mesh = read_msh(self.path("mesh.msh.gz"))
        dim, tag = mesh["names"]["gauge"]
        for (d, entity), groups in mesh["groups"].items():
            if d == dim and tag in groups:
                x = mesh["nodes"][mesh["elements"][d, entity]][:, :, 0]
                self.assertAlmostEqual(np.abs(x).max(), p["gauge_length"] / 2, places=9)
        self.assertEqual(sum(len(e) for (d, _), e in mesh["elements"].items() if d == 3), manifest["cells"])

    def test_finger(self):
        manifest = self.made("finger", size={"length": 0.004}, order=2)
        self.covers_boundary(manifest)
        notch = 20 * (8 * 12 - 2 * (9 - math.pi * 9 / 4))
        prism = (100 * 20 * 20 - 3 * notch) * 1e-9
        self.assertTrue(0.98 < manifest["volume_cad_m3"] / prism < 0.99)  # what the fillets of the tip take away
        self.assertAlmostEqual(manifest["volume_error"], 0, delta=5e-5)
        self.assertGreaterEqual(manifest["quality"]["jacobian_min"], 0.1)
        self.assertEqual([manifest["straightened_edges"], manifest["straightened_m"]], [0, 0])
        cable = manifest["paths"]["cable"]
        xs = [0.0045, 0.0145, 0.0315, 0.0415, 0.0585, 0.0685, 0.0855, 0.0905]
        np.testing.assert_allclose(cable["guides"], [[x, 0.01, 0.005] for x in xs], atol=1e-12)
        np.testing.assert_allclose(cable["pull_point"], [-0.01, 0.01, 0.005], atol=1e-12)
        self.assertAlmostEqual(cable["guide_radius"], 0.004)
        self.facets_lie_where_they_should(read_msh(self.path("mesh.msh.gz")))

    def facets_lie_where_they_should(self, mesh: dict) -> None:
        """Coordinates and areas of the finger's flat regions."""
        expected = {"root": (0, 0.0, 4e-4), "tip": (0, 0.1, 64e-6), "back": (2, 0.02, None), "palm": (2, 0.0, None)}
        for name, (axis, value, area) in expected.items():
            facets = self.facets(mesh, name)
            x = mesh["nodes"][facets]
            self.assertEqual(np.abs(x[:, :, axis] - value).max(), 0)
            normal = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
            self.assertTrue(np.all(normal[:, axis] * (-1 if value == 0 else 1) > 0), f"{name} must point outward")
            if area:
                self.assertAlmostEqual(np.linalg.norm(normal, axis=1).sum() / 2, area, delta=1e-12)

    def facets(self, mesh: dict, name: str) -> np.ndarray:
        wanted = mesh["names"][name]
        return np.concatenate([e for key, e in mesh["elements"].items() if key[0] == wanted[0] and wanted[1] in mesh["groups"][key]])

    def test_finger_without_fillets(self):
        sharp = defaults("finger", notch_fillet=0.0, tip_radius=0.0)
        manifest = self.made("finger", sharp, size={"length": 0.006})
        self.assertAlmostEqual(manifest["volume_m3"], (40000 - 3 * 20 * 96) * 1e-9, delta=1e-15)
        full = defaults("finger", notch_fillet=0.004, phalanges=3.0)
        self.covers_boundary(self.made("finger", full, size={"length": 0.006}))
        self.assertTrue(Path(self.path("mesh.msh.gz")).exists())
