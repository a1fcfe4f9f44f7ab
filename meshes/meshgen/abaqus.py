"""Abaqus input as cells, sets and surfaces: instances in their places, and sets with all their members."""

from collections import Counter
from functools import cached_property
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
FACES |= {17: FACES[5], 12: FACES[5], 18: FACES[6]}
PLATES = (2, 9, 3)  # Kinds of shells, membranes and rigid faces
SIDES = ("", "SPOS", "SNEG")  # Faces of shells and membranes, which are facets themselves
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
    points, rows = [], {}  # rows: kind -> nodes
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
    facets, of_shells = add_surfaces(found, rows, number, where, sets, node_sets)
    hold_surfaces(of_shells.union(*facets.values()), sets, node_sets)
    notes = leave_out_plates(rows, facets, sets, node_sets)
    result = blocks(np.array(points, float).reshape(-1, 3), rows, facets, sets, node_sets)
    result.notes = notes
    give_labels(result, [node for of in number.values() for node in of], [element for of in where.values() for element in of], rows, where)
    return result


def give_labels(result: Blocks, nodes: list, elements: list, rows: dict, where: dict) -> None:
    """Gives nodes and elements their labels, unless several instances have the same; the faces of surfaces get numbers behind them."""
    if len(set(nodes)) == len(nodes):
        result.node_numbers = np.array(nodes, int)
    if len(set(elements)) < len(elements):
        return
    of_kind = {kind: np.zeros(len(list_), int) for kind, list_ in rows.items()}
    for places in where.values():
        for element, (kind, row) in places.items():
            of_kind[kind][row] = element
    result.numbers, last = list(of_kind.values()), max(elements, default=0)
    for _, faces in result.cells[len(rows) :]:
        result.numbers.append(np.arange(last + 1, last + 1 + len(faces)))
        last += len(faces)


class Faces:
    """The faces of the solid elements by their points. rows: kind -> points of its elements."""

    def __init__(self, rows: dict):
        self.rows = rows

    def all(self, kind: int, row: int) -> list:
        """Corners of the faces S1, S2, … of an element."""
        return [tuple(self.rows[kind][row][k] for k in face) for face in FACES.get(kind, ())]

    @cached_property
    def count(self) -> Counter:
        """In how many elements a face is, by its corners."""
        return Counter(frozenset(face) for kind, list_ in self.rows.items() for row in range(len(list_)) for face in self.all(kind, row))

    def named(self, kind: int, row: int, name: str) -> list:
        """Corners of the face of a name, or without one of all faces that are exposed; empty where there is no such face."""
        if not name:
            return [face for face in self.all(kind, row) if self.count[frozenset(face)] == 1]
        return [face for i, face in enumerate(self.all(kind, row), 1) if name == f"S{i}"]


def add_surfaces(found: Sets, rows: dict, number: dict, where: dict, sets: dict, node_sets: dict) -> tuple:
    """Adds surfaces of nodes to `node_sets`, and those of shells, which are facets themselves, to `sets`.

    Returns corners -> names of faces of solids, and the names of the surfaces of shells."""
    facets, of_shells, faces = {}, set(), Faces(rows)

    def refuse(fact: str) -> BadRequest:
        return BadRequest(f"cannot read {found.reader.path.name}: {fact}", "list faces of solids, or shells with SPOS or SNEG, or remove the surface")

    for region, scope, of, members in found.all("surfaces"):
        added = 0
        for member, face in members:
            for i, label in found.labels("node_sets" if face is None else "element_sets", scope, member, of):
                if face is None:
                    node_sets.setdefault(region, []).extend([number[i][label]] if label in number[i] else [])
                    added += 1
                    continue
                kind, row = where[i][label]
                if kind not in FACES and face in SIDES:
                    sets.setdefault(region, []).append((kind, row))
                    of_shells.add(region)
                    added += 1
                    continue
                corners = faces.named(kind, row, face)
                if face and not corners:
                    raise refuse(f"{of} names the face {face} of element {label}, which has none of that name")
                for one in corners:
                    facets.setdefault(one, set()).add(region)
                added += len(corners)
        if members and not added:
            raise refuse(f"{of} holds no face")
    return facets, of_shells


def hold_surfaces(surfaces: set, sets: dict, node_sets: dict) -> None:
    """Adds a node set without nodes for every of these surfaces whose name an element set of cells has too: it has the nodes of the facets."""
    for name in sorted(surfaces):
        if any(kind in FACES for kind, _ in sets.get(name, ())):
            node_sets.setdefault(name, [])


def leave_out_plates(rows: dict, facets: dict, sets: dict, node_sets: dict) -> list:
    """Takes shells, membranes and rigid faces with nodes of no solid out of the sets, since they are no faces of the body. Returns notes."""
    solid = {node for kind, list_ in rows.items() if kind in FACES for nodes in list_ for node in nodes}
    if not solid:
        return []  # A surface, of which the body is made

    def is_apart(kind: int, row: int) -> bool:
        return kind in PLATES and not solid.issuperset(rows[kind][row])

    apart = {name: sum(is_apart(*member) for member in members) for name, members in sets.items()}
    for name in apart:
        sets[name] = [member for member in sets[name] if not is_apart(*member)]
    kept = set(node_sets).union(*facets.values())
    empty = [name for name, members in sets.items() if not members and name not in kept]
    left_out = {name: f"{count} element{'s' if count > 1 else ''}" for name, count in apart.items() if count and name not in empty}
    notes = [f"left out of the set {name}: {count} (shells, membranes or rigid faces) apart from the solids" for name, count in left_out.items()]
    if empty:
        notes.append(f"sets whose elements are neither solids nor faces of solids are no regions: {', '.join(empty)}")
    return notes


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
