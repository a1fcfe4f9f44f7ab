"""The body `file` from CAD: STEP, IGES, BREP."""

from pathlib import Path

import gmsh

from .errors import BadRequest
from .geometry import MM, Geometry, boundary_faces
from .request import Request


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
    if format != "brep":
        if abs(scale - 1) > 1e-9:
            raise BadRequest(f"{path.name} states its own unit and is converted to mm", 'write unit = "mm" (--unit mm)')
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
    gmsh.option.setNumber("Geometry.OCCScaling", scale)
    try:
        gmsh.model.occ.importShapes(str(path), format=format)
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
