"""Polygons of surface files cut into triangles."""

import numpy as np


def triangles(points: list | np.ndarray, polygons: list) -> np.ndarray:
    """Triangles (m, 3) of polygons of nodes: fans from the first corner, or ear clipping if a triangle of the fan is inverted, as in concave polygons."""
    points = np.asarray(points, float).reshape(-1, 3)
    short = next((polygon for polygon in polygons if len(polygon) < 3), None)
    if short is not None:
        raise ValueError(f"a face has {len(short)} corners")
    cut = [[[face[0], face[i], face[i + 1]] for i in range(1, len(face) - 1)] for face in polygons]
    found = np.array([triangle for fan in cut for triangle in fan], int).reshape(-1, 3)
    if found.min(initial=0) < 0 or found.max(initial=-1) >= len(points):
        raise ValueError(f"a face refers to a node that is none of the {len(points)}")
    owner = np.repeat(np.arange(len(cut)), np.array([len(fan) for fan in cut], int))
    vectors = np.cross(points[found[:, 1]] - points[found[:, 0]], points[found[:, 2]] - points[found[:, 0]])
    normals = np.zeros((len(cut), 3))
    np.add.at(normals, owner, vectors)
    turned = np.unique(owner[np.einsum("ij,ij->i", vectors, normals[owner]) < 0]).tolist()
    for face in turned:
        nodes = np.array(polygons[face])
        rows = ears(flat(points[nodes], normals[face]))
        cut[face] = nodes[rows].tolist() if rows else cut[face]
    return np.array([triangle for fan in cut for triangle in fan], int).reshape(-1, 3) if turned else found


def flat(corners: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Project a polygon onto two coordinates, in which it runs counterclockwise; its normal is steepest along the third."""
    axis = int(np.argmax(np.abs(normal)))
    kept = [(axis + 1) % 3, (axis + 2) % 3]
    return corners[:, kept if normal[axis] > 0 else kept[::-1]]


def ears(corners: np.ndarray) -> list:
    """Triangles of a counterclockwise polygon (n, 2), clipped corner by corner; empty if the polygon crosses itself.

    A corner is clipped if no other corner lies in its triangle (the two ears theorem, Meisters, 1975)."""
    left, found = list(range(len(corners))), []
    while len(left) > 3:
        ring = corners[left]
        before, after = np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0)
        convex = np.flatnonzero(turn(before, ring, after) > 0).tolist()
        ear = next((i for i in convex if not holds(ring, (before[i], ring[i], after[i]))), None)
        if ear is None:
            return []
        found.append([left[ear - 1], left[ear], left[(ear + 1) % len(left)]])
        rest = left[ear + 1 :] + left[:ear]
        left = rest[1:] + rest[:1]  # The search continues one corner further, so that triangles do not form a narrow fan
    return [*found, left]


def holds(points: np.ndarray, triangle: tuple) -> bool:
    """Whether any of the points (n, 2) lies in a counterclockwise triangle or on its sides, and not in a corner of it."""
    a, b, c = triangle
    inside = (turn(a, b, points) >= 0) & (turn(b, c, points) >= 0) & (turn(c, a, points) >= 0)
    return bool(np.any(inside & ~np.any([np.all(points == corner, axis=1) for corner in triangle], axis=0)))


def turn(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Twice the area of the triangles of points (…, 2), positive if they run counterclockwise."""
    u, v = b - a, c - a
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
