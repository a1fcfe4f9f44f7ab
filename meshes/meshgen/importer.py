"""The body `file`: CAD (STEP, IGES, BREP), closed surfaces (STL, OBJ, …), volume meshes that meshio reads."""

from pathlib import Path

import gmsh
import numpy as np

from .errors import BadRequest, MesherFailed
from .geometry import MM, Geometry, boundary_faces
from .mesh import assemble, boundary
from .request import Request

CAD = (".step", ".stp", ".iges", ".igs", ".brep")
FLAT_CELLS = {"vertex", "line", "line3", "triangle", "triangle6"}


def is_mesh(request: Request) -> bool:
    """Whether the file holds a volume mesh, which is used unchanged."""
    path = Path(request.parameters["path"])
    if not path.is_file():
        raise BadRequest(f"no file {path}", "check parameters.path")
    if path.suffix.lower() in CAD or request.is_surface():
        return False
    if request.length or request.cells or request.generator != "gmsh" or request.levels or request.grading or request.size_field:
        raise BadRequest(f"{path.name} is a volume mesh: it is taken over, not meshed again", "drop size, grading and generator")
    return True


def read_geometry(request: Request) -> Geometry:
    """Load a CAD file into the current gmsh model, in mm."""
    if not (request.length or request.cells or request.cgal):
        raise BadRequest("no size", "give size.length or size.cells")
    path, scale = Path(request.parameters["path"]), request.parameters["unit_m"] / MM
    return named(read_cad(path, scale))


def named(geometry: Geometry) -> Geometry:
    """Regions `body`, `volume_1`… (if several) and `face_1`…; every face is a grading feature."""
    faces = boundary_faces(geometry.volumes)
    regions = {f"face_{i}": (2, [face]) for i, face in enumerate(faces, 1)}
    if len(geometry.volumes) > 1:
        regions |= {f"volume_{i}": (3, [volume]) for i, volume in enumerate(geometry.volumes, 1)}
    geometry.features = {name: tags for name, (dim, tags) in regions.items() if dim == 2}
    geometry.regions = regions | {"body": (3, geometry.volumes)}
    return geometry


def read_cad(path: Path, scale: float) -> Geometry:
    """Solids of a CAD file; those in contact share their faces."""
    if path.suffix.lower() != ".brep":
        if abs(scale - 1) > 1e-9:
            raise BadRequest(f"{path.name} states its own unit and is converted to mm", "give unit_m = 0.001")
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
    gmsh.option.setNumber("Geometry.OCCScaling", scale)
    try:
        gmsh.model.occ.importShapes(str(path))
    except Exception as error:
        raise BadRequest(f"cannot read {path.name}: {error}", "check that the file is complete") from None
    occ = gmsh.model.occ
    volumes = occ.getEntities(3)
    if not volumes:
        raise BadRequest(f"{path.name} holds no solid, only faces or curves", "export a solid")
    if len(volumes) > 1:
        occ.fragment(volumes, [])
    occ.synchronize()
    return Geometry([tag for _, tag in gmsh.model.getEntities(3)], {})


def load(path: Path):
    """Read the file with meshio; its errors, including exits, become a BadRequest."""
    import meshio

    try:
        return meshio.read(path)
    except (Exception, SystemExit) as error:
        known = "" if path.suffix.lower() in meshio.extension_to_filetypes else " (unknown extension)"
        raise BadRequest(f"cannot read {path.name}{known}: {error!r}", "check that the file is complete and of a known format") from None


def read_mesh(request: Request) -> tuple:
    """A volume mesh: tetrahedra and labels of the file. Returns the mesh and notes for the manifest."""
    path = Path(request.parameters["path"])
    raw = load(path)
    count = {block.type: 0 for block in raw.cells}
    for block in raw.cells:
        count[block.type] += len(block.data)
    kinds = {kind for kind in count if kind not in FLAT_CELLS}
    if len(kinds) != 1 or not kinds <= {"tetra", "tetra10"}:
        listed = ", ".join(f"{count[kind]} {kind}" for kind in sorted(kinds)) or "no volume cells"
        raise BadRequest(f"{path.name} must hold tetrahedra of one kind; it has {listed}", "convert the cells to tetrahedra")
    (kind,) = kinds
    order = 1 if kind == "tetra" else 2
    if request.order != order:
        raise BadRequest(f"{path.name} holds cells of order {order}, the request wants {request.order}", f"use order {order}")
    cells = np.concatenate([block.data for block in raw.cells if block.type == kind])
    if cells.max() >= len(raw.points):
        raise BadRequest(f"{path.name} refers to node {cells.max()} of {len(raw.points)}", "the file is damaged")
    if order == 2:
        cells = cells[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]]
    points = np.asarray(raw.points, float) * request.parameters["unit_m"]
    check_distinct(points, cells, path)
    volumes, facets = labels(raw, kind), labels(raw, "triangle" if order == 1 else "triangle6")
    triangles = [block.data[:, :3] for block in raw.cells if block.type == ("triangle" if order == 1 else "triangle6")]
    triangles = np.concatenate(triangles) if triangles else np.zeros((0, 3), int)
    outer = {tuple(face) for face in np.sort(boundary(cells)[:, :3], axis=1).tolist()}
    on_boundary = np.array([tuple(face) in outer for face in np.sort(triangles, axis=1).tolist()], bool)
    facet_labels = {name: triangles[mask & on_boundary] for name, mask in facets.items() if np.any(mask & on_boundary)}
    named_faces = {tuple(face) for rows in facet_labels.values() for face in np.sort(rows, axis=1).tolist()}
    rest = np.array(sorted(outer - named_faces), int).reshape(-1, 3)
    if len(rest):
        facet_labels["boundary"] = rest
    try:
        mesh = assemble(points, cells, volumes | {"body": np.ones(len(cells), bool)}, facet_labels, exclusive=False)
    except MesherFailed as error:
        raise BadRequest(f"{path.name}: {error.error}", "repair the file") from None
    return mesh, {"unused_nodes": len(points) - len(mesh.points), "inner_triangles": int(np.sum(~on_boundary))}


def check_distinct(points: np.ndarray, cells: np.ndarray, path: Path) -> None:
    """Refuse used nodes that are not finite or coincide: the mesh would have hidden cracks."""
    used = np.unique(cells)
    if not np.isfinite(points[used]).all():
        raise BadRequest(f"{path.name} has nodes that are not finite", "the file is damaged")
    step = np.ptp(points[used], axis=0).max() * 1e-9
    _, first, counts = np.unique(np.round(points[used] / step), axis=0, return_index=True, return_counts=True)
    if np.any(counts > 1):
        where = points[used[first[counts > 1][0]]].tolist()
        raise BadRequest(f"{path.name} has {np.sum(counts > 1)} places with doubled nodes, one at {where} m", "merge the nodes")


def labels(raw, kind: str) -> dict:
    """Masks over all cells of one kind: physical names and sets, else one region per value of integer cell data."""
    blocks = [i for i, block in enumerate(raw.cells) if block.type == kind]
    total = sum(len(raw.cells[i].data) for i in blocks)
    starts = np.cumsum([0] + [len(raw.cells[i].data) for i in blocks])
    found = {}
    for name, members in raw.cell_sets.items():
        mask = np.zeros(total, bool)
        for start, i in zip(starts, blocks):
            if members[i] is not None:
                mask[start + np.asarray(members[i], int)] = True
        if mask.any() and not name.startswith("gmsh:"):
            found[name] = mask
    dim = 3 if kind.startswith("tetra") else 2
    names = {int(tag): name for name, (tag, of) in raw.field_data.items() if of == dim} if raw.field_data else {}
    prefix = "cells" if dim == 3 else "facets"
    for key in ("gmsh:physical", "medit:ref"):
        if key in raw.cell_data and blocks:
            values = np.concatenate([raw.cell_data[key][i] for i in blocks]).astype(int)
            for value in np.unique(values).tolist():
                if value:
                    found.setdefault(names.get(value, f"{prefix}_{value}"), values == value)
    return found
