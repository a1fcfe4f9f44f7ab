"""XML VTK: what meshio does not read of it, or would read in part."""

import re
from pathlib import Path

from .errors import BadRequest

VOXEL = "voxel"  # Name by which meshio gives these cells
NUMBER = 11  # VTK's number of voxels
AS_HEXAHEDRON = [0, 1, 3, 2, 4, 5, 7, 6]  # The rows of a voxel run in one direction, those of a hexahedron around


def teach_voxels() -> None:
    """Make meshio read voxels, which it would leave out."""
    from meshio import _common, _mesh, _vtk_common

    _vtk_common.vtk_to_meshio_type[NUMBER] = VOXEL
    _common.num_nodes_per_cell[VOXEL] = len(AS_HEXAHEDRON)
    _mesh.topological_dimension[VOXEL] = 3


def check(path: Path, readable: Path) -> None:
    """Refuse several pieces, of which one would be read."""
    count = pieces(readable)
    if count > 1:
        fact = f"it has {count} pieces, of which only one is read"
        raise BadRequest(f"cannot read {path.name}: {fact}", "merge them, for example in ParaView, and write one piece")


def pieces(path: Path) -> int:
    """The number of pieces of a file. Appended data, which may be binary, come behind them."""
    head, _, _ = path.read_bytes().partition(b"<AppendedData")
    return len(re.findall(rb"<Piece[\s>/]", re.sub(rb"<!--.*?-->", b"", head, flags=re.S)))
