"""Quality of a mesh: shape of the straight cells, bounds on the Jacobian of curved ones, volume."""

import numpy as np

from .mesh import EDGES, TetMesh, corner_volumes

# Lattice points of degree 3 on the tetrahedron (barycentric, exponents of the Bernstein polynomials).
LATTICE = np.array([(3 - i - j - k, i, j, k) for i in range(4) for j in range(4 - i) for k in range(4 - i - j)])
FACTORIAL = np.array([1, 1, 2, 6])
BERNSTEIN = 6 / FACTORIAL[LATTICE].prod(axis=1) * ((LATTICE[:, None, :] / 3) ** LATTICE[None]).prod(axis=2)
TO_BERNSTEIN = np.linalg.inv(BERNSTEIN)


def report(mesh: TetMesh) -> dict:
    """The manifest's `quality`. Shapes are those of the straight cells; `jacobian_min` (order 2 only) is the
    smallest Bernstein coefficient of det J over the cell's straight 6V: if it is positive, the cell is valid everywhere."""
    sicn, ratio, dihedral = shapes(mesh.points, mesh.cells)
    quality = {
        "sicn_min": sicn.min(),
        "sicn_mean": sicn.mean(),
        "radius_ratio_min": ratio.min(),
        "radius_ratio_mean": ratio.mean(),
        "dihedral_min_deg": dihedral.min(),
        "dihedral_max_deg": dihedral.max(),
    }
    if mesh.order == 2:
        quality["jacobian_min"] = relative_jacobian(mesh.points, mesh.cells).min()
    return {name: float(value) for name, value in quality.items()}


def volume(mesh: TetMesh) -> float:
    """Volume of the mesh [m³]; exact for curved cells (the mean of a Bernstein polynomial's coefficients)."""
    if mesh.order == 1:
        return float(corner_volumes(mesh.points, mesh.cells).sum())
    return float(jacobian_coefficients(mesh.points, mesh.cells).mean(axis=1).sum() / 6)


def shapes(points: np.ndarray, cells: np.ndarray) -> tuple:
    """SICN, radius ratio 3r/R and dihedral angles [degrees] of the straight cells; the first two are 1 for the regular tetrahedron.

    SICN is gmsh's signed inverse condition number: 3 det S / (|S| |adj S|), S = J · (regular)^-1."""
    x = points[cells[:, :4]]
    jacobian = np.stack([x[:, 1] - x[:, 0], x[:, 2] - x[:, 0], x[:, 3] - x[:, 0]], axis=2)
    regular = np.array([[1, 0.5, 0.5], [0, 3**0.5 / 2, 3**0.5 / 6], [0, 0, (2 / 3) ** 0.5]])
    s = jacobian @ np.linalg.inv(regular)
    adjugate = np.stack([np.cross(s[:, :, 1], s[:, :, 2]), np.cross(s[:, :, 2], s[:, :, 0]), np.cross(s[:, :, 0], s[:, :, 1])], axis=1)
    sicn = 3 * np.linalg.det(s) / (np.linalg.norm(s, axis=(1, 2)) * np.linalg.norm(adjugate, axis=(1, 2)))

    def area_vector(i, j, k):
        return np.cross(x[:, j] - x[:, i], x[:, k] - x[:, i]) / 2

    outward = np.stack([area_vector(1, 2, 3), area_vector(0, 3, 2), area_vector(0, 1, 3), area_vector(0, 2, 1)], axis=1)
    areas = np.linalg.norm(outward, axis=2)
    volumes = np.linalg.det(jacobian) / 6
    a, b, c = (np.linalg.norm(x[:, i] - x[:, 0], axis=1) * np.linalg.norm(x[:, j] - x[:, k], axis=1) for i, j, k in [(1, 2, 3), (2, 1, 3), (3, 1, 2)])
    circum = np.sqrt(np.maximum((a + b + c) * (a + b - c) * (a - b + c) * (-a + b + c), 0)) / (24 * np.abs(volumes))
    ratio = 3 * (3 * volumes / areas.sum(axis=1)) / circum
    normals = outward / areas[:, :, None]
    cosines = np.stack([-(normals[:, i] * normals[:, j]).sum(axis=1) for i in range(4) for j in range(i)], axis=1)
    return sicn, ratio, np.degrees(np.arccos(np.clip(cosines, -1, 1)))


def jacobian_coefficients(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """The 20 Bernstein coefficients of det J of every 10-node cell [m³]; they bound it from both sides."""
    x = points[cells]
    values = np.stack([np.linalg.det(np.einsum("nia,ib->nab", x, shape_gradients(b / 3))) for b in LATTICE], axis=1)
    return values @ TO_BERNSTEIN.T


def relative_jacobian(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Lower bound of det J of every 10-node cell over that of its straight tetrahedron."""
    return jacobian_coefficients(points, cells).min(axis=1) / (6 * corner_volumes(points, cells))


def shape_gradients(b: np.ndarray) -> np.ndarray:
    """Gradients (10, 3) of the quadratic shape functions at barycentric coordinates b."""
    corner = np.array([[-1.0, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    return np.concatenate([
        (4 * b[:, None] - 1) * corner,
        4 * (b[EDGES[:, :1]] * corner[EDGES[:, 1]] + b[EDGES[:, 1:]] * corner[EDGES[:, 0]]),
    ])
