"""The body `file`: CAD (STEP, IGES, BREP) and closed surfaces (STL, OBJ, …), whose volume is meshed."""

import math
from pathlib import Path

import gmsh
import numpy as np

from . import surface
from .convert import KINDS, load
from .errors import BadRequest
from .geometry import MM, Geometry, boundary_faces
from .request import Request

CREASE = math.radians(40)  # a surface is cut into faces where it bends by more
FLAT_CELLS = {"vertex", "line", "line3", "triangle", "triangle6"}


def read_geometry(request: Request) -> Geometry:
    """Load a CAD or surface file into the current gmsh model, in mm."""
    path, scale = Path(request.parameters["path"]), request.parameters["unit_m"] / MM
    if not path.is_file():
        raise BadRequest(f"no file {path}", "check parameters.path")
    if request.parameters["kind"] == "cad":
        return named(read_cad(path, request.parameters["format"], scale))
    if request.order == 2:
        raise BadRequest(f"{path.name} has no CAD behind it to curve the cells on", "use order 1, or a STEP file")
    return named(read_surface(path, request.parameters["format"], scale))


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
            raise BadRequest(f"{path.name} states its own unit and is converted to mm", "give unit_m = 0.001")
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


def read_surface(path: Path, format: str, scale: float) -> Geometry:
    """The volume inside a closed triangle surface, cut into faces along its creases."""
    raw = load(path, format)
    kinds = {block.type for block in raw.cells}
    solids = {kind for kind in kinds if KINDS.get(kind, (2,))[0] == 3}
    if solids:
        raise BadRequest(f"{path.name} is a volume mesh: it is taken over, not meshed again", "drop size, grading and generator")
    if "triangle" not in kinds or kinds - FLAT_CELLS:
        raise BadRequest(f"{path.name} must be made of triangles; it has {', '.join(sorted(kinds)) or 'nothing'}", "triangulate it")
    triangles = np.concatenate([block.data for block in raw.cells if block.type == "triangle"])
    points, triangles = surface.merged(np.asarray(raw.points, float) * scale, triangles)
    triangles = surface.oriented(points, triangles)

    def rebuild() -> int:
        gmsh.clear()
        part = gmsh.model.addDiscreteEntity(2)
        gmsh.model.mesh.addNodes(2, part, range(1, len(points) + 1), points.ravel())
        gmsh.model.mesh.addElementsByType(part, 2, [], triangles.ravel() + 1)
        gmsh.model.mesh.classifySurfaces(CREASE, True, True, math.pi)
        gmsh.model.mesh.createGeometry()
        loop = gmsh.model.geo.addSurfaceLoop([tag for _, tag in gmsh.model.getEntities(2)])
        volume = gmsh.model.geo.addVolume([loop])
        gmsh.model.geo.synchronize()
        return volume

    return Geometry([rebuild()], {}, volume=surface.volume(points, triangles), rebuild=rebuild)
