"""Abaqus input: nodes, elements and the sets and surfaces of parts, instances and the assembly."""

import stat
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .blocks import Blocks
from .errors import BadRequest

# Beginning of the name of an element -> (gmsh's kind, nodes); hybrid, reduced and modified elements have further letters.
ELEMENTS = {
    "C3D4": (4, 4), "C3D10": (11, 10), "C3D8": (5, 8), "C3D6": (6, 6), "C3D5": (7, 5), "C3D20": (17, 20), "C3D15": (18, 15), "C3D27": (12, 27),
    "S3": (2, 3), "STRI3": (2, 3), "M3D3": (2, 3), "SFM3D3": (2, 3), "R3D3": (2, 3), "S4": (3, 4), "M3D4": (3, 4), "SFM3D4": (3, 4),
    "R3D4": (3, 4), "T3D2": (1, 2), "B31": (1, 2), "M3D6": (9, 6), "SFM3D6": (9, 6), "STRI65": (9, 6),
}  # fmt: skip
# Faces S1, S2, … of a kind by their corners
FACES = {
    4: [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)],
    11: [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)],
    5: [(0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)],
    6: [(0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)],
    7: [(0, 1, 2, 3), (0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)],
}

# Keywords whose data lines may be in the file of their INPUT=; the program knows the same
WITH_INPUT = ("node", "element", "nset", "elset", "surface")

# Limits of *INCLUDE and of INPUT=, which are those of the program too; a file that is included twice counts twice
MOST_LEVELS = 16
MOST_FILES = 1000
MOST_BYTES = 4 << 30


@dataclass
class Part:
    """Nodes and elements by their labels; sets: name -> labels; surfaces: name -> (element or set, face)."""

    nodes: dict = field(default_factory=dict)
    elements: dict = field(default_factory=dict)  # label -> (kind, labels of its nodes)
    node_sets: dict = field(default_factory=dict)
    element_sets: dict = field(default_factory=dict)
    surfaces: dict = field(default_factory=dict)


@dataclass
class Instance:
    """A part where the assembly has it."""

    part: Part
    lines: list = field(default_factory=list)

    def place(self, points: np.ndarray) -> np.ndarray:
        """The translation, then the rotation about an axis through two points [degrees]."""
        if self.lines:
            points = points + np.array(self.lines[0][:3])
        if len(self.lines) > 1:
            a, b, angle = np.array(self.lines[1][:3]), np.array(self.lines[1][3:6]), np.radians(self.lines[1][6])
            u = (b - a) / np.linalg.norm(b - a)
            v = points - a
            points = a + v * np.cos(angle) + np.cross(u, v) * np.sin(angle) + np.outer(v @ u, u) * (1 - np.cos(angle))
        return points


class Reader:
    """The state of reading: the part, instance or assembly that keywords refer to."""

    def __init__(self, path: Path, content: Path):
        self.path = path
        self.content = content  # where the text of the file itself is read
        self.open: list = []  # the file that is read, after those that include it
        self.files = self.bytes = 0
        self.parts = {"": Part()}
        self.instances: dict = {}
        self.assembly = Part()
        self.scope = self.parts[""]
        self.inside = None  # an instance whose lines of placement follow
        self.kind = None  # keyword and options that data lines belong to
        self.pending: list = []

    def fail(self, number: int, fact: str, hint: str = "the file is damaged, write it again") -> BadRequest:
        return BadRequest(f"cannot read {self.path.name}: line {number}: {fact}", hint)

    def text(self, path: Path) -> str:
        """The text of a file; pipes and devices, which may have no end, are refused before they are opened."""
        source = self.content if path == self.path else path
        try:
            about = source.stat()
            if not stat.S_ISREG(about.st_mode):
                raise BadRequest(f"cannot read {path.name}: it is not a regular file", "give a file, not a pipe, a device or a folder")
            self.bytes += about.st_size
            if self.bytes > MOST_BYTES:
                raise BadRequest(f"{self.path.name} and the files that it includes have more than {MOST_BYTES >> 20} MiB", "give a smaller mesh")
            return source.read_text("utf-8-sig")
        except UnicodeDecodeError as error:
            raise BadRequest(f"cannot read {path.name}: it is no text in UTF-8 (byte {error.start})", "save it as UTF-8") from None
        except OSError as error:
            raise BadRequest(f"cannot read {path.name}: {error.strerror}", "give the included file too") from None

    def read(self, path: Path) -> None:
        """All lines of a file and of those that it includes."""
        if path in self.open:
            names = " → ".join(file.name for file in [*self.open, path])
            raise BadRequest(f"cannot read {self.path.name}: files include each other: {names}", "remove one *INCLUDE of them")
        if len(self.open) == MOST_LEVELS or self.files == MOST_FILES:
            fact = f"more than {MOST_LEVELS} levels of *INCLUDE, or more than {MOST_FILES} included files"
            raise BadRequest(f"cannot read {self.path.name}: {fact}", "write the mesh into fewer files")
        self.files += 1
        self.open.append(path)
        self.lines(self.text(path))
        self.open.pop()

    def lines(self, text: str) -> None:
        """Keywords with their data lines."""
        keyword, number = "", 0
        for number, line in enumerate(text.split("\n"), 1):
            line = line.strip()
            if not line or line.startswith("**"):
                continue
            if line.startswith("*") or keyword:
                keyword += line
                if not keyword.endswith(","):
                    self.start(keyword, number)
                    keyword = ""
                continue
            try:
                self.data([word.strip() for word in line.rstrip(",").split(",")])
            except (ValueError, IndexError) as error:
                raise self.fail(number, f"{line[:40]!r} does not fit *{(self.kind or ['?'])[0]} ({error})") from None
        if self.pending:
            raise self.fail(number, "the last element has too few nodes")

    def start(self, line: str, number: int) -> None:
        """A keyword line."""
        name, *options = [word.strip() for word in line[1:].split(",")]
        given = {}
        for option in filter(None, options):
            key, _, value = option.partition("=")
            given[key.strip().lower()] = value.strip().strip('"')
        word = " ".join(name.lower().split())
        if self.pending:
            raise self.fail(number, "the element before has too few nodes")
        self.kind = (word, given)
        if word == "part":
            self.scope = self.parts[given.get("name", "").lower()] = Part()
        elif word == "end part":
            self.scope = self.parts[""]
        elif word == "assembly":
            self.scope = self.assembly
        elif word == "instance":
            part = self.parts.get(given.get("part", "").lower())
            if part is None:
                raise self.fail(number, f"there is no part {given.get('part', '')}")
            self.inside = self.instances[given.get("name", "").lower()] = Instance(part)
            self.scope = Part() if not part.nodes else part
        elif word == "end instance":
            self.inside, self.scope = None, self.assembly
        elif word == "end assembly":
            self.scope = self.parts[""]
        elif word == "include":
            if not given.get("input"):
                raise self.fail(number, "*INCLUDE names no file", "add INPUT= with its name")
            self.read(self.path.parent / given["input"])
        elif word == "element":
            self.element = self.element_kind(given.get("type", "").upper(), number)
        if word in WITH_INPUT and given.get("input"):
            self.read(self.path.parent / given["input"])

    def element_kind(self, name: str, number: int) -> tuple | None:
        """gmsh's kind and the number of nodes; none of elements that have no volume and are no facets."""
        for start in sorted(ELEMENTS, key=len, reverse=True):
            rest = name[len(start) :]
            if name.startswith(start) and not rest[:1].isdigit():
                return ELEMENTS[start]
        if "C3D" in name:
            raise self.fail(number, f"elements of the type {name} are not read", "write it with C3D4, C3D10, C3D6 or C3D8")
        return None

    def data(self, words: list) -> None:
        """A data line."""
        word, given = self.kind or ("", {})
        scope = self.scope
        if word == "instance":
            self.inside.lines.append([float(x) for x in words])
        elif word == "node":
            label = int(words[0])
            if len(words) < 4:
                raise ValueError("three coordinates are wanted")
            scope.nodes[label] = [float(x or 0) for x in words[1:4]]
            self.add(scope.node_sets, given.get("nset"), [label])
        elif word == "element" and self.element:
            self.pending += [int(w) for w in words if w]
            kind, count = self.element
            if len(self.pending) > count + 1:
                raise ValueError(f"{count} nodes are wanted")
            if len(self.pending) == count + 1:
                label, *nodes = self.pending
                scope.elements[label] = (kind, nodes)
                self.add(scope.element_sets, given.get("elset"), [label])
                self.pending = []
        elif word in ("nset", "elset"):
            sets = scope.node_sets if word == "nset" else scope.element_sets
            labels = [(given.get("instance", "").lower(), int(w) if w.lstrip("-").isdigit() else w) for w in words if w]
            if "generate" in given:
                first, last, step = ([label for _, label in labels] + [1])[:3]
                labels = [(labels[0][0], label) for label in range(first, last + 1, step)]
            self.add(sets, given.get(word), labels if scope is self.assembly else [label for _, label in labels])
        elif word == "surface" and given.get("type", "ELEMENT").upper() == "ELEMENT":
            member = int(words[0]) if words[0].isdigit() else words[0]
            self.add(scope.surfaces, given.get("name"), [(member, words[1].upper() if len(words) > 1 else "")])

    @staticmethod
    def add(sets: dict, name: str | None, labels: list) -> None:
        if name:
            sets.setdefault(name, []).extend(labels)


def members(sets: dict, labels: list) -> list:
    """The labels of a list, those of the sets it names included."""
    by_name = {name.lower(): list_ for name, list_ in sets.items()}
    found = []
    for label in labels:
        found += members(sets, by_name.get(label.lower(), [])) if isinstance(label, str) else [label]
    return found


def read(path: Path, content: Path) -> Blocks:
    """The cells, sets and surfaces of an input file, whose unpacked text is in `content`; sets of an instance keep their name."""
    reader = Reader(path, content)
    reader.read(path)
    placed = reader.instances or {name: Instance(part) for name, part in reader.parts.items() if part.nodes}
    points, rows, facets = [], {}, {}  # rows: kind -> nodes; facets: corners -> (kind, names)
    where, node_sets, sets = {}, {}, {}  # where: (instance, element) -> (kind, row)
    start = {}
    for name, instance in placed.items():
        part, offset = instance.part, len(points)
        number = {label: offset + i for i, label in enumerate(part.nodes)}
        start[name] = number
        points += instance.place(np.array(list(part.nodes.values()), float).reshape(-1, 3)).tolist()
        for label, (kind, nodes) in part.elements.items():
            lost = [node for node in nodes if node not in number]
            if lost:
                raise BadRequest(f"cannot read {path.name}: element {label} refers to node {lost[0]}, which is not there", "write it again")
            where[name, label] = (kind, len(rows.setdefault(kind, [])))
            rows[kind].append([number[node] for node in nodes])
        for of, labels in part.node_sets.items():
            node_sets.setdefault(of, []).extend(number[n] for n in members(part.node_sets, labels) if n in number)
        for of, labels in part.element_sets.items():
            sets.setdefault(of, []).extend(where[name, e] for e in members(part.element_sets, labels) if (name, e) in where)
        for of, faces in part.surfaces.items():
            for member, face in faces:
                for label in members(part.element_sets, [member]):
                    add_facet(facets, of, part.elements.get(label), face, number)
    assembly_sets(reader, start, where, node_sets, sets, facets)
    return blocks(np.array(points, float).reshape(-1, 3), rows, facets, sets, node_sets)


def assembly_sets(reader: Reader, start: dict, where: dict, node_sets: dict, sets: dict, facets: dict) -> None:
    """Sets and surfaces of the assembly, whose members name their instance."""
    assembly = reader.assembly
    for name, labels in assembly.node_sets.items():
        pairs = [pair for pair in labels if isinstance(pair[1], int)]
        node_sets.setdefault(name, []).extend(start[i][n] for i, n in pairs if n in start.get(i, {}))
    for name, labels in assembly.element_sets.items():
        sets.setdefault(name, []).extend(where[pair] for pair in labels if pair in where)
    by_name = {name.lower(): labels for name, labels in assembly.element_sets.items()}
    for name, faces in assembly.surfaces.items():
        for member, face in faces:
            for i, label in by_name.get(str(member).lower(), []):
                if i in reader.instances:
                    add_facet(facets, name, reader.instances[i].part.elements.get(label), face, start[i])


def add_facet(facets: dict, name: str, element: tuple | None, face: str, number: dict) -> None:
    """A face S1, S2, … of a solid element; shells and faces that it does not have are passed over."""
    if element is None or element[0] not in FACES or not face[1:].isdigit() or not 0 < int(face[1:]) <= len(FACES[element[0]]):
        return
    corners = tuple(number[element[1][k]] for k in FACES[element[0]][int(face[1:]) - 1])
    facets.setdefault(corners, set()).add(name)


def blocks(points: np.ndarray, rows: dict, facets: dict, sets: dict, node_sets: dict) -> Blocks:
    """Everything by kinds of cells, with masks."""
    cells = []
    for kind, nodes in rows.items():
        nodes = np.array(nodes, int)
        cells.append((kind, nodes[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]] if kind == 11 else nodes))
    order = list(rows)
    faces = {kind: [c for c in facets if len(c) == size] for kind, size in ((2, 3), (3, 4))}
    cells += [(kind, np.array(list_, int)) for kind, list_ in faces.items() if list_]
    found = {}
    for name, list_ in sets.items():
        masks = [np.zeros(len(block), bool) for _, block in cells]
        for kind, row in list_:
            masks[order.index(kind)][row] = True
        found[name] = masks
    for name in sorted(set().union(*facets.values())):
        masks = found.setdefault(name, [np.zeros(len(block), bool) for _, block in cells])
        for i, (kind, block) in list(enumerate(cells))[len(order) :]:
            masks[i] |= np.array([name in facets[tuple(corners)] for corners in block.tolist()])
    # Names that begin so are of Abaqus's own making
    known = [{name: list_ for name, list_ in sets.items() if not name.startswith("_")} for sets in (found, node_sets)]
    return Blocks(points, cells, known[0], {name: np.array(nodes, int) for name, nodes in known[1].items()})
