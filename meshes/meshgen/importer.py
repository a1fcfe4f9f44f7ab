"""The body `file` from CAD: STEP, IGES, BREP."""

from pathlib import Path

import gmsh

from .errors import BadRequest
from .geometry import MM, Geometry, boundary_faces
from .request import Request

# Options by which gmsh joins the faces of an IGES file into solids; the tolerance, in mm, is what such files round to.
SEWING = {"Geometry.OCCSewFaces": 1, "Geometry.OCCMakeSolids": 1, "Geometry.Tolerance": 1e-3}
MOST_OVERLAP = 1e-6  # share of the volume, below which solids touch


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
    # IGES is always converted to mm, and its reader knows no target.
    gmsh.option.setString("Geometry.OCCTargetUnit", "MM" if format == "step" else "")
    gmsh.option.setNumber("Geometry.OCCScaling", scale)
    occ = gmsh.model.occ
    load(path, format)
    if format == "iges" and not occ.getEntities(3):
        sew(path)
    volumes = occ.getEntities(3)
    if not volumes:
        hint = "export STEP, which holds solids" if format == "iges" else "export a solid"
        raise BadRequest(f"{path.name} holds no solid, only faces or curves", hint)
    if len(volumes) > 1:
        check_apart(path, volumes, occ.fragment(volumes, [])[1])
    occ.synchronize()
    return Geometry([tag for _, tag in gmsh.model.getEntities(3)], {})


def load(path: Path, format: str) -> None:
    """Import a file into the current gmsh model."""
    try:
        gmsh.model.occ.importShapes(str(path), format=format)
    except Exception as error:
        raise BadRequest(f"cannot read {path.name}: {error}", "check that the file is complete") from None


def sew(path: Path) -> None:
    """Import an IGES file again, as solids: most hold only the faces of a body."""
    gmsh.clear()
    before = {name: gmsh.option.getNumber(name) for name in SEWING}
    for name, value in SEWING.items():
        gmsh.option.setNumber(name, value)
    load(path, "iges")
    for name, value in before.items():
        gmsh.option.setNumber(name, value)
    check_faces(path)


def check_faces(path: Path) -> None:
    """Refuse sewn faces of the same extent and area, which are those in which two bodies touch: no solid holds both."""
    occ = gmsh.model.occ
    seen = set()
    for face in occ.getEntities(2):
        box = occ.getBoundingBox(*face)
        place = tuple(round(x, 3) for x in (*box, occ.getMass(*face)))
        if place in seen:
            raise BadRequest(f"{path.name} has two faces at one place, {box_text(box)}, as bodies that touch have", "export STEP, which holds solids")
        seen.add(place)


def check_apart(path: Path, volumes: list, pieces: list) -> None:
    """Refuse solids that overlap; pieces: what each became when all were cut at each other."""
    occ = gmsh.model.occ
    owners = {}
    for i, list_ in enumerate(pieces, 1):
        for piece in list_:
            owners.setdefault(piece, []).append(i)
    shared = {piece: of for piece, of in owners.items() if piece[0] == 3 and len(of) > 1}
    masses = {piece: occ.getMass(*piece) for piece in shared}
    if sum(masses.values()) <= MOST_OVERLAP * sum(occ.getMass(*piece) for piece in owners if piece[0] == 3):
        return
    largest = max(masses, key=masses.get)
    names = " and ".join(map(str, shared[largest]))
    more = f", and {len(shared) - 1} more such places" if len(shared) > 1 else ""
    fact = f"solids {names} of {len(volumes)} share {masses[largest]:.4g} mm³ within {box_text(occ.getBoundingBox(*largest))}{more}"
    raise BadRequest(f"{path.name} has solids that overlap: {fact}", "subtract one from the other in CAD, so that they only touch")


def box_text(box: tuple) -> str:
    """The corners of a box in words."""
    low, high = ("(" + ", ".join(f"{round(x, 6) + 0.0:.6g}" for x in corner) + ")" for corner in (box[:3], box[3:]))
    return f"{low} to {high} mm"
