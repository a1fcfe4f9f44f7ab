"""Names in Netgen meshes: those of materials and boundary conditions, of which several may have one. meshio keeps the last of them."""

from pathlib import Path

from .errors import BadRequest

DIMENSIONS = {"materials": 3, "bcnames": 2}


def names(path: Path, content: Path) -> dict:
    """(dimension, index) -> name in a file, whose unpacked text is in `content`. One without `endmesh` is cut off."""
    text = [line.strip() for line in content.read_text("utf-8").splitlines()]
    if "endmesh" not in text:
        raise BadRequest(f"cannot read {path.name}: it has no line endmesh, so that a part is missing", "write or copy it again")
    found, lines = {}, iter(text)
    for line in lines:
        dim = DIMENSIONS.get(line)
        for _ in range(int(next(lines)) if dim else 0):
            index, _, name = next(lines).partition(" ")
            if name:
                found[dim, int(index)] = name.strip()
    return found
