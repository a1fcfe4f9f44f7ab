"""Nastran bulk data prepared for meshio: from BEGIN BULK to ENDDATA, one entry per line, with fields separated by commas."""

import re
from pathlib import Path

from .errors import BadRequest

# Cells in wide-field format
WIDE = re.compile(r"C(TETRA_?|HEXA_?|PENTA_?|PYRAM?_?|TRIA\w|QUAD\w)\s*\*")
# Cells -> possible numbers of nodes; further data of shells follow after the largest number
NODES = {
    "CTETRA": (4, 10), "CHEXA": (8, 20), "CPENTA": (6, 15), "CPYRAM": (5, 13), "CPYRA": (5, 13),
    "CTRIA3": (3,), "CTRIAR": (3,), "CTRIA6": (6,), "CQUAD4": (4,), "CQUADR": (4,), "CQUAD8": (8,), "CSHEAR": (4,),
}  # fmt: skip
# Names that meshio writes for cells with mid-edge nodes
OF_MESHIO = {"CTETRA_": "CTETRA", "CHEXA_": "CHEXA", "CPENTA_": "CPENTA", "CPYRA_": "CPYRA"}
# Entries beginning with C that are skipped: elements that have no volume and are not facets, and entries that are not elements
WITHOUT_VOLUME = re.compile(
    "C(AABSF|ACINF[34]|AERO[1-5]|AXIF[2-4]|BAR(AO)?|BEAM3?|BELT|BEND|BUSH([12]D)?|BUTT|CONEAX|CRSFIL|DAMP[1-5]|DUM[1-9]|ELAS[1-4]|FAST|FILLET|FLUID[2-4]|"
    "GAP|HADV|HBDY[EGP]|INTC|LOAD|MASS[1-4]|MBEAM|MBUSH|MFREE|MSPDP|ONM[12]|ONROD|ONT[A-Z]*|ONVM?|ORD[123][A-Z]|PLST[NS][3468]|QUADX?[48]?|QUAD9|RAC2D|REEP|"
    "ROD|SEAM|SET1?|SLOT[34]|SPR|SUPER|SUPEXT|TRAX[36]|TRIAX6?|TUBE|VISC|WELD|WSEAM|YAX|YJOIN|YSUP|YSYM)"
)
SHELLS = tuple(name for name, counts in NODES.items() if len(counts) == 1)


def bulk(path: Path, content: Path) -> str:
    """The bulk data of a file, whose unpacked text is in `content`; files without BEGIN BULK, as written by gmsh, contain nothing else.

    A file without ENDDATA is refused as truncated."""
    lines = content.read_text("latin-1").upper().split("\n")
    begin = next((i for i, line in enumerate(lines, 1) if line.split()[:2] == ["BEGIN", "BULK"]), 0)
    end = next((i for i, line in enumerate(lines) if i >= begin and line.lstrip().startswith("ENDDATA")), None)
    if end is None:
        raise BadRequest(f"cannot read {path.name}: its last line must be ENDDATA, so that a part is missing", "write or copy it again")
    written, points, used = [], {}, {}
    for number, name, fields in entries(path, lines[begin:end], begin):
        try:
            fields = checked(name, fields)
            if name == "GRID" and points.setdefault(fields[0], fields) != fields:
                raise ValueError(f"node {fields[0]} is defined before, and differently")
        except ValueError as error:
            raise BadRequest(f"cannot read {path.name}: line {number}: {name}: {error}", "correct the entry, or write the file again") from None
        if name in NODES:
            used.update(dict.fromkeys(fields[2:], number))
        if name == "GRID" or name in NODES:  # Springs, bars and masses have no volume and are not facets
            written.append(",".join([name, *fields]))
    lost = next((node for node in used if node not in points), None)
    if lost:
        raise BadRequest(f"cannot read {path.name}: line {used[lost]}: there is no GRID {lost}", "write the file again with all its nodes")
    return "\n".join(["BEGIN BULK", *written, "ENDDATA", ""])


def numbers(text: str) -> tuple:
    """Numbers of the nodes and cells of prepared bulk data, in their order."""
    entries = [line.split(",", 2) for line in text.split("\n")[1:-2]]
    of = {is_node: [int(number) for name, number, _ in entries if (name == "GRID") == is_node] for is_node in (True, False)}
    return of[True], of[False]


def entries(path: Path, lines: list, begin: int) -> list:
    """(number of the line, name, fields) of every entry, including its continuation lines."""
    found = []
    for number, line in enumerate(lines, begin + 1):
        line = line.partition("$")[0].rstrip()
        if not line or line.startswith(("//", "#")):
            continue
        if line.startswith("INCLUDE"):
            raise BadRequest(f"cannot read {path.name}: line {number}: INCLUDE is not read", "write the mesh into one file")
        if WIDE.match(line):
            raise BadRequest(f"cannot read {path.name}: line {number}: elements in wide fields are not read", "write elements in fields of 8 columns")
        head, fields = divided(line)
        if not head or head[0] in "+*":
            if not found:
                raise BadRequest(f"cannot read {path.name}: line {number} continues no entry", "write the file again")
            found[-1][2].extend(fields)
        else:
            name = head.rstrip("*").rstrip()
            found.append((number, OF_MESHIO.get(name, name), fields))
    return found


def divided(line: str) -> tuple:
    """The first field of a line and the data fields: 8 of 8 columns or, after a star, 4 of 16, or separated by commas. Tabs advance to the next multiple of 8."""
    if "," in line:
        head, *fields = [field.strip() for field in line.split(",")]
        count = 4 if "*" in head else 8
        if len(fields) == count + 1:
            fields.pop()  # The continuation mark
        return head, fields + [""] * (count - len(fields))
    line = line.expandtabs(8)
    head = line[:8].strip()
    width = 16 if "*" in head else 8
    return head, [line[i : i + width].strip() for i in range(8, 72, width)]


def checked(name: str, fields: list) -> list:
    """The fields of an entry that meshio reads, as it expects them; other entries are unchanged."""
    if name == "GRID":
        label, system, *place = fields[:5]
        return [whole(label), whole(system) if system else "", *(repr(real(x)) for x in place)]
    if name == "GRDSET" and fields[1].strip("0"):
        raise ValueError("nodes in a coordinate system of their own (CP) are not read, write all in the basic system")
    if name not in NODES:
        if name.startswith("C") and all(map(str.isdecimal, [fields[0], *fields[2:5]])) and not WITHOUT_VOLUME.fullmatch(name):
            raise ValueError("elements of this kind are not read")
        return fields
    counts, nodes = NODES[name], fields[2:]
    if name in SHELLS:
        nodes = nodes[: counts[0]]
    while nodes and not nodes[-1]:
        nodes.pop()
    if "" in nodes or len(nodes) not in counts:
        raise ValueError(f"{len([n for n in nodes if n])} nodes, where {' or '.join(map(str, counts))} are wanted")
    return [whole(fields[0]), whole(fields[1]) if fields[1] else "", *map(whole, nodes)]


def whole(word: str) -> str:
    """A whole number."""
    if not word.isdecimal():
        raise ValueError(f"{word!r} is not a whole number")
    return str(int(word))


def real(word: str) -> float:
    """A number as Nastran writes it: 7., 7.E0, 7.D0 and 7.+0; an omitted number is zero."""
    spelled = re.sub(r"(?<=[\d.])([+-])", r"E\1", word.replace("D", "E"))
    try:
        return float(spelled or 0)
    except ValueError:
        raise ValueError(f"{word!r} is not a number") from None
