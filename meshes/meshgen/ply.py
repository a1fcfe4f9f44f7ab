"""PLY, ASCII or binary (Turk, 1994): it may have any elements and properties, of which a surface needs few."""

import itertools
import re
from pathlib import Path

import numpy as np

TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


def read(path: Path) -> tuple:
    """The points, by `x`, `y` and `z`, and the polygons, by `vertex_indices` or `vertex_index`."""
    parts = re.split(rb"[\r\n]end_header[ \t]*(?:\r\n|\n|\r)", path.read_bytes(), maxsplit=1)
    lines = [line.split() for line in parts[0].decode("latin-1").splitlines()]
    order = ORDERS.get(next((words[1] for words in lines if words[:1] == ["format"]), None))
    if len(parts) < 2 or lines[0] != ["ply"] or order is None:
        raise ValueError("it has no header from ply to end_header with a known format")
    elements = []
    for words in lines:
        if words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), {}))
        elif words[:1] == ["property"]:
            elements[-1][2][words[-1]] = [order + TYPES[kind] for kind in words[1:-1] if kind != "list"]
    take, is_left = of_text(parts[1]) if order == "" else of_bytes(parts[1])
    found = {name: columns(take, count, properties) for name, count, properties in elements}
    if is_left():
        raise ValueError("it goes on after its last element: write several surfaces with one list of points")
    if not {"vertex", "face"} <= found.keys() or not {"x", "y", "z"} <= found["vertex"].keys():
        raise ValueError("it needs the elements vertex, with x, y and z, and face")
    faces = found["face"].get("vertex_indices", found["face"].get("vertex_index", []))
    return np.stack([found["vertex"][axis] for axis in "xyz"], axis=1), [face.astype(int).tolist() for face in faces]


def columns(take, count: int, properties: dict) -> dict:
    """The values of each property for `count` elements; values of a list property are arrays."""
    if all(len(kinds) == 1 for kinds in properties.values()):
        table = take([(name, kinds[0]) for name, kinds in properties.items()], count)
        return {name: table[name] for name in properties}
    found = {name: [] for name in properties}
    for _ in range(count):
        for name, kinds in properties.items():
            first = take(kinds[0], 1)[0]
            found[name].append(first if len(kinds) == 1 else take(kinds[1], int(first)))
    return found


def of_text(text: bytes):
    """A function that takes the next `count` values of a type, in columns if the type has fields, and one that tells whether any are left."""
    words = iter(text.split())

    def take(kind, count: int):
        width = len(kind) if isinstance(kind, list) else 1
        values = np.array(list(itertools.islice(words, width * count)), float)
        if len(values) < width * count:
            raise ValueError("it ends before its last element")
        return dict(zip((name for name, _ in kind), values.reshape(count, width).T)) if isinstance(kind, list) else values

    return take, lambda: next(words, None) is not None


def of_bytes(data: bytes):
    """A function that takes the next `count` binary values of a type, in columns if the type has fields, and one that tells whether any are left."""
    at = 0

    def take(kind, count: int):
        nonlocal at
        values = np.frombuffer(data, kind, count, at)
        at += values.nbytes
        return values

    return take, lambda: bool(data[at:].strip())
