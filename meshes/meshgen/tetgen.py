"""TetGen's pair of files: whether `.node` and `.ele` contain what they announce. meshio would search for the first line endlessly."""

from pathlib import Path

from .errors import BadRequest


def check(path: Path) -> None:
    """Refuse a pair in which a file has no counts, or fewer or more numbers than announced, and second-order cells."""
    for file, what, own in ((path.with_suffix(".node"), "nodes", 4), (path.with_suffix(".ele"), "cells", 1)):
        rows = words(file)
        try:
            count, size, *further = numbers = [int(word) for word in rows[0]] if rows else []
            if min(numbers) < 0:
                raise ValueError
        except ValueError:
            raise refused(file, f"it does not begin with the numbers of its {what}") from None
        if what == "cells" and size != 4:
            raise BadRequest(f"cannot read {file.name}: its cells have {size} nodes", "write tetrahedra with 4 nodes, or another format, such as MSH")
        columns = own + sum(further) + (size if what == "cells" else 0)
        there = sum(map(len, rows[1:])) // columns
        if there < count:
            raise refused(file, f"it announces {count} {what}, of which {there} are there")
        if there > count:
            raise refused(file, f"it announces {count} {what}, and holds numbers for {there}, as where a program wrote two lists one after the other")


def first(path: Path) -> int:
    """The number of the first node and cell, zero or one."""
    rows = words(path.with_suffix(".ele"))
    return int(rows[1][0]) if len(rows) > 1 else 1


def words(file: Path) -> list:
    """The words of the non-empty lines, without comments."""
    lines = (line.partition("#")[0].split() for line in file.read_text("utf-8").splitlines())
    return [line for line in lines if line]


def refused(file: Path, fact: str) -> BadRequest:
    return BadRequest(f"cannot read {file.name}: {fact}", "check that the file is complete, and write it again")
