"""AVS-UCD prepared for meshio: the nodes and cells without their data, which define no regions.

meshio fails on cell data if there are several kinds of cells."""

from pathlib import Path

from .errors import BadRequest


def grid(path: Path, content: Path) -> str:
    """The nodes and cells of a file, whose unpacked text is in `content`; a file that ends within its data is refused as truncated."""
    lines = [line for line in content.read_text("utf-8").splitlines() if line.strip() and not line.lstrip().startswith("#")]
    nodes, cells, of_nodes, of_cells, _ = (int(word) for word in lines[0].partition("#")[0].split())
    kept = end = 1 + nodes + cells
    for owners, components in ((nodes, of_nodes), (cells, of_cells)):
        if components:
            # A line with the number of fields and their sizes, one for each name, and one for each owner
            fields = int(lines[end].split()[0]) if end < len(lines) else 0
            end += 1 + fields + owners
    if end > len(lines):
        raise BadRequest(f"cannot read {path.name}: it has {len(lines)} lines of at least {end}", "write or copy it again")
    return "\n".join([f"{nodes} {cells} 0 0 0", *lines[1:kept], ""])


def numbers(text: str) -> tuple:
    """Numbers of the nodes and cells of a prepared file, in their order."""
    head, *lines = text.splitlines()
    nodes = int(head.split()[0])
    found = [int(line.split()[0]) for line in lines]
    return found[:nodes], found[nodes:]
