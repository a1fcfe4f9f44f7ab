"""Closed triangle surfaces: consistent orientation, enclosed volume."""

from collections import deque

import numpy as np

from .errors import BadRequest


def oriented(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The triangles oriented outward; refuses a surface that is not closed and manifold."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    owner = np.tile(np.arange(len(triangles)), 3)
    forward = edges[:, 0] < edges[:, 1]
    keys, place, counts = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    if np.any(counts != 2):
        refuse(points, keys[counts != 2], counts[counts != 2])
    pair = np.argsort(place.ravel(), kind="stable").reshape(-1, 2)
    same = forward[pair[:, 0]] == forward[pair[:, 1]]
    neighbours = [[] for _ in triangles]
    for (a, b), turn in zip(owner[pair].tolist(), same.tolist()):
        neighbours[a].append((b, turn))
        neighbours[b].append((a, turn))
    part, turned = walk(neighbours)
    if part.max() > 0:
        raise BadRequest(f"the surface has {part.max() + 1} separate parts", "give one closed surface")
    result = np.where(turned[:, None], triangles[:, [0, 2, 1]], triangles)
    return result if volume(points, result) > 0 else result[:, [0, 2, 1]]


def walk(neighbours: list) -> tuple:
    """Part number of every triangle, and whether it must be reversed to agree with the first of its part."""
    part, turned = np.full(len(neighbours), -1), np.zeros(len(neighbours), bool)
    number = -1
    for start in range(len(neighbours)):
        if part[start] >= 0:
            continue
        number += 1
        part[start] = number
        queue = deque([start])
        while queue:
            here = queue.popleft()
            for there, turn in neighbours[here]:
                if part[there] < 0:
                    part[there], turned[there] = number, turned[here] ^ turn
                    queue.append(there)
                elif turned[there] != turned[here] ^ turn:
                    raise BadRequest("the surface has one side only, like a Moebius strip", "repair the surface")
    return part, turned


def refuse(points: np.ndarray, edges: np.ndarray, counts: np.ndarray) -> None:
    """Raise an error that states where a surface is open or branches."""
    where = np.round(points[edges[0]].mean(axis=0), 6).tolist()
    if np.any(counts == 1):
        raise BadRequest(f"the surface is not closed: {np.sum(counts == 1)} border edges, one near {where}", "close the holes")
    raise BadRequest(f"the surface branches at {len(edges)} edges, one near {where}", "remove inner or doubled triangles")


def volume(points: np.ndarray, triangles: np.ndarray) -> float:
    """Enclosed volume of outward triangles."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", np.cross(a, b), c) / 6)


def merged(points: np.ndarray, triangles: np.ndarray) -> tuple:
    """Points closer than 1e-9 of the size merged (as in STL, where every triangle has its own); no flat triangles."""
    step = np.ptp(points, axis=0).max() * 1e-9
    _, first, inverse = np.unique(np.round(points / step), axis=0, return_index=True, return_inverse=True)
    triangles = inverse.ravel()[triangles]
    distinct = (triangles[:, 0] != triangles[:, 1]) & (triangles[:, 1] != triangles[:, 2]) & (triangles[:, 2] != triangles[:, 0])
    return points[first], triangles[distinct]
