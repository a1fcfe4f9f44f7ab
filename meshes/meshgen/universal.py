"""I-DEAS universal files: gmsh reads nodes and elements, and the groups are read here, because gmsh gives a group whole entities.

A data set is between two lines with -1 in columns 5 and 6 and begins with its number."""

from pathlib import Path

import numpy as np

from .blocks import Blocks
from .errors import BadRequest

MARK = b"    -1"
WIDTH = {b"2417": 2, b"2429": 2, b"2430": 2, b"2432": 2, b"2435": 4, b"2452": 4, b"2467": 4, b"2477": 4}  # numbers of a member in data sets of groups
ELEMENTS = b"2412"
BEAMS = (11, 21, 22, 23, 24)  # Elements with a line of orientation before their nodes
NODE, ELEMENT = 7, 8  # Types of the members of groups


def datasets(path: Path, data: bytes) -> list:
    """(number, lines) of the data sets. A file that ends within one is refused; gmsh would read the truncated data.

    The first mark may be repeated."""
    lines, found, begin = data.split(b"\n"), [], 0  # begin: line of the mark at the beginning of an open data set
    for number, line in enumerate(lines, 1):
        if line.rstrip() == MARK and begin and number > begin + 1:
            found.append((lines[begin].strip(), lines[begin + 1 : number - 1]))
            begin = 0
        elif line.rstrip() == MARK:
            begin = number
    if begin:
        fact = f"the data set that begins in line {begin} has no line with -1 at its end, so that a part is missing"
        raise BadRequest(f"cannot read {path.name}: {fact}", "write or copy it again")
    return found


def for_gmsh(path: Path, data: bytes) -> bytes:
    """The file without groups, in which gmsh crashes at an element that is not in the file, and with an entity for each material, which is gmsh's group."""
    parts = [(number, lines) for number, lines in datasets(path, data) if number not in WIDTH]
    parts = [(number, by_material(path, lines) if number == ELEMENTS else lines) for number, lines in parts]
    return b"".join(b"\n".join([MARK, number.rjust(6), *lines, MARK, b""]) for number, lines in parts)


def by_material(path: Path, lines: list) -> list:
    """The lines of elements with the number of the material in place of that of the property, which is gmsh's entity."""
    lines, at = lines.copy(), 0
    while at < len(lines):
        try:
            label, kind, _, material, colour, count = map(int, lines[at].split())
            if count < 1:
                raise ValueError
        except ValueError:
            raise refused(path, "elements", lines[at]) from None
        lines[at] = b"%10d" * 6 % (label, kind, material, material, colour, count)
        at += 1 + (kind in BEAMS) - (-count // 8)
    return lines


def add_groups(path: Path, data: bytes, blocks: Blocks) -> None:
    """Replace the sets of the mesh, which are materials, by the groups of the file if it has any."""
    found = [group for number, lines in datasets(path, data) if number in WIDTH for group in groups(path, lines, WIDTH[number])]
    blocks.sets = {} if found else blocks.sets
    for name, members in found:
        kinds, labels = members.T
        nodes = np.flatnonzero(np.isin(blocks.node_numbers, labels[kinds == NODE]))
        masks = [np.isin(own, labels[kinds == ELEMENT]) for own in blocks.numbers]
        count = len(nodes) + sum(int(mask.sum()) for mask in masks)
        if count < len(members):
            blocks.notes.append(f"{len(members) - count} of {len(members)} members of group {name} are no nodes or elements that are read")
        if len(nodes):
            blocks.node_sets[name] = np.union1d(blocks.node_sets.get(name, nodes), nodes)
        if any(map(np.any, masks)):
            blocks.sets[name] = [old | new for old, new in zip(blocks.sets.get(name, masks), masks)]


def groups(path: Path, lines: list, width: int) -> list:
    """(name, distinct members) of each group of a data set; members (n, 2): type and label."""
    found, at = [], 0
    while at < len(lines):
        try:
            number, *_, count = map(int, lines[at].split()[:8])
            name = lines[at + 1].decode().strip() or f"group_{number}"
            rows = -(-count * width // 8)
            members = np.array(b" ".join(lines[at + 2 : at + 2 + rows]).split(), int).reshape(count, width)[:, :2]
        except UnicodeDecodeError:
            raise BadRequest(f"cannot read {path.name}: the name of group {number} is no text in UTF-8", "save it as UTF-8") from None
        except (ValueError, IndexError):
            raise refused(path, "groups", lines[at]) from None
        found.append((name, np.unique(members, axis=0)))
        at += 2 + rows
    return found


def refused(path: Path, kind: str, line: bytes) -> BadRequest:
    fact = f"the lines of {kind} from {line.decode(errors='replace').strip()!r} on are not understood"
    return BadRequest(f"cannot read {path.name}: {fact}", "check that the file is complete, and write it again")
