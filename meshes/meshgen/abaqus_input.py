"""Text of Abaqus input: nodes, elements, sets and surfaces by the parts and instances that contain them."""

import stat
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from . import abaqus_keywords
from .errors import BadRequest

# Beginning of the name of an element -> (gmsh's kind, nodes); hybrid, reduced and modified elements have further letters.
# gmsh writes the facets of a solid as plane elements (CPS…).
ELEMENTS = {
    "C3D4": (4, 4), "C3D10": (11, 10), "C3D8": (5, 8), "C3D6": (6, 6), "C3D5": (7, 5), "C3D20": (17, 20), "C3D15": (18, 15), "C3D27": (12, 27),
    "S3": (2, 3), "S6": (9, 6), "STRI3": (2, 3), "M3D3": (2, 3), "SFM3D3": (2, 3), "R3D3": (2, 3), "S4": (3, 4), "M3D4": (3, 4), "SFM3D4": (3, 4),
    "R3D4": (3, 4), "T3D2": (1, 2), "B31": (1, 2), "CPS3": (2, 3), "CPS4": (3, 4), "CPS6": (9, 6), "M3D6": (9, 6), "SFM3D6": (9, 6), "STRI65": (9, 6),
}  # fmt: skip
# Beginnings of the names of elements without volume, which are skipped: bars, shells, planes, rigid bodies, springs and other links
WITHOUT_VOLUME = (
    "T2D", "T3D", "B2", "B3", "PIPE", "FRAME", "ELBOW", "S3", "S4", "S6", "S8", "S9", "STRI", "SAX", "DS3", "DS4", "DS6", "DS8", "DSAX", "CPE", "CPS",
    "CAX", "CGAX", "CINPE", "CINPS", "CINAX", "COH2D", "COHAX", "DC1D", "DC2D", "DCAX", "DCC1D", "DCC2D", "DCCAX", "AC1D", "AC2D", "ACAX", "M3D", "MAX",
    "MCL", "MGAX", "SFM", "R2D", "R3D", "RAX", "RB2D", "RB3D", "SPRING", "DASHPOT", "MASS", "ROTARYI", "HEATCAP", "JOINT", "CONN", "GAP", "DGAP",
    "DCOUP", "DRAG", "ITS", "ITT", "ISL", "IRS", "LS3S", "LS6", "PSI", "F2D2", "F3D3", "FAX2", "FLINK", "ASI",
)  # fmt: skip
# Keywords whose data lines may be in the file given by INPUT=; the program has the same list
WITH_INPUT = ("node", "element", "nset", "elset", "surface")

# Keyword -> kind of the set that its data lines extend, and the option that names it
SETS = {
    "node": ("node_sets", "nset"), "nset": ("node_sets", "nset"), "element": ("element_sets", "elset"), "elset": ("element_sets", "elset"),
    "surface": ("surfaces", "name"),
}  # fmt: skip
# Keywords at which another part, instance or assembly begins or ends; a coordinate system of nodes ends with it
PLACES = ("part", "end part", "assembly", "end assembly", "instance", "end instance")
FLAT = 1e-12  # sine of an angle below which directions are the same
WHOLE = "write the file with all its nodes and elements, as Abaqus/CAE does"

# Limits of *INCLUDE and INPUT=, the same as in the program; a file that is included twice counts twice
MOST_LEVELS = 16
MOST_FILES = 1000
MOST_BYTES = 4 << 30


@dataclass(frozen=True)
class NodesOf:
    """The nodes of an element set, as a member of a node set."""

    elements: str


@dataclass
class Part:
    """Nodes and elements by their labels, sets and surfaces by their names in lower case.

    Members of sets are (instance, member): a label, a range of labels of which some may be missing, the name of a set, or NodesOf. The
    instance is empty for what is in the same place. Surfaces have (member, face): an empty face means the exposed faces, and None is for
    nodes. `name` is as the file spells it."""

    name: str = ""
    nodes: dict = field(default_factory=dict)
    elements: dict = field(default_factory=dict)  # label -> (kind, labels of its nodes)
    passed: set = field(default_factory=set)  # labels of elements without volume that are no facets
    node_sets: dict = field(default_factory=dict)
    element_sets: dict = field(default_factory=dict)
    surfaces: dict = field(default_factory=dict)

    def copy(self) -> "Part":
        """A copy of the part that can be extended."""
        sets = ({name: list(members) for name, members in of.items()} for of in (self.node_sets, self.element_sets, self.surfaces))
        return Part(self.name, dict(self.nodes), dict(self.elements), set(self.passed), *sets)


@dataclass
class Instance:
    """A part at its position in the assembly, with anything defined in the instance itself."""

    name: str
    part: Part
    lines: list = field(default_factory=list)

    def add(self, numbers: list) -> None:
        """Read a data line. Trailing coordinates of the translation may be omitted."""
        if not self.lines and len(numbers) <= 3:
            self.lines.append(numbers + [0.0] * (3 - len(numbers)))
        elif len(self.lines) == 1 and len(numbers) == 7 and numbers[:3] != numbers[3:6]:
            self.lines.append(numbers)
        else:
            raise ValueError("three coordinates of the translation are wanted, then two different points of the axis and the angle")

    def place(self, points: np.ndarray) -> np.ndarray:
        """Apply the translation, then the rotation [degrees] about the axis through two points."""
        if self.lines:
            points = points + np.array(self.lines[0])
        if len(self.lines) > 1:
            a, b, angle = np.array(self.lines[1][:3]), np.array(self.lines[1][3:6]), np.radians(self.lines[1][6])
            u = (b - a) / np.linalg.norm(b - a)
            v = points - a
            points = a + v * np.cos(angle) + np.cross(u, v) * np.sin(angle) + np.outer(v @ u, u) * (1 - np.cos(angle))
        return points


@dataclass
class System:
    """The rectangular coordinate system in which nodes are given: the lines of *SYSTEM with the points a and b, and c.

    a is the origin, b lies on the x-axis, c in the xy-plane on the side of the y-axis. Without c the z-axis is unchanged, without b all axes are."""

    lines: list = field(default_factory=list)

    def add(self, numbers: list) -> None:
        """Read a data line, in which trailing coordinates may be omitted."""
        whole = 3 if self.lines or len(numbers) <= 3 else 6
        if len(self.lines) == 2 or self.lines and len(self.lines[0]) == 3 or len(numbers) > whole:
            raise ValueError("three or six coordinates, then three are wanted")
        self.lines.append(numbers + [0.0] * (whole - len(numbers)))

    def frame(self) -> tuple | None:
        """The origin, and the axes as rows; None if nodes are given in the global system."""
        if not self.lines:
            return None
        origin, b = np.array(self.lines[0][:3]), np.array(self.lines[0][3:])
        if not len(b):
            return origin, np.eye(3)
        x = b - origin
        if len(self.lines) > 1:
            other = np.array(self.lines[1]) - origin
            up = np.cross(x, other)
            is_flat = np.linalg.norm(up) <= FLAT * np.linalg.norm(x) * np.linalg.norm(other)
        else:
            up = np.array([0.0, 0.0, 1.0])
            is_flat = np.linalg.norm(x[:2]) <= FLAT * np.linalg.norm(x)
            x[2] = 0
        if is_flat:
            raise ValueError("the points of *SYSTEM determine no axes")
        x, up = x / np.linalg.norm(x), up / np.linalg.norm(up)
        return origin, np.array([x, np.cross(up, x), up])


class Reader:
    """The state of reading: the part, instance or assembly that keywords refer to."""

    def __init__(self, path: Path, content: Path):
        self.path = path
        self.content = content  # the unpacked text of the file itself
        self.open: list = []  # stack of included files; the last is being read
        self.files = self.bytes = 0
        self.number = 0  # of the current line
        self.model = Part()  # content outside of parts and instances: everything, or the sets of the assembly
        self.parts: dict = {}
        self.instances: dict = {}
        self.spelling: dict = {}  # names in lower case -> as first spelled
        self.scope = self.model
        self.inside = None  # an instance whose position lines follow
        self.kind = None  # keyword and options that data lines belong to
        self.system = System()
        self.frame = None  # of the nodes that follow
        self.members: list = []  # of the set that data lines extend
        self.pending: list = []

    def fail(self, number: int, fact: str, hint: str = "the file is damaged, write it again") -> BadRequest:
        return BadRequest(f"cannot read {self.open[-1].name}: line {number}: {fact}", hint)

    def text(self, path: Path) -> str:
        """The text of a file; pipes and devices, which may be endless, are refused before they are opened."""
        source = self.content if path == self.path else path
        try:
            about = source.stat()
            if not stat.S_ISREG(about.st_mode):
                raise BadRequest(f"cannot read {path.name}: it is not a regular file", "give a file, not a pipe, a device or a folder")
            self.bytes += about.st_size
            if self.bytes > MOST_BYTES:
                raise BadRequest(f"{self.path.name} and the files that it includes have more than {MOST_BYTES >> 20} MiB", "give a smaller mesh")
            return source.read_text("utf-8-sig", "surrogateescape")
        except OSError as error:
            raise BadRequest(f"cannot read {path.name}: {error.strerror}", "give the included file too") from None

    def read(self, path: Path) -> None:
        """Read all lines of a file and of the files that it includes."""
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

    def named(self, name: str) -> Path:
        """The path of a named file, which may use backslashes; the program resolves it in the same way."""
        return self.path.parent / name.replace("\\", "/")

    def lines(self, text: str) -> None:
        """Read keywords with their data lines."""
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
            self.number = number
            self.legible((self.kind or [""])[0], line, number)
            try:
                self.data([word.strip() for word in line.rstrip(",").split(",")])
            except (ValueError, IndexError) as error:
                fact = f"{line[:40]!r} does not fit *{(self.kind or ['?'])[0]} ({error})"
                raise self.fail(number, fact, "correct the line, or write the file again") from None
        if self.pending:
            raise self.fail(number, "the last element has too few nodes")

    def start(self, line: str, number: int) -> None:
        """Read a keyword line."""
        word, given = self.keyword(line, number)
        if self.pending:
            raise self.fail(number, "the element before has too few nodes")
        self.legible(word, line, number)
        self.kind = (word, given)
        self.members = self.set_of(word, given)
        if word in abaqus_keywords.GENERATORS:
            raise self.fail(number, f"*{word.upper()} is not read", WHOLE)
        if word in PLACES:
            self.system = System()
        if word == "part":
            name = self.new_name(self.parts, word, given, number)
            self.scope = self.parts[name.lower()] = Part(name)
        elif word in ("end part", "assembly", "end instance", "end assembly"):
            self.inside, self.scope = None, self.model
        elif word == "instance":
            part = self.parts.get(given.get("part", "").lower())
            if part is None:
                raise self.fail(number, f"there is no part {given.get('part', '')}")
            name = self.new_name(self.instances, word, given, number)
            self.inside = self.instances[name.lower()] = Instance(name, part.copy())
            self.scope = self.inside.part
        elif word == "node" and given.get("system", "R").upper() not in ("R", "C"):
            raise self.fail(number, f"*NODE, SYSTEM={given['system']} is not read", "write the nodes in rectangular or cylindrical coordinates")
        elif word == "system":
            self.system = System()
        elif word == "surface" and ("combine" in given or "crop" in given):
            raise self.fail(number, "surfaces made of others are not read", "list the elements of the surface with their faces")
        elif word == "nset" and given.get("elset"):
            self.members.append((given.get("instance", ""), NodesOf(given["elset"])))
        elif word == "include":
            if not given.get("input"):
                raise self.fail(number, "*INCLUDE names no file", "add INPUT= with its name")
            self.read(self.named(given["input"]))
        elif word == "element":
            self.element = self.element_kind(given.get("type", "").upper(), number)
        if word == "node":
            try:
                self.frame = self.system.frame()
            except ValueError as error:
                raise self.fail(number, str(error), "give its origin, a point of its x-axis, and one off that axis") from None
        if word in WITH_INPUT and given.get("input"):
            self.read(self.named(given["input"]))

    def keyword(self, line: str, number: int) -> tuple:
        """The keyword of a line, and its options with their values."""
        name, *options = [word.strip() for word in line[1:].split(",")]
        given, word = {}, name
        try:
            word = abaqus_keywords.keyword(name)
            for key, _, value in (option.partition("=") for option in options if option):
                known = abaqus_keywords.option(key, word)
                if not known and word in abaqus_keywords.STRICT:
                    raise self.fail(number, f"*{word.upper()} with {key.strip().upper()!r} is not read", "remove the option, or correct it")
                given[known or key.strip().lower()] = value.strip().strip('"')
        except abaqus_keywords.Unclear as several:
            raise self.fail(number, f"{line[:40]!r} can mean {several}", "spell the keyword and its options out") from None
        return word, given

    def new_name(self, there: dict, word: str, given: dict, number: int) -> str:
        """The name of a part or an instance, which must be unique."""
        name = given.get("name", "")
        if name.lower() in there:
            raise self.fail(number, f"another *{word.upper()} is called {name!r} too", "give each a name of its own")
        return name

    def legible(self, word: str, line: str, number: int) -> None:
        """Refuse a line with mesh data or names that is not UTF-8. Comments, headings and materials, which are not used, may be in another encoding."""
        if word in (*SETS, *PLACES, "include") and not line.isascii():
            try:
                line.encode()
            except UnicodeEncodeError:
                raise self.fail(number, "it is no text in UTF-8", "save the file as UTF-8") from None

    def set_of(self, word: str, given: dict) -> list:
        """The members of the set that a keyword names, which may be new; without a name, a list that belongs to no set.

        Names that differ only in case are the same."""
        kind, option = SETS.get(word, ("", ""))
        name = given.get(option)
        if not name or word == "surface" and given.get("type", "ELEMENT").upper() not in ("ELEMENT", "NODE"):
            return []
        self.spelling.setdefault(name.lower(), name)
        return getattr(self.scope, kind).setdefault(name.lower(), [])

    def element_kind(self, name: str, number: int) -> tuple | None:
        """gmsh's kind and the number of nodes; None for elements that have no volume and are not facets."""
        for start in sorted(ELEMENTS, key=len, reverse=True):
            rest = name[len(start) :]
            if name.startswith(start) and not rest[:1].isdigit():
                return ELEMENTS[start]
        if not name.startswith(WITHOUT_VOLUME):
            fact = f"elements of the type {name} are not read" if name else "*ELEMENT has no TYPE"
            raise self.fail(number, fact, "write solids with C3D4, C3D10, C3D6 or C3D8, and leave elements without volume out")
        return None

    def data(self, words: list) -> None:
        """Read a data line."""
        word, given = self.kind or ("", {})
        scope = self.scope
        if word == "instance":
            self.inside.add([real(x) for x in words])
        elif word == "system":
            self.system.add([real(x) for x in words])
        elif word == "node":
            label = int(words[0])
            if len(words) < 4:
                raise ValueError("three coordinates are wanted")
            x, y, z = (real(x) for x in words[1:4])
            if given.get("system", "").upper() == "C":
                x, y = x * np.cos(np.radians(y)), x * np.sin(np.radians(y))
            if self.frame:
                origin, axes = self.frame
                x, y, z = (origin + np.array([x, y, z]) @ axes).tolist()
            self.define(scope.nodes, "node", label, [x, y, z])
            self.members.append(("", label))
        elif word == "element" and self.element:
            self.pending += [int(w) for w in words if w]
            kind, count = self.element
            if len(self.pending) > count + 1:
                raise ValueError(f"{count} nodes are wanted")
            if len(self.pending) == count + 1:
                label, *nodes = self.pending
                self.define(scope.elements, "element", label, (kind, nodes))
                self.members.append(("", label))
                self.pending = []
        elif word == "element" and words[0].isdigit():
            scope.passed.add(int(words[0]))  # Also adds first nodes of continuation lines, which does no harm
        elif word in ("nset", "elset"):
            instance, labels = given.get("instance", ""), [member_of(w) for w in words if w]
            if "generate" in given:
                first, last, step = ([int(label) for label in labels] + [1])[:3]
                labels = [range(first, last + 1, step)]
            self.members += [(instance, label) for label in labels]
        elif word == "surface":
            is_of_nodes = given.get("type", "").upper() == "NODE"
            self.members.append((member_of(words[0]), None if is_of_nodes else words[1].upper() if len(words) > 1 else ""))

    def define(self, known: dict, what: str, label: int, content: list | tuple) -> None:
        """Add a node or an element. Repeating it changes nothing; different content with the same label is refused."""
        if known.setdefault(label, content) != content:
            hint = "give every node and element of a part a label of its own, or each of the joined meshes a part"
            raise self.fail(self.number, f"{what} {label} is defined before, and differently", hint)


def member_of(word: str) -> int | str:
    """A label, or the name of a set as spelled."""
    return int(word) if word.isdigit() else word.replace('"', "")


def real(word: str) -> float:
    """A number, also with a Fortran exponent; an omitted number is zero."""
    number = float(word.upper().replace("D", "E") or 0)
    if not np.isfinite(number):
        raise ValueError("a finite number is wanted")
    return number
