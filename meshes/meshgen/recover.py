"""Recovery after CGAL: regions by projection on the CAD faces, and the rounding of sharp edges. Lengths in mm."""

from dataclasses import dataclass

import gmsh
import numpy as np

from . import surface
from .geometry import MM, Geometry, boundary_faces
from .gmsh_driver import collect_elements, collect_nodes

PER_CIRCLE = 48  # triangles around a full circle of the CAD
SHARP = np.cos(np.radians(20))  # faces at an angle of more than 20° form a sharp edge
MOST = 300_000  # triangles of a divided surface
CHUNK = 2_000_000  # distances at a time


@dataclass
class Skin:
    """A fine triangulation of the boundary: points, outward triangles, and the face of each triangle."""

    points: np.ndarray
    triangles: np.ndarray
    face: np.ndarray


def skin(geometry: Geometry, size: float) -> tuple:
    """The outer faces of the CAD in triangles with edges of at most `size` [mm]: a closed surface, and its skin."""
    geometry.clear_mesh()
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", PER_CIRCLE)
    gmsh.model.mesh.generate(2)
    points, row = collect_nodes()
    faces = boundary_faces(geometry.volumes)
    blocks = [row[collect_elements(2, [face])] for face in faces]
    used, triangles = np.unique(np.concatenate(blocks), return_inverse=True)
    body = surface.closed(points[used] / MM, triangles.reshape(-1, 3))
    return body, Skin(body.points, body.triangles, np.repeat(faces, [len(block) for block in blocks]))


def fine(points: np.ndarray, triangles: np.ndarray, face: np.ndarray, size: float) -> tuple:
    """Points, triangles and faces of a surface whose triangles are halved until their edges are at most `size`.

    Neighbours may be divided differently, which does not affect distances."""
    corners = points[triangles]
    while len(corners) < MOST:
        lengths = np.linalg.norm(corners[:, [1, 2, 0]] - corners, axis=2)
        i = lengths.argmax(axis=1)
        long = np.flatnonzero(lengths.max(axis=1) > size)
        if not len(long):
            break
        a, b, c = (corners[long, (i[long] + k) % 3] for k in range(3))
        middle = (a + b) / 2
        corners = np.concatenate([np.delete(corners, long, axis=0), np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        face = np.concatenate([np.delete(face, long), face[long], face[long]])
    return corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3), face


def nearest_faces(points: np.ndarray, facets: np.ndarray, skin: Skin) -> np.ndarray:
    """Face of each facet: the face nearest to its centre,
    where a normal that differs by an angle a counts as an additional distance of (1 - cos a) times the facet's size."""
    corners = points[facets]
    centres, normals, sizes = corners.mean(axis=1), *unit_normals(corners)
    tags = np.unique(skin.face)
    score = np.empty((len(facets), len(tags)))
    for column, tag in enumerate(tags):
        patch = skin.points[skin.triangles[skin.face == tag]]
        nearest = nearest_rows(centres, patch.mean(axis=1), 1)[:, 0]
        distance = triangle_distance(centres, patch[nearest])
        agreement = np.einsum("ij,ij->i", normals, unit_normals(patch)[0][nearest])
        score[:, column] = distance + (1 - agreement) * sizes
    return tags[np.argmin(score, axis=1)]


def cell_regions(centres: np.ndarray, skin: Skin, geometry: Geometry) -> dict:
    """Masks of the cells in every cell region, by the solid that holds their centre; a region of all volumes gets all cells.

    Cells that are chords of a hollow surface have their centre in no solid: they belong to the one with the nearest triangle of the skin."""
    owner = np.zeros(len(centres), int)
    if len(geometry.volumes) > 1:
        for row, centre in enumerate(centres.tolist()):
            owner[row] = next((v for v in geometry.volumes if gmsh.model.isInside(3, v, centre)), 0)
        outside = owner == 0
        solid = {face: v for v in geometry.volumes for face in boundary_faces([v])}
        nearest = nearest_rows(centres[outside], skin.points[skin.triangles].mean(axis=1), 1)[:, 0]
        owner[outside] = [solid[face] for face in skin.face[nearest].tolist()]
    return {
        name: np.isin(owner, tags) | (set(tags) == set(geometry.volumes))
        for name, (dim, tags) in geometry.regions.items()
        if dim == 3
    }


def edge_error(points: np.ndarray, facets: np.ndarray, skin: Skin) -> float:
    """Largest distance from a sharp CAD edge to the mesh's boundary."""
    return farthest(points, facets, sharp_middles(skin.points, skin.triangles))


def sharp_middles(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Middles (k, 3) of the sharp edges of a closed surface."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    owner = np.tile(np.arange(len(triangles)), 3)
    _, place = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    a, b = np.argsort(place.ravel(), kind="stable").reshape(-1, 2).T
    normals = unit_normals(points[triangles])[0]
    sharp = np.einsum("ij,ij->i", normals[owner[a]], normals[owner[b]]) < SHARP
    return points[edges[a[sharp]]].mean(axis=1)


def farthest(points: np.ndarray, facets: np.ndarray, samples: np.ndarray) -> float:
    """Largest distance from a sample (k, 3) to the facets; zero without samples."""
    if not len(samples):
        return 0.0
    corners = points[facets]
    near = nearest_rows(samples, corners.mean(axis=1), min(24, len(facets)))
    distances = [triangle_distance(samples, corners[near[:, k]]) for k in range(near.shape[1])]
    return float(np.min(distances, axis=0).max())


def unit_normals(corners: np.ndarray) -> tuple:
    """Unit normals of triangles (n, 3, 3), and their sizes (root of the area)."""
    vector = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(vector, axis=1)
    return vector / np.maximum(length, 1e-300)[:, None], np.sqrt(length / 2)


def nearest_rows(queries: np.ndarray, targets: np.ndarray, count: int) -> np.ndarray:
    """Rows of the `count` nearest targets of every query point."""
    found = np.empty((len(queries), count), int)
    step = max(1, CHUNK // len(targets))
    square = (targets**2).sum(axis=1)
    for start in range(0, len(queries), step):
        distance = square - 2 * queries[start : start + step] @ targets.T
        found[start : start + step] = (
            distance.argmin(axis=1)[:, None] if count == 1 else np.argpartition(distance, count - 1, axis=1)[:, :count]
        )
    return found


def triangle_distance(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Distance of each point (n, 3) to its own triangle (n, 3, 3)."""
    normal = unit_normals(corners)[0]
    offset = np.einsum("ij,ij->i", points - corners[:, 0], normal)
    foot = points - offset[:, None] * normal
    inside = np.ones(len(points), bool)
    nearest = np.full(len(points), np.inf)
    for i in range(3):
        a, edge = corners[:, i], corners[:, (i + 1) % 3] - corners[:, i]
        inside &= np.einsum("ij,ij->i", np.cross(edge, foot - a), normal) >= 0
        along = np.einsum("ij,ij->i", points - a, edge) / np.maximum(np.einsum("ij,ij->i", edge, edge), 1e-300)
        on_edge = a + np.clip(along, 0, 1)[:, None] * edge
        nearest = np.minimum(nearest, np.linalg.norm(points - on_edge, axis=1))
    return np.where(inside, np.abs(offset), nearest)
