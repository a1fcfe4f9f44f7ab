"""Closed triangle surfaces: their shells, and which of them are outer surfaces and which are walls of cavities."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from .errors import BadRequest


@dataclass
class Surface:
    """Shells that enclose one or several solids; triangles are in contact only at shared nodes.

    points     (n, 3)
    triangles  (m, 3), normals point out of the solid: away from it on outer shells, into the hollow on cavities
    shell      (m,) number of the shell of every triangle
    solids     [[outer shell, cavity, cavity, …], …]
    repairs    what was changed, in words
    """

    points: np.ndarray
    triangles: np.ndarray
    shell: np.ndarray
    solids: list
    repairs: list = field(default_factory=list)

    def volume(self) -> float:
        """Volume of all solids."""
        return volume(self.points, self.triangles)

    def cavities(self) -> dict:
        """Volume of each cavity by the name of its region."""
        shells = {name: own for name, own in self.regions().items() if name.startswith("cavity")}
        each = {name: own for name, own in shells.items() if len(own) == 1}
        return {name: abs(volume(self.points, self.triangles[self.shell == own[0]])) for name, own in each.items()}

    def scaled(self, factor: float) -> "Surface":
        """The surface in another unit."""
        return Surface(self.points * factor, self.triangles, self.shell, self.solids, self.repairs)

    def regions(self) -> dict:
        """Shells by the names of their regions: `outer` and `cavity`, numbered where there are several."""
        outer = [solid[0] for solid in self.solids]
        cavities = [shell for solid in self.solids for shell in solid[1:]]
        return numbered("outer", outer) | numbered("cavity", cavities)


def numbered(name: str, shells: list) -> dict:
    """The name for all shells together and, if there are several, the name with a number for each."""
    each = {f"{name}_{i}": [shell] for i, shell in enumerate(shells, 1)} if len(shells) > 1 else {}
    return ({name: shells} if shells else {}) | each


def closed(points: np.ndarray, triangles: np.ndarray) -> Surface:
    """The closed surface of triangles in any orientation."""
    turned = neighbours(triangles)
    if turned is None:
        raise BadRequest("the surface is not closed", "give a closed surface")
    shell, reverse, _ = walk(turned)
    triangles, solids = nested(points, np.where(reverse[:, None], triangles[:, [0, 2, 1]], triangles), shell)
    return Surface(points, triangles, shell, solids)


def edges_of(triangles: np.ndarray) -> tuple:
    """All directed edges (3m, 2), and the triangle of each."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return edges, np.tile(np.arange(len(triangles)), 3)


def edge_groups(triangles: np.ndarray) -> tuple:
    """Distinct edges (k, 2), the edge of each directed edge (3m,), and how many triangles share each edge (k,)."""
    edges, _ = edges_of(triangles)
    keys, place, counts = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    return keys, place.ravel(), counts


def neighbours(triangles: np.ndarray) -> list | None:
    """For every triangle its neighbours across the edges, each with whether one of the two must be reversed to agree.

    None if some edge does not have two triangles."""
    edges, owner = edges_of(triangles)
    _, place, counts = edge_groups(triangles)
    if np.any(counts != 2):
        return None
    forward = edges[:, 0] < edges[:, 1]
    pair = np.argsort(place, kind="stable").reshape(-1, 2)
    same = forward[pair[:, 0]] == forward[pair[:, 1]]
    found = [[] for _ in triangles]
    for (a, b), turn in zip(owner[pair].tolist(), same.tolist()):
        found[a].append((b, turn))
        found[b].append((a, turn))
    return found


def walk(neighbours: list) -> tuple:
    """Shell of every triangle, whether it must be reversed to agree with most of its shell, and a triangle that cannot agree."""
    conflict = None
    shell, turned = np.full(len(neighbours), -1), np.zeros(len(neighbours), bool)
    number = -1
    for start in range(len(neighbours)):
        if shell[start] >= 0:
            continue
        number += 1
        shell[start] = number
        queue = deque([start])
        while queue:
            here = queue.popleft()
            for there, turn in neighbours[here]:
                if shell[there] < 0:
                    shell[there], turned[there] = number, turned[here] ^ turn
                    queue.append(there)
                elif turned[there] != turned[here] ^ turn:
                    conflict = there
    for own in range(number + 1):
        rows = shell == own
        if turned[rows].mean() > 0.5:
            turned[rows] ^= True
    return shell, turned, conflict


def nested(points: np.ndarray, triangles: np.ndarray, shell: np.ndarray) -> tuple:
    """The triangles with normals pointing out of the solids, and the solids as lists of shells, the outer shell first.

    A shell inside an even number of others is an outer surface, one inside an odd number is a wall of a cavity of
    the smallest of them."""
    count = shell.max() + 1
    rows = [np.flatnonzero(shell == s) for s in range(count)]
    triangles = triangles.copy()
    size = np.zeros(count)
    for s in range(count):
        size[s] = volume(points, triangles[rows[s]])
        if size[s] < 0:
            triangles[rows[s]] = triangles[rows[s]][:, [0, 2, 1]]
            size[s] = -size[s]
    inside = np.zeros((count, count), bool)  # [a, b]: a lies in b
    for b in range(count):
        others = [a for a in range(count) if a != b and size[a] < size[b]]
        if others:
            probes = points[[triangles[rows[a][0], 0] for a in others]]
            inside[others, b] = winding(probes, points[triangles[rows[b]]]) > 0.5
    depth = inside.sum(axis=1)
    solids = {s: [s] for s in range(count) if depth[s] % 2 == 0}
    for s in np.flatnonzero(depth % 2 == 1).tolist():
        owner = min(np.flatnonzero(inside[s]).tolist(), key=lambda b: size[b])
        solids[owner].append(s)
        triangles[rows[s]] = triangles[rows[s]][:, [0, 2, 1]]
    return triangles, list(solids.values())


def winding(probes: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Winding number of outward triangles (m, 3, 3) about each point, from their solid angles (van Oosterom and Strackee, 1983, eq. 8)."""
    total = np.empty(len(probes))
    for i, probe in enumerate(probes):
        a, b, c = (corners[:, k] - probe for k in range(3))
        la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
        dot = lambda x, y: np.einsum("ij,ij->i", x, y)  # noqa: E731
        below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
        total[i] = 2 * np.arctan2(dot(a, np.cross(b, c)), below).sum()
    return total / (4 * np.pi)


def patches(points: np.ndarray, triangles: np.ndarray, crease: float) -> np.ndarray:
    """Patch of every triangle: patches are bounded by edges across which the normal turns by more than `crease` [radians]."""
    edges, owner = edges_of(triangles)
    _, place, _ = edge_groups(triangles)
    pair = owner[np.argsort(place, kind="stable")].reshape(-1, 2)
    normal = normals(points, triangles)
    smooth = pair[np.einsum("ij,ij->i", normal[pair[:, 0]], normal[pair[:, 1]]) >= np.cos(crease)]
    return components(len(triangles), smooth)


def components(count: int, pairs: np.ndarray) -> np.ndarray:
    """Connected component of each of `count` items, from pairs (k, 2) that belong together."""
    label = np.arange(count)
    while True:
        low = label.copy()
        np.minimum.at(low, pairs[:, 0], label[pairs[:, 1]])
        np.minimum.at(low, pairs[:, 1], label[pairs[:, 0]])
        low = low[low]
        if np.array_equal(low, label):
            return np.unique(label, return_inverse=True)[1].ravel()
        label = low


def normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit normals; zero for flat triangles."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    vector = np.cross(b - a, c - a)
    return vector / np.maximum(np.linalg.norm(vector, axis=1), 1e-300)[:, None]


def volume(points: np.ndarray, triangles: np.ndarray) -> float:
    """Volume enclosed by outward triangles. The origin is moved to the surface, so that no digits are lost for distant bodies."""
    a, b, c = (points[triangles[:, i]] - points[triangles[0, 0]] for i in range(3))
    return float(np.einsum("ij,ij->", np.cross(a, b), c) / 6)
