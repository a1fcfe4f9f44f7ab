"""MSH 4.1 ASCII, gzipped when the name ends in .gz; the same mesh always gives the same bytes."""

import gzip
import os
from pathlib import Path

import numpy as np

from .mesh import TetMesh

ELEMENT = {(2, 1): 2, (2, 2): 9, (3, 1): 4, (3, 2): 11}  # (dim, order) -> gmsh's element type


def write(mesh: TetMesh, path: str) -> None:
    """Write the mesh: one physical group per region, one entity per combination of regions."""
    save("".join(lines(mesh)).encode(), path)


def save(data: bytes, path: str) -> None:
    """Write a file, gzipped if its name says so; it appears whole or not at all."""
    if path.endswith(".gz"):
        data = gzip.compress(data, compresslevel=9, mtime=0)
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    temporary = target.with_name(target.name + ".part")
    temporary.write_bytes(data)
    os.replace(temporary, target)


def lines(mesh: TetMesh):
    """The file's sections."""
    names = list(mesh.regions)
    entities = {3: blocks(mesh, 3, len(mesh.cells), names), 2: blocks(mesh, 2, len(mesh.facets), names)}
    yield "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
    yield f"$PhysicalNames\n{len(names)}\n"
    for dim in (2, 3):
        for tag, name in enumerate(names, 1):
            if mesh.regions[name][0] == dim:
                yield f'{dim} {tag} "{name}"\n'
    yield "$EndPhysicalNames\n$Entities\n"
    yield f"0 0 {len(entities[2])} {len(entities[3])}\n"
    for dim in (2, 3):
        connectivity = mesh.facets if dim == 2 else mesh.cells
        for tag, (groups, rows) in enumerate(entities[dim], 1):
            x = mesh.points[np.unique(connectivity[rows])]
            box = " ".join(map(repr, np.concatenate([x.min(axis=0), x.max(axis=0)]).tolist()))
            yield f"{tag} {box} {len(groups)} {' '.join(map(str, groups))} 0\n"
    yield "$EndEntities\n$Nodes\n"
    count = len(mesh.points)
    yield f"1 {count} 1 {count}\n3 1 0 {count}\n"
    yield "".join(f"{i}\n" for i in range(1, count + 1))
    yield "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in mesh.points.tolist())
    yield "$EndNodes\n$Elements\n"
    total = sum(len(rows) for dim in (2, 3) for _, rows in entities[dim])
    yield f"{len(entities[2]) + len(entities[3])} {total} 1 {total}\n"
    number = 0
    for dim in (2, 3):
        connectivity = (mesh.facets if dim == 2 else mesh.cells) + 1
        for tag, (_, rows) in enumerate(entities[dim], 1):
            yield f"{dim} {tag} {ELEMENT[dim, mesh.order]} {len(rows)}\n"
            for nodes in connectivity[rows].tolist():
                number += 1
                yield f"{number} {' '.join(map(str, nodes))}\n"
    yield "$EndElements\n"


def blocks(mesh: TetMesh, dim: int, count: int, names: list) -> list:
    """(physical tags, element rows) of every combination of regions; elements in no region are left out."""
    member = np.zeros((count, len(names)), bool)
    for i, name in enumerate(names):
        if mesh.regions[name][0] == dim:
            member[mesh.regions[name][1], i] = True
    combinations, which = np.unique(member, axis=0, return_inverse=True)
    return [
        ((np.flatnonzero(groups) + 1).tolist(), np.flatnonzero(which.ravel() == i))
        for i, groups in enumerate(combinations)
        if groups.any()
    ]
