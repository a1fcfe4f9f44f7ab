"""Closed surfaces of known volume for tests, and writers of their files. Lengths in the unit of the file."""

import struct

import numpy as np


def joined(*parts: tuple) -> tuple:
    """Several surfaces in one, without common nodes."""
    shift = np.cumsum([0] + [len(points) for points, _ in parts])
    return np.concatenate([p for p, _ in parts]), np.concatenate([t + s for (_, t), s in zip(parts, shift)])


def moved(part: tuple, shift=(0, 0, 0), scale: float = 1.0) -> tuple:
    return part[0] * scale + np.array(shift, float), part[1]


def reversed_(part: tuple) -> tuple:
    return part[0], part[1][:, [0, 2, 1]]


def blocks(cells, edge=(1.0, 1.0, 1.0)) -> tuple:
    """The boundary of unit blocks at integer positions, each square cut into two triangles; nodes are shared."""
    cells = set(map(tuple, cells))
    nodes, triangles = {}, []
    for cell in sorted(cells):
        for axis in range(3):
            for side in (0, 1):
                beyond = list(cell)
                beyond[axis] += 2 * side - 1
                if tuple(beyond) in cells:
                    continue
                corners = []
                for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    at = list(cell)
                    at[axis] += side
                    at[(axis + 1) % 3] += u
                    at[(axis + 2) % 3] += v
                    corners.append(nodes.setdefault(tuple(at), len(nodes)))
                a, b, c, d = corners if side else (corners[0], corners[3], corners[2], corners[1])
                triangles += [[a, b, c], [a, c, d]]
    return np.array(sorted(nodes, key=nodes.get), float) * edge, np.array(triangles)


def box(n=(2, 2, 2), size=(10.0, 10.0, 10.0)) -> tuple:
    """A box at the origin, its sides divided n times."""
    return blocks(np.ndindex(*n), np.array(size) / n)


def ball(radius: float = 5.0, level: int = 3) -> tuple:
    """An icosahedron whose triangles are divided into four, `level` times, with nodes on a sphere."""
    phi = (1 + 5**0.5) / 2
    points = [(-1, phi, 0), (1, phi, 0), (-1, -phi, 0), (1, -phi, 0), (0, -1, phi), (0, 1, phi), (0, -1, -phi), (0, 1, -phi), (phi, 0, -1), (phi, 0, 1), (-phi, 0, -1), (-phi, 0, 1)]  # fmt: skip
    triangles = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]  # fmt: skip
    points, triangles = list(map(np.array, points)), np.array(triangles)
    for _ in range(level):
        middle = {}

        def half(a, b, middle=middle):
            key = (min(a, b), max(a, b))
            if key not in middle:
                middle[key] = len(points)
                points.append((points[a] + points[b]) / 2)
            return middle[key]

        triangles = np.array([
            child
            for a, b, c in triangles.tolist()
            for ab, bc, ca in [(half(a, b), half(b, c), half(c, a))]
            for child in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        ])
    points = np.array(points, float)
    return radius * points / np.linalg.norm(points, axis=1)[:, None], triangles


def torus(large: float = 8.0, small: float = 3.0, around: int = 32, across: int = 16) -> tuple:
    u, v = (2 * np.pi * np.arange(n) / n for n in (around, across))
    ring = large + small * np.cos(v)[None, :]
    x, y = ring * np.cos(u)[:, None], ring * np.sin(u)[:, None]
    points = np.stack([x, y, np.broadcast_to(small * np.sin(v), x.shape)], axis=2)
    at = lambda i, j: (i % around) * across + j % across  # noqa: E731
    squares = [(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)) for i in range(around) for j in range(across)]
    return points.reshape(-1, 3), np.array([t for a, b, c, d in squares for t in ((a, b, c), (a, c, d))])


def prism(outline: list, height: float) -> tuple:
    """Points and polygons of a prism over a counterclockwise outline in the plane z = 0: two caps, and a rectangle for each edge."""
    n = len(outline)
    points = np.array([[x, y, z] for z in (0.0, height) for x, y in outline], float)
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return points, [list(range(n))[::-1], list(range(n, 2 * n)), *sides]


def corners(part: tuple) -> np.ndarray:
    return part[0][part[1]]


def binary_stl(path: str, part: tuple, header: bytes = b"made by a test") -> None:
    triangles = corners(part).astype("<f4")
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *t.ravel().tolist(), 0) for t in triangles)
    with open(path, "wb") as file:
        file.write(header.ljust(80, b"\0")[:80] + struct.pack("<I", len(triangles)) + rows)


def ascii_stl(path: str, part: tuple, name: str = "part", encoding: str = "utf-8", end: str = "\n") -> None:
    lines = [f"solid {name}"]
    for triangle in corners(part).tolist():
        lines += ["facet normal 0 0 0", " outer loop", *(f"  vertex {x!r} {y!r} {z!r}" for x, y, z in triangle), " endloop", "endfacet"]
    with open(path, "wb") as file:
        file.write((end.join(lines + [f"endsolid {name}", ""])).encode(encoding))


def obj(path: str, part: tuple) -> None:
    with open(path, "w") as file:
        file.writelines(f"v {x!r} {y!r} {z!r}\n" for x, y, z in part[0].tolist())
        file.writelines(f"f {' '.join(f'{i + 1}/1/1' for i in face)}\n" for face in part[1])


def off(path: str, part: tuple) -> None:
    with open(path, "w") as file:
        file.write(f"OFF # comment\n{len(part[0])} {len(part[1])} 0\n\n")
        file.writelines(f"{x!r} {y!r} {z!r}\n" for x, y, z in part[0].tolist())
        file.writelines(f"{len(face)} {' '.join(map(str, face))} 255 0 0\n" for face in part[1])


def ply(path: str, part: tuple) -> None:
    with open(path, "w") as file:
        file.write(f"ply\nformat ascii 1.0\nelement vertex {len(part[0])}\nproperty double x\nproperty double y\nproperty double z\n")
        file.write(f"element face {len(part[1])}\nproperty list uchar int vertex_indices\nend_header\n")
        file.writelines(f"{x!r} {y!r} {z!r}\n" for x, y, z in part[0].tolist())
        file.writelines(f"{len(face)} {' '.join(map(str, face))}\n" for face in part[1])
