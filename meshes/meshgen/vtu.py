"""XML VTK: handling of features that meshio does not read, or would read only in part."""

import re
from pathlib import Path

from .errors import BadRequest

VOXEL = "voxel"  # Name by which meshio gives these cells
NUMBER = 11  # VTK's number of voxels
FLAT = ("2", "4", "6")  # VTK's numbers of cells without volume and of any number of nodes, which are left out: poly-vertices, polylines, triangle strips
HEAD = 4096  # Bytes within which a file begins
AS_HEXAHEDRON = [0, 1, 3, 2, 4, 5, 7, 6]  # The rows of a voxel run in one direction, those of a hexahedron around


def teach_voxels() -> None:
    """Make meshio read voxels, which it would otherwise leave out."""
    from meshio import _common, _mesh, _vtk_common

    _vtk_common.vtk_to_meshio_type[NUMBER] = VOXEL
    _common.num_nodes_per_cell[VOXEL] = len(AS_HEXAHEDRON)
    _mesh.topological_dimension[VOXEL] = 3


def readable(data: bytes) -> bytes:
    """The bytes of a file as meshio can read them: as version 1.0, and with a line break after raw data.

    Versions 2.2 and 2.3 differ in polyhedra and in cells of high order, which are refused by their type."""
    tag = re.search(rb"<VTKFile\b[^>]*>", data[:HEAD])
    if not tag:
        return data
    head = re.sub(rb"""(\bversion\s*=\s*["'])2\.\d+(?=["'])""", rb"\g<1>1.0", tag[0])
    data = data[: tag.start()] + head + data[tag.end() :] if head != tag[0] else data
    begin = re.search(rb"<AppendedData[^>]*\braw\b[^>]*>\s*_", data)
    close = data.rfind(b"</AppendedData>")
    if not begin or close < begin.end():
        return data
    end = end_of_raw(head, data[: begin.start()], data[begin.end() : close])
    return data if end is None else data[: begin.end() + end] + b"\n" + data[close:]


def end_of_raw(head: bytes, arrays: bytes, raw: bytes) -> int | None:
    """The length of the appended arrays without trailing bytes; None if they do not fit."""
    word = 8 if b"UInt64" in head else 4
    order = "big" if b"BigEndian" in head else "little"
    last = max(map(int, re.findall(rb"""\boffset\s*=\s*["']\s*(\d+)""", arrays)), default=None)
    if last is None:
        return None

    def at(k: int) -> int:
        return int.from_bytes(raw[last + k * word : last + (k + 1) * word], order)

    if b"compressor" not in head:
        end = last + word + at(0)
    else:
        if at(0) > len(raw) // word:
            return None
        # Numbers and sizes of blocks, then the length of each
        end = last + (3 + at(0)) * word + sum(at(3 + k) for k in range(at(0)))
    return end if end <= len(raw) else None


def check(path: Path, readable: Path) -> None:
    """Refuse several pieces, of which only one would be read."""
    count = pieces(readable)
    if count > 1:
        fact = f"it has {count} pieces, of which only one is read"
        raise BadRequest(f"cannot read {path.name}: {fact}", "merge them, for example in ParaView, and write one piece")


def pieces(path: Path) -> int:
    """The number of pieces of a file. Appended data, which may be binary, follow after them."""
    head, _, _ = path.read_bytes().partition(b"<AppendedData")
    return len(re.findall(rb"<Piece[\s>/]", re.sub(rb"<!--.*?-->", b"", head, flags=re.S)))
