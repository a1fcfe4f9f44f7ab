"""Triangles of STL (ASCII or binary), OBJ, OFF and PLY files. Polygons are cut into triangles; text in any encoding."""

from pathlib import Path

import numpy as np

from . import convert, ply, polygons
from .errors import BadRequest

RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read(path: Path, format: str) -> tuple:
    """Points (n, 3) and triangles (m, 3) of a surface file, unchanged."""
    try:
        if format in READERS:
            with convert.prepared(path, format) as readable:
                points, triangles = READERS[format](readable)
        else:
            points, triangles = of_mesh(path, format)
    except OSError as error:
        raise BadRequest(f"cannot read {path.name}: {error}", "check the path and its permissions") from None
    except (ValueError, IndexError, KeyError, UnicodeDecodeError) as error:
        raise BadRequest(f"cannot read {path.name}: {error}", "check that the file is complete and of the format of its name") from None
    points, triangles = np.asarray(points, float).reshape(-1, 3), np.asarray(triangles, int).reshape(-1, 3)
    if not len(triangles):
        raise BadRequest(f"{path.name} has no triangles", "export a closed surface of triangles")
    if triangles.min() < 0 or triangles.max() >= len(points):
        raise BadRequest(f"{path.name} refers to node {triangles.max()} of {len(points)}", "the file is damaged")
    if not np.isfinite(points[triangles]).all():
        bad = int(np.flatnonzero(~np.isfinite(points[triangles]).all(axis=(1, 2)))[0])
        raise BadRequest(f"{path.name} has coordinates that are not finite, first in triangle {bad}", "export it again")
    return points, triangles


def of_mesh(path: Path, format: str) -> tuple:
    """The triangles of a mesh file of another format."""
    blocks = convert.read(path, format)
    names = {number: (dimension, name) for name, (dimension, number) in convert.KINDS.items()}
    found = [(*names[kind], rows) for kind, rows in blocks.cells if len(rows)]
    if any(dimension == 3 for dimension, _, _ in found):
        raise BadRequest(f"{path.name} is a volume mesh: it is taken over, not meshed again", "drop cells, size, grading and generator; levels = 1 splits each of its cells into eight")
    faces = {name for dimension, name, _ in found if dimension == 2}
    if faces != {"triangle"}:
        raise BadRequest(f"{path.name} must be made of triangles; it has {', '.join(sorted(faces)) or 'no faces'}", "triangulate it")
    return blocks.points, np.concatenate([rows for _, name, rows in found if name == "triangle"])


def soup(corners: np.ndarray) -> tuple:
    """Points and triangles of corners (m, 3, 3): equal points become one."""
    points, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return points, index.reshape(-1, 3)


def read_stl(path: Path) -> tuple:
    """Binary if the length fits the number of triangles in the header, otherwise ASCII, whatever the first word is.

    Some programs pad the end of a binary file: with zeros, or with bytes too few for another triangle."""
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little") if len(data) >= 84 else -1
    end = 84 + RECORD.itemsize * count
    if 84 <= end <= len(data) and (len(data) - end < RECORD.itemsize or not any(data[end:])):
        return soup(np.frombuffer(data, RECORD, count, 84)["corners"].astype(float))
    text = data.decode("latin-1").lower()
    if "facet" not in text or "\0" in text:
        expected = f"; its header promises {count} triangles, it has room for {(len(data) - 84) / RECORD.itemsize:.1f}" if count >= 0 else ""
        raise ValueError(f"neither a complete binary nor an ASCII STL{expected}")
    rows = [line.split()[1:4] for line in text.splitlines() if line.lstrip().startswith("vertex")]
    if len(rows) % 3 or text.count("endfacet") * 3 != len(rows):
        raise ValueError(f"{len(rows)} vertices in {text.count('endfacet')} complete facets")
    return soup(np.array(rows, float).reshape(-1, 3, 3))


def read_obj(path: Path) -> tuple:
    """Lines `v` and `f`; indices may be negative and carry texture and normal."""
    points, faces = [], []
    for line in path.read_text("latin-1").replace("\\\n", " ").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            face = [int(word.split("/")[0]) for word in words[1:]]
            faces.append([i - 1 if i > 0 else len(points) + i for i in face])
    return points, polygons.triangles(points, faces)


def read_off(path: Path) -> tuple:
    """OFF: counts, points, polygons; colours and comments are skipped."""
    lines = (line.split("#")[0].split() for line in path.read_text("latin-1").splitlines())
    lines = [words for words in lines if words]
    head = lines[0] if lines else []
    if not head or not head[0].upper().endswith("OFF"):
        raise ValueError("its first line is not OFF")
    rest = ([head[1:]] if len(head) > 1 else []) + lines[1:]
    points, faces = int(rest[0][0]), int(rest[0][1])
    if len(rest) < 1 + points + faces:
        raise ValueError(f"it promises {points} points and {faces} faces and has {len(rest) - 1} lines for them")
    if len(rest) > 1 + points + faces:
        raise ValueError(f"it promises {points} points and {faces} faces and has {len(rest) - 1} lines: write several surfaces with one list of points")
    found = [[float(word) for word in words[:3]] for words in rest[1 : 1 + points]]
    return found, polygons.triangles(found, [[int(word) for word in words[1 : 1 + int(words[0])]] for words in rest[1 + points : 1 + points + faces]])


def read_ply(path: Path) -> tuple:
    """PLY; colours and normals are skipped."""
    points, faces = ply.read(path)
    return points, polygons.triangles(points, faces)


READERS = {"stl": read_stl, "obj": read_obj, "off": read_off, "ply": read_ply}
