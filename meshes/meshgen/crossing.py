"""Pairs of triangles of a surface that are in contact or cross without sharing the nodes there."""

import numpy as np

LEAF = 40  # triangles in a box that is not divided further
CHUNK = 20_000  # pairs at a time


def crossings(points: np.ndarray, triangles: np.ndarray, tolerance: float) -> np.ndarray:
    """Pairs (k, 2) of triangles that come closer than `tolerance` to each other away from their shared nodes.

    Two triangles are apart if one of 17 axes separates them: the normals, the cross products of their edges, and the
    normals of the edges within the planes. For two triangles with a shared node, the edge opposite to it is compared with
    the other triangle; for two with a shared edge, the opposite corner."""
    corners = points[triangles]
    found = [np.zeros((0, 2), int)]
    pairs = candidates(corners.min(axis=1), corners.max(axis=1), tolerance)
    for start in range(0, len(pairs), CHUNK):
        part = pairs[start : start + CHUNK]
        a, b = triangles[part[:, 0]], triangles[part[:, 1]]
        shared_a, shared_b = (a[:, :, None] == b[:, None, :]).any(axis=2), (b[:, :, None] == a[:, None, :]).any(axis=2)
        hit = np.zeros(len(part), bool)
        for x, shared, y in ((a, shared_a, b), (b, shared_b, a)):
            tests = np.flatnonzero(shared.sum(axis=1) < 3)
            opposite = degenerate(points, x[tests], shared[tests])
            hit[tests] |= separation(opposite, points[y[tests]], tolerance) <= tolerance
        found.append(part[hit])
    return np.concatenate(found)


def degenerate(points: np.ndarray, triangles: np.ndarray, shared: np.ndarray) -> np.ndarray:
    """Corners (n, 3, 3) of the triangles, with shared nodes replaced by a node that is not shared."""
    free = np.argmax(~shared, axis=1)
    own = np.take_along_axis(triangles, free[:, None], axis=1)
    return points[np.where(shared, own, triangles)]


def separation(a: np.ndarray, b: np.ndarray, enough: float) -> np.ndarray:
    """Gap between the projections of two triangles (n, 3, 3) on the axis where it is largest, or on an axis where it exceeds `enough`.

    The normal and the sides of the second triangle separate most pairs; the other axes are for the rest."""
    gap = sides(a, b)
    rest = np.flatnonzero(gap <= enough)
    a, b = a[rest], b[rest]
    edges = [x[:, [1, 2, 0]] - x for x in (a, b)]
    normals = [np.cross(e[:, 0], e[:, 1]) for e in edges]
    across = np.cross(edges[0][:, :, None], edges[1][:, None, :]).reshape(len(a), 9, 3)
    within = np.cross(normals[0][:, None], edges[0])
    turned = np.cross(normals[1][:, None], edges[0])  # for a triangle that is degenerate to an edge
    along = a.mean(axis=1)[:, None] - b.mean(axis=1)[:, None]
    gap[rest] = np.maximum(gap[rest], projected(a, b, np.concatenate([normals[0][:, None], across, within, turned, *edges, along], axis=1)))
    return gap


def sides(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Largest gap along the normal of the second triangle and the normals of its edges in its plane."""
    edges = b[:, [1, 2, 0]] - b
    normal = np.cross(edges[:, 0], edges[:, 1])[:, None]
    return projected(a, b, np.concatenate([normal, np.cross(normal, edges)], axis=1))


def projected(a: np.ndarray, b: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Largest gap between the projections of two triangles (n, 3, 3) on axes (n, k, 3) of any length; axes of zero length do not count."""
    length = np.linalg.norm(axes, axis=2, keepdims=True)
    usable = length > 1e-12 * length.max(axis=1, keepdims=True, initial=1e-300)
    axes = axes / np.where(usable, length, 1)
    pa, pb = (a - b[:, :1]) @ axes.transpose(0, 2, 1), (b - b[:, :1]) @ axes.transpose(0, 2, 1)
    gap = np.maximum(pa.min(axis=1) - pb.max(axis=1), pb.min(axis=1) - pa.max(axis=1))
    return np.where(usable[:, :, 0], gap, -np.inf).max(axis=1)


def candidates(low: np.ndarray, high: np.ndarray, tolerance: float) -> np.ndarray:
    """Pairs (k, 2), i < j, whose boxes are closer than the tolerance, by recursive division of the space."""
    low, high = low - tolerance / 2, high + tolerance / 2
    found, todo = [np.zeros((0, 2), int)], [np.arange(len(low))]
    while todo:
        rows = todo.pop()
        halves = divided(rows, low, high) if len(rows) > LEAF else None
        if halves is None:
            found += overlapping(rows, low, high)
        else:
            todo += halves
    return np.unique(np.concatenate(found), axis=0)


def divided(rows: np.ndarray, low: np.ndarray, high: np.ndarray) -> list | None:
    """Two halves of some boxes along the axis that cuts fewest of them; None if it cuts too many."""
    best = None
    for axis in range(3):
        middle = np.median(low[rows, axis] + high[rows, axis]) / 2
        halves = [rows[low[rows, axis] <= middle], rows[high[rows, axis] > middle]]
        most = max(map(len, halves))
        if most <= 0.8 * len(rows) and (best is None or most < best[0]):
            best = (most, halves)
    return best and best[1]


def overlapping(rows: np.ndarray, low: np.ndarray, high: np.ndarray) -> list:
    """Blocks of pairs of some boxes that overlap."""
    blocks = []
    step = max(1, 1_000_000 // max(1, len(rows)))
    for start in range(0, len(rows), step):
        part = rows[start : start + step]
        meet = np.all((low[part, None] <= high[None, rows]) & (low[None, rows] <= high[part, None]), axis=2)
        i, j = np.nonzero(meet & (part[:, None] < rows[None, :]))
        blocks.append(np.stack([part[i], rows[j]], axis=1))
    return blocks


def crossing_point(a: np.ndarray, b: np.ndarray) -> np.ndarray | None:
    """The middle of the line along which two triangles (3, 3) cross; None if they only come close."""
    normals = [np.cross(x[1] - x[0], x[2] - x[0]) for x in (a, b)]
    along = np.cross(*normals)
    ends = []
    for own, other, normal in ((a, b, normals[1]), (b, a, normals[0])):
        height = (own - other[0]) @ normal
        cut = [i for i in range(3) if height[i] * height[(i + 1) % 3] < 0]
        if len(cut) != 2:
            return None
        at = [own[i] + height[i] / (height[i] - height[(i + 1) % 3]) * (own[(i + 1) % 3] - own[i]) for i in cut]
        ends.append(sorted(at, key=lambda point: float(point @ along)))
    low, high = (pick((end[k] for end in ends), key=lambda point: float(point @ along)) for k, pick in ((0, max), (1, min)))
    return (low + high) / 2 if (high - low) @ along > 0 else None


def place(points: np.ndarray, triangles: np.ndarray, pair: np.ndarray) -> np.ndarray:
    """A point [unit of the points] where two triangles are in contact, approximately: the middle of the overlap of their boxes."""
    boxes = [(points[triangles[i]].min(axis=0), points[triangles[i]].max(axis=0)) for i in pair]
    return (np.maximum(boxes[0][0], boxes[1][0]) + np.minimum(boxes[0][1], boxes[1][1])) / 2
