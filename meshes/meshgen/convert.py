"""Conversion of a mesh file to MSH 4.1 with all its cells and sets, unchanged: units, numbers and defects of the file are kept.

Its reader in the program does the checking, dividing and merging. Node sets become physical groups of points, whose names are in a separate
section: groups of one name in a gmsh file are one region, but a node set does not include the nodes of a cell set of the same name.
Notes on what the conversion leaves out are also in a section of their own; the program reports them whenever the mesh is used."""

import contextlib
import gzip
import io
import re
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np

from . import abaqus, avs, nastran, netgen, su2, tetgen, universal, vtu
from .blocks import Blocks
from .errors import BadRequest
from .write import save

# meshio's name of a kind of cells -> (dimension, gmsh's number)
KINDS = {
    "vertex": (0, 15), "line": (1, 1), "line3": (1, 8), "triangle": (2, 2), "triangle6": (2, 9), "quad": (2, 3), "quad8": (2, 16),
    "quad9": (2, 10), "tetra": (3, 4), "tetra10": (3, 11), "hexahedron": (3, 5), "hexahedron20": (3, 17), "hexahedron27": (3, 12),
    "wedge": (3, 6), "wedge15": (3, 18), "wedge18": (3, 13), "pyramid": (3, 7), "pyramid13": (3, 19), "pyramid14": (3, 14), vtu.VOXEL: (3, 5),
}  # fmt: skip
DIMENSIONS = {number: dim for dim, number in KINDS.values()}  # of gmsh's kinds
DIMENSION_NAMES = ("point", "curve", "facets", "cells")
# Node orders that differ from gmsh's
ORDERS = {"tetra10": [0, 1, 2, 3, 4, 5, 6, 7, 9, 8], vtu.VOXEL: vtu.AS_HEXAHEDRON}
# File extension that a meshio reader expects
ENDINGS = {
    "vtu": ".vtu", "vtk": ".vtk", "abaqus": ".inp", "nastran": ".bdf", "netgen": ".vol", "stl": ".stl",
    "ply": ".ply", "off": ".off", "obj": ".obj", "dolfin-xml": ".xml",
}  # fmt: skip
# Formats that are read here
READERS = {"abaqus": abaqus.read, "su2": su2.read}
# Formats of which meshio gets a prepared text
TEXTS = {"nastran": nastran.bulk, "avsucd": avs.grid}
# Readers of the node and cell numbers in these texts
NUMBERS = {"nastran": nastran.numbers, "avsucd": avs.numbers}
# Formats whose nodes and cells are counted from zero
FROM_ZERO = ("vtu", "xdmf", "dolfin-xml")
# Beginning of a file that gmsh reads -> the extension that it expects
GMSH_ENDINGS = {b"$": ".msh", b"\x89HDF": ".med"}
# Keywords of Medit with cells that have middle nodes
OF_ORDER_2 = re.compile(rb"^\s*((?:Edges|Triangles|Quadrilaterals|Tetrahedra|Prisms|Pyramids|Hexahedra)[PQ]\d)\s*$", re.M)
MOST_VALUES = 64  # integer cell data with more values do not define regions


def run(path: str, format: str, output: str) -> dict:
    """Convert a file; returns a summary of its content."""
    source = Path(path)
    blocks = read(source, format)
    if not len(blocks.points) or not any(len(rows) for _, rows in blocks.cells):
        raise BadRequest(f"{source.name} holds no cells", "check that the mesh is in the file, not only its geometry")
    save("".join(lines(blocks)).encode(), output)
    return {"nodes": len(blocks.points), "cells": sum(len(rows) for _, rows in blocks.cells)}


def read(path: Path, format: str) -> Blocks:
    """Read a file with the reader for its format."""
    try:
        if format == "gmsh":
            return by_gmsh(path, format)
        if format in READERS:
            with prepared(path, format) as readable:
                return READERS[format](path, readable)
        return by_meshio(path, format)
    except UnicodeDecodeError as error:
        raise BadRequest(f"cannot read {path.name}: it is no text in UTF-8 (byte {error.start})", "save it as UTF-8") from None


def load(path: Path, format: str) -> tuple:
    """Read a file with meshio: the mesh, its warnings, and the prepared text, if any. Its errors, including exits, become a BadRequest."""
    import meshio

    said = io.StringIO()

    def refuse(fact: str, hint: str = "check that the file is complete, and write it again") -> BadRequest:
        return BadRequest(f"cannot read {path.name}: {fact}", hint)

    # XDMF names binary data relative to its own folder
    with prepared(path.absolute(), format) as readable, contextlib.chdir(path.parent):
        try:
            check(path, readable, format)
            with contextlib.redirect_stderr(said):
                # Not meshio.read, which prints the error and exits
                text = TEXTS[format](path, readable) if format in TEXTS else None
                raw = meshio._helpers.reader_map[format](readable if text is None else io.StringIO(text))
        except (BadRequest, UnicodeDecodeError):
            raise
        except ModuleNotFoundError as error:
            package = str(error.name)
            raise refuse(f"the package {package} is missing", f"install it: .venv/bin/python -m pip install {package}") from None
        except (Exception, SystemExit) as error:
            if fault := fault_of_xml(readable, format):
                raise refuse(fault) from None
            said = str(error).strip()
            if said and not isinstance(error, KeyError):
                raise refuse(f"{type(error).__name__}: {said}") from None
            fact = f"the reader of {format} {f'does not know {said}' if said else 'refuses it without a reason'}"
            raise refuse(fact, "check that the file is complete, or write another format, such as MSH or VTU") from None
    warnings = [" ".join(text.split()) for text in said.getvalue().split("Warning:")[1:]]
    if unknown := [number for number in passed_over(warnings) if number not in vtu.FLAT]:
        raise refuse(f"it has cells of the type {', '.join(unknown)}, which are not read", "write it with tetrahedra or hexahedra")
    return raw, warnings, text


def passed_over(warnings: list) -> list:
    """The VTK types of cells that meshio has left out, according to its warnings."""
    return [number for text in warnings for number in re.findall(r"cells that meshio cannot handle \(type (\d+)\)", text)]


def check(path: Path, readable: Path, format: str) -> None:
    """Refuse files that a meshio reader would read only in part, never finish reading, or refuse without a reason."""
    if format == "tetgen":
        tetgen.check(readable)
    if format == "vtu":
        vtu.check(path, readable)
        vtu.teach_voxels()
    if format == "medit" and (found := sorted(set(OF_ORDER_2.findall(readable.read_bytes())))):
        fact = f"cells of second order ({', '.join(name.decode() for name in found)}) are not read from Medit"
        raise BadRequest(f"cannot read {path.name}: {fact}", "write them in another format, such as MSH or VTU, or cells of first order")


def fault_of_xml(path: Path, format: str) -> str | None:
    """The position at which an XML file is not well formed; None for other files."""
    if format in ("vtu", "xdmf", "dolfin-xml"):
        try:
            ElementTree.parse(path)
        except ElementTree.ParseError as error:
            return f"its XML is not well formed: {error}"
    return None


@contextlib.contextmanager
def prepared(path: Path, format: str):
    """The file, or an unpacked copy of it, without a byte order mark and with the extension that the reader expects."""
    with open(path, "rb") as file:
        head = file.read(4)
    ending = ".meshb" if format == "medit" and head[:4] in (b"\x01\0\0\0", b"\0\0\0\x01") else ENDINGS.get(format, path.suffix.lower())
    packed, marked = head[:2] == b"\x1f\x8b", head[:3] == b"\xef\xbb\xbf"
    if format == "medit" and ending != ".meshb":
        ending = ".mesh"
    is_named = path.suffix.lower() == ending
    if not packed and not marked and is_named and format != "vtu":
        yield path
        return
    data = path.read_bytes()
    content = (gzip.decompress(data) if packed else data).removeprefix(b"\xef\xbb\xbf")
    if format == "vtu":
        content = vtu.readable(content)
    if is_named and content == data:
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / (path.stem + ending)
        copy.write_bytes(content)
        yield copy


def by_meshio(path: Path, format: str) -> Blocks:
    """The cells and sets that meshio finds."""
    from meshio._common import num_nodes_per_cell

    raw, warnings, text = load(path, format)
    unknown = {block.type for block in raw.cells} - set(KINDS)
    if unknown:
        raise BadRequest(f"{path.name} has cells of the kind {', '.join(sorted(unknown))}", "write it with tetrahedra or hexahedra")
    points = np.asarray(raw.points, float)
    if len(points) and (points.ndim != 2 or points.shape[1] != 3):
        raise BadRequest(f"{path.name} has points of dimension {points.shape[-1]}", "a body has three")
    if np.any(raw.point_data.get("nastran:ref", 0)):
        raise BadRequest(f"{path.name} has nodes in a coordinate system of their own (CP)", "write all nodes in the basic system, CP = 0")
    cells = []
    for block in raw.cells:
        rows = np.asarray(block.data, int)
        if len(rows) and rows.shape[1] != num_nodes_per_cell[block.type]:
            # Tecplot has several kinds in one table
            fact = f"its cells are called {block.type} and have {rows.shape[-1]} nodes"
            raise BadRequest(f"cannot read {path.name}: as {format} {fact}", "write cells of one kind, or another format, such as MSH or VTU")
        cells.append((KINDS[block.type][1], rows[:, ORDERS[block.type]] if block.type in ORDERS else rows))
    names = {(int(dim), int(tag)): name for name, (tag, dim) in (raw.field_data or {}).items()}
    if format == "netgen":
        with prepared(path, format) as readable:
            names = netgen.names(path, readable)
    blocks = Blocks(points, cells, sets(raw, names), notes=[f"the reader of {format} says: {text}" for text in warnings])
    for name, members in raw.point_sets.items():
        blocks.node_sets[name] = np.asarray(members, int).ravel()
    if format in NUMBERS:
        number(blocks, *NUMBERS[format](text))
    else:
        first = tetgen.first(path) if format == "tetgen" else 0 if format in FROM_ZERO else 1
        blocks.node_numbers = np.arange(first, first + len(blocks.points))
        # VTK numbers cells of all kinds in one list, including those that are left out
        blocks.numbers = None if passed_over(warnings) else counted(blocks.cells, first, of_all=format == "vtu")
    return blocks


def number(blocks: Blocks, nodes: list, cells: list) -> None:
    """Number the nodes and cells as in the file, which states the numbers in the order of its nodes and cells."""
    ends = np.cumsum([len(rows) for _, rows in blocks.cells])
    if len(set(nodes)) == len(nodes) == len(blocks.points):
        blocks.node_numbers = np.array(nodes, int)
    if len(ends) and len(cells) == ends[-1]:
        blocks.numbers = np.split(np.array(cells, int), ends[:-1])


def sets(raw, names: dict) -> dict:
    """Masks by name: sets and groups of the file, otherwise one region for each value of integer cell data. names: (dimension, reference) -> name."""
    found = {}
    for name, members in raw.cell_sets.items():
        if name.startswith("gmsh:"):
            continue
        masks = [np.zeros(len(block.data), bool) for block in raw.cells]
        for mask, rows in zip(masks, members):
            if rows is not None and len(rows):
                mask[np.asarray(rows, int)] = True
        found[name] = masks
    for key, values in raw.cell_data.items():
        # One component may be a column
        values = [v[:, 0] if np.ndim(v) == 2 and np.shape(v)[1] == 1 else v for v in map(np.asarray, values)]
        if key in ("gmsh:geometrical", "cell_tags") or any(np.ndim(v) != 1 or not np.issubdtype(np.asarray(v).dtype, np.integer) for v in values):
            continue
        reference, of_values = key.endswith((":ref", ":physical")) or key == "netgen:index", {}
        for dim, prefix in ((3, "cells"), (2, "facets")):
            of_dim = [KINDS[block.type][0] == dim for block in raw.cells]
            there = [np.unique(v) for v, mine in zip(values, of_dim) if mine and len(v)]
            different = np.unique(np.concatenate(there)) if there else []
            if not reference and (dim == 2 or not 2 <= len(different) <= MOST_VALUES):
                continue
            for value in (int(v) for v in different if v or not reference):
                name = names.get((dim, value), f"{prefix}_{value}") if reference else f"{key}_{value}"
                masks = [np.asarray(v) == value if mine else np.zeros(len(v), bool) for v, mine in zip(values, of_dim)]
                of_values[name] = [old | new for old, new in zip(of_values[name], masks)] if name in of_values else masks
        found |= {name: masks for name, masks in of_values.items() if name not in found}
    return found


@contextlib.contextmanager
def for_gmsh(path: Path, format: str):
    """A copy of the file in a folder of its own, with an extension that makes gmsh read it as a mesh, and the content of the file.

    gmsh runs a file with any other extension as a script, which may call other programs."""
    with prepared(path, format) as readable, tempfile.TemporaryDirectory() as folder:
        data = readable.read_bytes()
        ending = next((ending for begin, ending in GMSH_ENDINGS.items() if data[:4096].lstrip().startswith(begin)), ".unv")
        copy = Path(folder) / f"mesh{ending}"
        copy.write_bytes(universal.for_gmsh(path, data) if ending == ".unv" else data)
        yield copy, data


def physical_numbers(data: bytes) -> dict:
    """The physical number of each element of a file in the format MSH 1, where gmsh keeps that of a whole part; empty for other formats."""
    if not data.lstrip().startswith(b"$NOD"):
        return {}
    rows = data.decode("latin-1").partition("$ELM")[2].partition("$ENDELM")[0].splitlines()[2:]
    return {int(number): int(group) for number, _, group, *_ in (row.split() for row in rows if row.strip())}


def by_gmsh(path: Path, format: str) -> Blocks:
    """The cells and physical groups that gmsh finds."""
    import gmsh

    from .gmsh_driver import session

    with for_gmsh(path, format) as (readable, data), session():
        try:
            gmsh.open(str(readable))
        except Exception as error:
            raise BadRequest(f"cannot read {path.name}: {error}", "check that the file is complete, and write it again") from None
        tags, points, _ = gmsh.model.mesh.getNodes()
        order = np.argsort(tags)
        tags, points = tags[order], points.reshape(-1, 3)[order]
        kinds = {int(kind) for kind in gmsh.model.mesh.getElementTypes()}
        if unknown := [gmsh.model.mesh.getElementProperties(kind)[0] for kind in sorted(kinds - set(DIMENSIONS))]:
            fact = f"{path.name} has cells of the kind {', '.join(unknown)}"
            raise BadRequest(fact, "write it with tetrahedra of order 1 or 2, or with hexahedra, wedges or pyramids of order 1")
        cells, numbers, owner = [], [], []
        for dim, entity in gmsh.model.getEntities():
            for kind, own, nodes in zip(*gmsh.model.mesh.getElements(dim, entity)):
                count = gmsh.model.mesh.getElementProperties(kind)[3]
                cells.append((int(kind), np.searchsorted(tags, nodes).reshape(-1, count)))
                numbers.append(own.astype(int))
                owner.append((dim, entity))
        found = {}
        for dim, group in gmsh.model.getPhysicalGroups():
            # MED pads names with blanks
            name = gmsh.model.getPhysicalName(dim, group).strip() or f"{DIMENSION_NAMES[dim]}_{group}"
            members = {(dim, int(e)) for e in gmsh.model.getEntitiesForPhysicalGroup(dim, group)}
            masks = [np.full(len(rows), of in members) for (_, rows), of in zip(cells, owner)]
            found[name] = [old | new for old, new in zip(found[name], masks)] if name in found else masks
        if physical := physical_numbers(data):
            of = [np.array([physical.get(number, 0) for number in own]) for own in numbers]
            wanted = dict.fromkeys((dim, group) for (dim, _), groups in zip(owner, of) for group in groups.tolist() if group > 0)
            found = {f"{DIMENSION_NAMES[dim]}_{group}": [(groups == group) & (own == dim) for (own, _), groups in zip(owner, of)] for dim, group in wanted}
        blocks = Blocks(points, cells, found, node_numbers=tags.astype(int), numbers=numbers)
    if readable.suffix == ".unv":
        universal.add_groups(path, data, blocks)
    return blocks


def counted(cells: list, first: int = 1, of_all: bool = False) -> list:
    """Numbers of the cells of each block in the order of the file: counted over all cells, or separately for each dimension."""
    dims = [0 if of_all else DIMENSIONS[kind] for kind, _ in cells]
    begin, found = dict.fromkeys(dims, first), []
    for dim, (_, rows) in zip(dims, cells):
        found.append(np.arange(begin[dim], begin[dim] + len(rows)))
        begin[dim] += len(rows)
    return found


def lines(blocks: Blocks):
    """The sections of the MSH file: one physical group per set, one entity per combination of sets."""
    names = list(dict.fromkeys([*blocks.sets, *blocks.node_sets]))
    entities = {dim: [] for dim in range(4)}  # (groups, gmsh's kind, rows, their numbers)
    count = len(blocks.points)
    labels = np.arange(1, count + 1) if blocks.node_numbers is None else blocks.node_numbers
    numbers = counted(blocks.cells) if blocks.numbers is None else blocks.numbers
    for i, (kind, rows) in enumerate(blocks.cells):
        if len(rows):
            masks = {name: masks[i] for name, masks in blocks.sets.items()}
            entities[DIMENSIONS[kind]] += combinations(kind, rows, numbers[i], masks, names)
    for name, nodes in blocks.node_sets.items():
        if len(nodes):
            entities[0].append(([names.index(name) + 1], 15, nodes.reshape(-1, 1), np.arange(1, len(nodes) + 1)))
    yield "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
    if blocks.notes:
        yield f"$MeshgenNotes\n{len(blocks.notes)}\n" + "".join(f'{i} "{" ".join(note.split())}"\n' for i, note in enumerate(blocks.notes, 1)) + "$EndMeshgenNotes\n"
    named = sorted({(dim, group) for dim, list_ in entities.items() for groups, *_ in list_ for group in groups})
    yield f"$PhysicalNames\n{len(named)}\n"
    yield "".join(f'{dim} {group} "{names[group - 1]}"\n' for dim, group in named)
    yield "$EndPhysicalNames\n"
    if blocks.node_sets:
        yield f"$MeshgenNodeSets\n{len(blocks.node_sets)}\n" + "".join(f'{i} "{name}"\n' for i, name in enumerate(blocks.node_sets, 1)) + "$EndMeshgenNodeSets\n"
    yield "$Entities\n"
    yield " ".join(str(len(entities[dim])) for dim in range(4)) + "\n"
    for dim in range(4):
        for tag, (groups, *_) in enumerate(entities[dim], 1):
            box = "0 0 0" if dim == 0 else "0 0 0 0 0 0"
            yield f"{tag} {box} {len(groups)} {' '.join(map(str, groups))} {'' if dim == 0 else 0}\n"
    yield "$EndEntities\n$Nodes\n"
    yield f"1 {count} {min(labels, default=0)} {max(labels, default=0)}\n3 1 0 {count}\n"
    yield "".join(f"{label}\n" for label in labels)
    yield "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in blocks.points.tolist())
    yield "$EndNodes\n$Elements\n"
    everything = [number for list_ in entities.values() for *_, numbers in list_ for number in (numbers.min(), numbers.max())]
    total = sum(len(rows) for list_ in entities.values() for _, _, rows, _ in list_)
    yield f"{sum(map(len, entities.values()))} {total} {min(everything)} {max(everything)}\n"
    for dim in range(4):
        for tag, (_, kind, rows, numbers) in enumerate(entities[dim], 1):
            yield f"{dim} {tag} {kind} {len(rows)}\n"
            for number, nodes in zip(numbers.tolist(), labels[rows].tolist()):
                yield f"{number} {' '.join(map(str, nodes))}\n"
    yield "$EndElements\n"


def combinations(kind: int, rows: np.ndarray, numbers: np.ndarray, masks: dict, names: list) -> list:
    """(physical groups, kind, rows, their numbers) of every combination of sets, and of the rows in none."""
    member = np.zeros((len(rows), len(names)), bool)
    for i, name in enumerate(names):
        if name in masks:
            member[:, i] = masks[name]
    found, which = np.unique(member, axis=0, return_inverse=True)
    own = [which.ravel() == i for i in range(len(found))]
    return [((np.flatnonzero(groups) + 1).tolist(), kind, rows[mine], numbers[mine]) for mine, groups in zip(own, found)]
