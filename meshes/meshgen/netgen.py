"""Names of materials and boundary conditions in Netgen meshes. Several may have the same name, of which meshio keeps only the last."""

from pathlib import Path

from .errors import BadRequest

DIMENSIONS = {"materials": 3, "bcnames": 2}


def names(path: Path, content: Path) -> dict:
    """(dimension, index) -> name in a file, whose unpacked text is in `content`. A file without `endmesh` is refused as truncated."""
    text = [line.strip() for line in content.read_text("utf-8").splitlines()]
    if "endmesh" not in text:
        raise BadRequest(f"cannot read {path.name}: it has no line endmesh, so that a part is missing", "write or copy it again")
    found, lines = {}, iter(text)
    for line in lines:
        if line not in DIMENSIONS:
            continue
        try:
            for _ in range(int(next(lines))):
                # Netgen separates by a tab, meshio by a blank, and a name may be empty or contain blanks
                index, *name = next(lines).split(None, 1)
                found[DIMENSIONS[line], int(index)] = "".join(name)
        except (StopIteration, ValueError):
            raise BadRequest(f"cannot read {path.name}: {line} has fewer names than it announces", "write or copy it again") from None
    return {reference: name for reference, name in found.items() if name}
