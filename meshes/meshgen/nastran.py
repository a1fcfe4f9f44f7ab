"""Nastran bulk data as meshio reads it: from BEGIN BULK to ENDDATA, with keywords in capital letters."""

import io
import re
from pathlib import Path

from .errors import BadRequest

# Cells on lines of wide fields, which meshio passes over
WIDE = re.compile(r"C(TETRA|HEXA|PENTA|PYRAM?|TRIA\w|QUAD\w)\s*\*")


def bulk(path: Path, content: Path) -> io.StringIO:
    """The bulk data of a file, whose unpacked text is in `content`; files without BEGIN BULK, as gmsh writes them, hold nothing else.

    One without ENDDATA is cut off."""
    lines = content.read_text("latin-1").upper().split("\n")
    begin = next((i for i, line in enumerate(lines, 1) if line.split()[:2] == ["BEGIN", "BULK"]), 0)
    end = next((i for i, line in enumerate(lines) if i >= begin and line.lstrip().startswith("ENDDATA")), None)
    if end is None:
        raise BadRequest(f"cannot read {path.name}: its last line must be ENDDATA, so that a part is missing", "write or copy it again")
    for number, line in enumerate(lines[begin:end], begin + 1):
        if line.startswith("INCLUDE"):
            raise BadRequest(f"cannot read {path.name}: line {number}: INCLUDE is not read", "write the mesh into one file")
        if WIDE.match(line):
            raise BadRequest(f"cannot read {path.name}: line {number}: elements in wide fields are not read", "write elements in fields of 8 columns")
    return io.StringIO("\n".join(["BEGIN BULK", *lines[begin:end], "ENDDATA", ""]))
