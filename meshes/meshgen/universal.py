"""Groups of I-DEAS universal files, element by element: gmsh keeps them for whole parts of one property number only, and not in all data sets."""

from .errors import BadRequest

NODES, ELEMENTS = 7, 8  # codes of the entities
WIDTH = {2417: 2, 2429: 2, 2430: 2, 2432: 2, 2435: 4, 2452: 4, 2467: 4, 2477: 4}  # numbers of an entity in each data set of groups


def groups(file: str, data: bytes) -> dict:
    """The numbers of the nodes and of the elements of each group by its name; those of a name that occurs again are added."""
    lines, found = data.decode("latin-1").splitlines(), {}
    marks = [number for number, line in enumerate(lines) if line.rstrip() == "    -1"]
    for begin, end in zip(marks, marks[1:]):
        label = lines[begin + 1].strip() if end > begin + 1 else ""
        if label.isdigit() and int(label) in WIDTH:
            try:
                read(lines[begin + 2 : end], WIDTH[int(label)], found)
            except (ValueError, IndexError):
                fact = f"the data set {label} that begins in line {begin + 1} is no list of groups"
                raise BadRequest(f"cannot read {file}: {fact}", "write it again") from None
    return found


def read(lines: list, width: int, found: dict) -> None:
    """Add the groups of a data set: a line of eight numbers, of which the first is that of the group and the last how many entities it has, its name, and eight
    numbers a line for the entities."""
    at = 0
    while at + 1 < len(lines):
        head = [int(word) for word in lines[at].split()]
        name = lines[at + 1].strip() or f"group_{head[0]}"
        rows = -(-head[-1] * width // 8)
        words = [int(word) for line in lines[at + 2 : at + 2 + rows] for word in line.split()]
        nodes, elements = found.setdefault(name, (set(), set()))
        for kind, number in zip(words[::width], words[1::width]):
            if kind in (NODES, ELEMENTS):
                (nodes if kind == NODES else elements).add(number)
        at += 2 + rows
