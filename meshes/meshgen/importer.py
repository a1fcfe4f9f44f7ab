"""The body `file` from CAD: STEP, IGES, BREP."""

from pathlib import Path

import gmsh
import numpy as np

from . import convert, surface
from .errors import BadRequest
from .geometry import MM, SNAP, Geometry, boundary_faces
from .request import Request

# Options by which gmsh joins the faces of an IGES file at their edges; the tolerance, in mm, is the rounding of such files.
SEWING = {"Geometry.OCCSewFaces": 1, "Geometry.Tolerance": 1e-3}
STICKS_OUT = 1e-6  # fraction of its volume up to which a solid inside another may stick out


def read_geometry(request: Request) -> Geometry:
    """Load a CAD file into the current gmsh model, in mm."""
    path, scale = Path(request.parameters["path"]), request.parameters["unit_m"] / MM
    if not path.is_file():
        raise BadRequest(f"no file {path}", "check parameters.path")
    return named(read_cad(path, request.parameters["format"], scale))


def named(geometry: Geometry) -> Geometry:
    """Regions `body`, `volume_1`… (if several) and `face_1`…; every face is a grading feature."""
    faces = boundary_faces(geometry.volumes)
    regions = {f"face_{i}": (2, [face]) for i, face in enumerate(faces, 1)}
    if len(geometry.volumes) > 1:
        regions |= {f"volume_{i}": (3, [volume]) for i, volume in enumerate(geometry.volumes, 1)}
    geometry.features = {name: tags for name, (dim, tags) in regions.items() if dim == 2}
    geometry.regions = regions | {"body": (3, geometry.volumes)}
    return geometry


def read_cad(path: Path, format: str, scale: float) -> Geometry:
    """Solids of a CAD file; those in contact share their faces."""
    if format != "brep" and abs(scale - 1) > 1e-9:
        raise BadRequest(f"{path.name} states its own unit and is converted to mm", 'write unit = "mm" (--unit mm)')
    # IGES is always converted to mm; its reader has no target unit.
    gmsh.option.setString("Geometry.OCCTargetUnit", "MM" if format == "step" else "")
    gmsh.option.setNumber("Geometry.OCCScaling", scale)
    occ = gmsh.model.occ
    load(path, format)
    if format == "iges" and not occ.getEntities(3):
        sew(path)
    dropped = drop_sheets()
    volumes = occ.getEntities(3)
    if not volumes:
        hint = "export STEP, which holds solids" if format == "iges" else "export a solid"
        raise BadRequest(f"{path.name} holds no solid, only faces or curves", hint)
    if len(volumes) > 1:
        check_apart(path, volumes, occ.fragment(volumes, [])[1])
    occ.synchronize()
    return Geometry([tag for _, tag in gmsh.model.getEntities(3)], {}, dropped=dropped)


def load(path: Path, format: str) -> None:
    """Import a file into the current gmsh model, the solids first."""
    try:
        with convert.prepared(path, format) as readable:
            gmsh.model.occ.importShapes(str(readable), highestDimOnly=False, format=format)
    except Exception as error:
        raise BadRequest(f"cannot read {path.name}: {error}", "check that the file is complete") from None


def sew(path: Path) -> None:
    """Import an IGES file again, as solids: most files contain only the faces of a body."""
    gmsh.clear()
    before = {name: gmsh.option.getNumber(name) for name in SEWING}
    for name, value in SEWING.items():
        gmsh.option.setNumber(name, value)
    load(path, "iges")
    for name, value in before.items():
        gmsh.option.setNumber(name, value)
    check_faces(path)
    make_solids()


def make_solids() -> None:
    """Solids of the closed shells: a shell inside an odd number of others is the wall of a cavity of the smallest of them."""
    occ = gmsh.model.occ
    occ.synchronize()
    closed = [shell for shell in shells() if not gmsh.model.getBoundary([(2, face) for face in shell], combined=True, oriented=False)]
    loops = [occ.addSurfaceLoop(shell) for shell in closed]
    filled = [occ.addVolume([loop]) for loop in loops]
    size = [abs(occ.getMass(3, tag)) for tag in filled]
    around = [[b for b in range(len(filled)) if size[a] < size[b] and lies_in(filled[a], filled[b])] for a in range(len(filled))]
    occ.remove([(3, tag) for tag in filled])
    walls = {outer: [loops[outer]] for outer in range(len(filled)) if len(around[outer]) % 2 == 0}
    for inner in range(len(filled)):
        if inner not in walls:
            walls[min(around[inner], key=lambda b: size[b])].append(loops[inner])
    for solid in walls.values():
        occ.addVolume(solid)
    # A shell of a single face contains a copy of the face
    occ.synchronize()
    occ.remove(free([(2, face) for shell in closed for face in shell]))


def shells() -> list:
    """The faces of the model, grouped into shells that are connected by edges."""
    faces = [tag for _, tag in gmsh.model.getEntities(2)]
    owners = {}
    for i, face in enumerate(faces):
        for edge in gmsh.model.getAdjacencies(2, face)[1].tolist():
            owners.setdefault(edge, []).append(i)
    pairs = np.array([(of[0], other) for of in owners.values() for other in of], int).reshape(-1, 2)
    shell = surface.components(len(faces), pairs)
    return [[faces[i] for i in np.flatnonzero(shell == number)] for number in np.unique(shell)]


def free(entities: list) -> list:
    """The entities that bound nothing."""
    return [entity for entity in entities if not len(gmsh.model.getAdjacencies(*entity)[0])]


def lies_in(inner: int, outer: int) -> bool:
    """Whether a solid lies within another."""
    occ = gmsh.model.occ
    a, b = occ.getBoundingBox(3, inner), occ.getBoundingBox(3, outer)
    if any(a[i] < b[i] - SNAP or a[i + 3] > b[i + 3] + SNAP for i in range(3)):
        return False
    copies = [occ.copy([(3, tag)]) for tag in (inner, outer)]
    common = occ.intersect(*copies)[0]
    shared = sum(abs(occ.getMass(*piece)) for piece in common if piece[0] == 3)
    occ.remove(common, recursive=True)
    return shared > (1 - STICKS_OUT) * abs(occ.getMass(3, inner))


def drop_sheets() -> list:
    """Remove faces, edges and points that belong to no solid; returns a note about the faces."""
    occ = gmsh.model.occ
    told = []
    occ.synchronize()
    for dim in (2, 1, 0) if occ.getEntities(3) else ():
        left = free(occ.getEntities(dim))
        if left and dim == 2:
            what = "a face bounds no solid and is" if len(left) == 1 else f"{len(left)} faces bound no solid and are"
            told = [f"{what} left out, one from {box_text(occ.getBoundingBox(*left[0]))}; only solids are meshed"]
        occ.remove(left)
        occ.synchronize()
    return told


def check_faces(path: Path) -> None:
    """Refuse sewn faces of the same extent and area, at which two bodies are in contact: no solid has both faces."""
    occ = gmsh.model.occ
    seen = set()
    for face in occ.getEntities(2):
        box = occ.getBoundingBox(*face)
        place = tuple(round(x, 3) for x in (*box, occ.getMass(*face)))
        if place in seen:
            raise BadRequest(f"{path.name} has two faces at one place, {box_text(box)}, as bodies that touch have", "export STEP, which holds solids")
        seen.add(place)


def check_apart(path: Path, volumes: list, pieces: list) -> None:
    """Refuse solids that overlap, however little: the shared piece would be a solid of its own.

    pieces: the pieces of each solid after all were cut at each other."""
    occ = gmsh.model.occ
    owners = {}
    for i, list_ in enumerate(pieces, 1):
        for piece in list_:
            owners.setdefault(piece, []).append(i)
    shared = {piece: of for piece, of in owners.items() if piece[0] == 3 and len(of) > 1}
    if not shared:
        return
    masses = {piece: abs(occ.getMass(*piece)) for piece in shared}
    largest = max(masses, key=masses.get)
    names = " and ".join(map(str, shared[largest]))
    more = f", and {len(shared) - 1} more such places" if len(shared) > 1 else ""
    fact = f"solids {names} of {len(volumes)} share {masses[largest]:.4g} mm³ within {box_text(occ.getBoundingBox(*largest))}{more}"
    raise BadRequest(f"{path.name} has solids that overlap: {fact}", "subtract one from the other in CAD, so that they only touch")


def box_text(box: tuple) -> str:
    """The corners of a box as text."""
    low, high = ("(" + ", ".join(f"{round(x, 6) + 0.0:.6g}" for x in corner) + ")" for corner in (box[:3], box[3:]))
    return f"{low} to {high} mm"
