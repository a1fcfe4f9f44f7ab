"""Abaqus input as cells, sets and surfaces: instances in their places, and sets with all their members."""

from pathlib import Path

import numpy as np

from .abaqus_input import Instance, NodesOf, Reader, member_of
from .blocks import Blocks
from .errors import BadRequest

# Faces S1, S2, … of a kind by their corners
FACES = {
    4: [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)],
    11: [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)],
    5: [(0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)],
    6: [(0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)],
    7: [(0, 1, 2, 3), (0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)],
}
WORDS = {"node_sets": ("node", "node set"), "element_sets": ("element", "element set"), "surfaces": ("element", "surface")}


class Sets:
    """The sets and surfaces of a file, whose members may be sets themselves, also those of instances.

    scopes: where they are; the empty name is that of the assembly, or of a file without one."""

    def __init__(self, reader: Reader):
        self.reader = reader
        placed = reader.instances or {name: Instance(name, part) for name, part in reader.parts.items() if part.nodes}
        self.scopes = {"": Instance("", reader.model)} | placed

    def region(self, kind: str, scope: str, name: str) -> str:
        """The region that a set belongs to: one for all sets of a name, but that of the assembly keeps the name for itself."""
        spelled = self.reader.spelling[name]
        hidden = scope and name in getattr(self.reader.model, kind)
        return f"{self.scopes[scope].name}.{spelled}" if hidden else spelled

    def labels(self, kind: str, scope: str, member: str | int, of: str) -> list:
        """The nodes or elements behind a member of the set or surface `of`, as (scope, label); sets of each other have the same."""
        found, seen, rest = {}, set(), [(scope, member)]
        while rest:
            scope, member = rest.pop()
            part = self.scopes[scope].part
            there = part.nodes if kind == "node_sets" else part.elements
            if isinstance(member, range):
                shorter = member if len(member) < len(there) else there
                found.update(dict.fromkeys((scope, label) for label in shorter if label in there and label in member))
            elif isinstance(member, NodesOf):
                cells = self.labels("element_sets", scope, member.elements, of)
                found.update(dict.fromkeys((i, node) for i, label in cells for node in self.scopes[i].part.elements[label][1]))
            elif isinstance(member, int) and member in there:
                found[scope, member] = None
            elif isinstance(member, int) and (kind == "node_sets" or member not in part.passed):
                raise self.absent(f"{WORDS[kind][0]} {member}", scope, of)
            elif isinstance(member, str) and (scope, member.lower()) not in seen:
                seen.add((scope, member.lower()))
                rest += self.members(kind, scope, member, of)
        return list(found)

    def members(self, kind: str, scope: str, name: str, of: str) -> list:
        """The members of a set as (scope, member). Names in the assembly may begin with that of an instance and a dot."""
        found = getattr(self.scopes[scope].part, kind).get(name.lower())
        if found is not None:
            unknown = next((instance for instance, _ in found if instance and instance.lower() not in self.scopes), None)
            if unknown:
                raise self.absent(f"instance {unknown}", scope, of)
            return [(instance.lower() or scope, member) for instance, member in found]
        for instance in self.scopes:
            if instance and not scope and name.lower().startswith(f"{instance}."):
                return [(instance, member_of(name[len(instance) + 1 :]))]
        raise self.absent(f"{WORDS[kind][1]} {name}", scope, of)

    def absent(self, what: str, scope: str, of: str) -> BadRequest:
        instance = self.scopes[scope]
        place = f"in {instance.name if self.reader.instances else instance.part.name}" if scope else "there"
        return BadRequest(f"cannot read {self.reader.path.name}: {of} refers to {what}, which is not {place}", "define it, or remove it from the set")

    def all(self, kind: str):
        """(region, scope, name of the set or surface in words, members) of those that are not of Abaqus's own making."""
        for scope, instance in self.scopes.items():
            for name, members in getattr(instance.part, kind).items():
                if not name.startswith("_"):
                    spelled = self.reader.spelling[name]
                    yield self.region(kind, scope, name), scope, f"{WORDS[kind][1]} {spelled}", name if kind != "surfaces" else members


def read(path: Path, content: Path) -> Blocks:
    """The cells, sets and surfaces of an input file, whose unpacked text is in `content`; sets of an instance keep their name."""
    reader = Reader(path, content)
    reader.read(path)
    found = Sets(reader)
    points, rows, facets = [], {}, {}  # rows: kind -> nodes; facets: corners -> names
    number, where = {}, {}  # scope -> node -> row of points; scope -> element -> (kind, row)
    for scope, instance in found.scopes.items():
        part, numbers, places = instance.part, number.setdefault(scope, {}), where.setdefault(scope, {})
        if scope or part.elements or not reader.instances:  # Reference points of an assembly belong to no cell
            numbers.update({label: len(points) + i for i, label in enumerate(part.nodes)})
            points += instance.place(np.array(list(part.nodes.values()), float).reshape(-1, 3)).tolist()
        for label, (kind, nodes) in part.elements.items():
            lost = [node for node in nodes if node not in numbers]
            if lost:
                raise BadRequest(f"cannot read {path.name}: element {label} refers to node {lost[0]}, which is not there", "write it again")
            places[label] = (kind, len(rows.setdefault(kind, [])))
            rows[kind].append([numbers[node] for node in nodes])
    node_sets, sets = {}, {}
    for region, scope, of, name in found.all("node_sets"):
        node_sets.setdefault(region, []).extend(number[i][n] for i, n in found.labels("node_sets", scope, name, of) if n in number[i])
    for region, scope, of, name in found.all("element_sets"):
        sets.setdefault(region, []).extend(where[i][e] for i, e in found.labels("element_sets", scope, name, of))
    for region, scope, of, faces in found.all("surfaces"):
        for member, face in faces:
            for i, label in found.labels("element_sets", scope, member, of):
                add_facet(facets, region, found.scopes[i].part.elements[label], face, number[i])
    return blocks(np.array(points, float).reshape(-1, 3), rows, facets, sets, node_sets)


def add_facet(facets: dict, name: str, element: tuple, face: str, number: dict) -> None:
    """A face S1, S2, … of a solid element; shells and faces that it does not have are passed over."""
    if element[0] not in FACES or not face[1:].isdigit() or not 0 < int(face[1:]) <= len(FACES[element[0]]):
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
    return Blocks(points, cells, found, {name: np.array(nodes, int) for name, nodes in node_sets.items()})
