"""SU2 meshes: points, cells, and the boundary facets of every marker, which become a region of the same name."""

from pathlib import Path

import numpy as np

from .blocks import Blocks
from .errors import BadRequest

# VTK's number of a kind of cells -> (gmsh's kind, nodes)
KINDS = {1: (15, 1), 3: (1, 2), 5: (2, 3), 9: (3, 4), 10: (4, 4), 12: (5, 8), 13: (6, 6), 14: (7, 5)}


class Reader:
    """The lines of a file, without comments, blank lines, and the send-receive direction of halos, which is between a count and its lines."""

    def __init__(self, path: Path, data: bytes):
        self.path = path
        lines = ((number, self.text(number, line)) for number, line in enumerate(data.splitlines(), 1))
        self.lines = [(number, line) for number, line in lines if line and not line.startswith("SEND_RECV")]
        self.at = 0
        self.points = np.zeros((0, 3))
        self.rows: dict = {}  # (marker, kind) -> rows of nodes; the marker of cells is empty
        self.numbers: dict = {}  # (marker, kind) -> numbers of the cells, from zero

    def text(self, number: int, line: bytes) -> str:
        """A line without its comment, which may be in an encoding other than UTF-8."""
        try:
            return line.partition(b"%")[0].decode().strip()
        except UnicodeDecodeError:
            raise self.fail(number, "it is no text in UTF-8", "save the file as UTF-8") from None

    def fail(self, number: int, fact: str, hint: str = "the file is damaged, write it again") -> BadRequest:
        return BadRequest(f"cannot read {self.path.name}: line {number}: {fact}", hint)

    def read(self) -> None:
        """Every keyword with the lines that belong to it. Keywords that are not part of the mesh, such as FFD boxes, are skipped."""
        marker, is_known, announced, found = "", False, (0, 0), 0  # announced: the line and the number of markers
        while self.at < len(self.lines):
            number, line = self.lines[self.at]
            self.at += 1
            key, mark, value = (word.strip() for word in line.partition("="))
            if not mark:
                if is_known:
                    raise self.fail(number, f"{line[:40]!r} is one line more than was announced")
                continue
            is_known = key in ("NDIME", "NPOIN", "NELEM", "MARKER_TAG", "MARKER_ELEMS")
            if key == "NDIME" and value != "3":
                raise BadRequest(f"{self.path.name} has points of dimension {value}", "a body has three")
            if key == "NZONE" and value != "1":
                raise self.fail(number, f"{value} zones are not read", "write each zone into a file of its own")
            if key == "MARKER_TAG":
                marker, found = f"facets_{value}" if value.isdecimal() else value, found + 1
            elif key == "NMARK" and value.isdecimal():
                announced = (number, int(value))
            elif key == "NPOIN":
                self.points = np.array([self.point(*line) for line in self.block(number, key, value)]).reshape(-1, 3)
            elif key in ("NELEM", "MARKER_ELEMS"):
                for i, line in enumerate(self.block(number, key, value)):
                    kind, nodes = self.element(*line)
                    of = (marker if key == "MARKER_ELEMS" else "", kind)
                    self.rows.setdefault(of, []).append(nodes)
                    self.numbers.setdefault(of, []).append(i)
        if found < announced[1]:
            raise self.fail(announced[0], f"NMARK= {announced[1]}, but {found} markers follow", "write or copy the file again")

    def block(self, number: int, key: str, value: str) -> list:
        """The lines that a keyword announces."""
        words = value.split()
        if not words or not words[0].isdecimal():
            raise self.fail(number, f"{key} is not a whole number")
        lines = self.lines[self.at : self.at + int(words[0])]
        there = next((i for i, (_, line) in enumerate(lines) if "=" in line), len(lines))
        if there < int(words[0]):
            raise self.fail(number, f"{key}= {words[0]}, but {there} lines follow", "write or copy the file again")
        self.at += there
        return lines

    def point(self, number: int, line: str) -> list:
        """Three coordinates; the number of the point may follow."""
        try:
            x, y, z = map(float, line.split()[:3])
        except ValueError:
            raise self.fail(number, f"{line[:40]!r} has no three coordinates") from None
        return [x, y, z]

    def element(self, number: int, line: str) -> tuple:
        """gmsh's kind and the nodes; the number of the element may follow."""
        words = line.split()
        if not all(map(str.isdecimal, words)):
            raise self.fail(number, f"{line[:40]!r} is no list of nodes")
        kind, count = KINDS.get(int(words[0]), (0, 0))
        if not kind:
            hint = "SU2 has linear cells: write tetrahedra with 4 nodes, or another format, such as MSH"
            raise self.fail(number, f"elements of the type {words[0]} are not read", hint)
        if len(words) <= count:
            raise self.fail(number, f"{len(words) - 1} nodes, where {count} are wanted")
        return kind, [int(word) for word in words[1 : count + 1]]


def read(path: Path, content: Path) -> Blocks:
    """The mesh of a file, whose unpacked text is in `content`."""
    reader = Reader(path, content.read_bytes())
    reader.read()
    cells, owners = [], []
    for (marker, kind), nodes in reader.rows.items():
        rows = np.array(nodes)
        if rows.max() >= len(reader.points):
            raise BadRequest(f"cannot read {path.name}: an element refers to node {rows.max()}, which is not there", "write it again")
        cells.append((kind, rows))
        owners.append(marker)
    names = dict.fromkeys(marker for marker in owners if marker)
    sets = {name: [np.full(len(rows), owner == name) for (_, rows), owner in zip(cells, owners)] for name in names}
    numbers = [np.array(list_) for list_ in reader.numbers.values()]
    return Blocks(reader.points, cells, sets, node_numbers=np.arange(len(reader.points)), numbers=numbers)
