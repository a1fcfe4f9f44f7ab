"""Meshes of closed surfaces: by gmsh along one of several routes, or by CGAL. Lengths in mm between reading and the mesh."""

import math
from pathlib import Path

import gmsh
import numpy as np

from . import gmsh_driver, recover, repair, surface, surface_file
from .errors import BadRequest, MesherFailed, SizeNotReached
from .geometry import MM, Geometry, boundary_faces
from .mesh import check_volume, straight_second_order
from .request import Request
from .surface import Surface

CREASES = (40, 20, 60)  # degrees; a surface is cut into faces where it bends by more; the others are tried if gmsh fails


def mesh(request: Request) -> tuple:
    """Mesh the inside of a surface file: (mesh, its volume [m³], paths, notes)."""
    path, scale = Path(request.parameters["path"]), request.parameters["unit_m"] / MM
    if not (request.length or request.cells or request.cgal):
        raise BadRequest("no size", "give size.length or size.cells")
    found = repair.closed(path.name, *surface_file.read(path, request.parameters["format"]), may_cross=request.generator == "cgal")
    for line in found.repairs:
        gmsh_driver.log(f"repaired: {line}")
    if len(found.solids) > 1 or len(found.solids[0]) > 1:
        hollows = sum(map(len, found.solids)) - len(found.solids)
        gmsh_driver.log(f"{repair.counted(len(found.solids), 'solid')} with {repair.counted(hollows, 'hollow')}")
    body = found.scaled(scale)
    if request.generator == "cgal":
        made, notes = by_cgal(request, body)
    else:
        made, notes = by_gmsh(request, path.name, body)
    if request.order == 2:
        made = straight_second_order(made)
    hollow = {name: hollow * MM**3 for name, hollow in body.cavities().items()}
    return made, body.volume() * MM**3, {}, notes | {"repairs": found.repairs} | ({"volumes_cad_m3": hollow} if hollow else {})


def by_cgal(request: Request, body: Surface) -> tuple:
    """CGAL's mesh of the surface itself, without gmsh."""
    from . import cgal_driver

    return cgal_driver.mesh_surface(request, body, surface.patches(body.points, body.triangles, math.radians(CREASES[0])))


def by_gmsh(request: Request, name: str, body: Surface) -> tuple:
    """gmsh's mesh by the first route whose mesh has the volume of the surface."""
    linear = request.linear()
    routes = [(f"faces cut at {angle} degrees", lambda angle=angle: parametrised(body, math.radians(angle))) for angle in CREASES]
    if not (request.grading or request.size_field or request.seed):
        routes.append(("triangles made anew by CGAL", lambda: remeshed(body)))
    failures = []
    for route, build in routes:
        try:
            with gmsh_driver.session(request.seed):
                geometry = build()
                made, notes = gmsh_driver.mesh(linear, geometry, body.volume() * MM**3)
            check_volume(made, body.volume() * MM**3)
            return made, notes | {"route": route}
        except SizeNotReached:
            raise
        except MesherFailed as error:
            failures.append(f"{route}: {error.error.removeprefix('gmsh: ').removeprefix('Error: ')}")
            gmsh_driver.log(f"no mesh by {failures[-1]}")
    raise MesherFailed(
        f"gmsh makes no mesh of {name}, whose surface is closed and does not cross itself ({'; '.join(failures)})",
        'try generator = "cgal", or a smaller size',
    )


def parametrised(body: Surface, crease: float) -> Geometry:
    """The volume inside the surface, cut into faces along its creases, which gmsh maps to the plane and remeshes."""

    def rebuild(_length: float | None = None) -> tuple:
        gmsh.clear()
        start_surface(body.points, body.triangles, body.shell)
        gmsh.model.mesh.classifySurfaces(crease, True, True, math.pi)
        owner = {}
        shell_of = np.zeros(len(body.points) + 1, int)
        shell_of[body.triangles + 1] = body.shell[:, None]
        for _, tag in gmsh.model.getEntities(2):
            owner[tag] = int(shell_of[int(gmsh.model.mesh.getElements(2, tag)[2][0][0])])
        gmsh.model.mesh.createGeometry()
        return fill(body, owner), owner

    return named(body, *rebuild(), rebuild)


def remeshed(body: Surface) -> Geometry:
    """The volume inside the surface, with triangles of the requested edge length from CGAL, which gmsh leaves unchanged."""
    from . import cgal_driver

    cgal_driver.load()
    patch = surface.patches(body.points, body.triangles, math.radians(CREASES[0]))
    shells = np.zeros(patch.max() + 1, int)
    shells[patch] = body.shell

    def rebuild(length: float | None = None) -> tuple:
        gmsh.clear()
        points, triangles, face = body.points, body.triangles, patch
        if length:
            points, triangles = cgal_driver.remesh(body, patch, length)
            skin = recover.Skin(*recover.fine(body.points, body.triangles, patch, length))
            face = recover.nearest_faces(points, triangles, skin)
        start_surface(points, triangles, face)
        owner = {number + 1: int(shells[number]) for number in range(len(shells)) if np.any(face == number)}
        return fill(body, owner), owner

    return named(body, *rebuild(), rebuild)


def start_surface(points: np.ndarray, triangles: np.ndarray, part: np.ndarray) -> None:
    """Put triangles into the gmsh model, as a discrete face `part + 1` for each part."""
    for number in np.unique(part).tolist():
        gmsh.model.addDiscreteEntity(2, number + 1)
    gmsh.model.mesh.addNodes(2, int(part[0]) + 1, range(1, len(points) + 1), points.ravel())
    for number in np.unique(part).tolist():
        gmsh.model.mesh.addElementsByType(number + 1, 2, [], triangles[part == number].ravel() + 1)


def fill(body: Surface, owner: dict) -> list:
    """Volumes of the solids within the faces of the model; owner: shell of each face. Returns their tags."""
    loops = {shell: gmsh.model.geo.addSurfaceLoop([f for f, s in owner.items() if s == shell]) for solid in body.solids for shell in solid}
    volumes = [gmsh.model.geo.addVolume([loops[shell] for shell in solid]) for solid in body.solids]
    gmsh.model.geo.synchronize()
    return volumes


def named(body: Surface, volumes: list, owner: dict, rebuild) -> Geometry:
    """The geometry with regions for its faces, its shells and, if there are several, its bodies."""
    faces = boundary_faces(volumes)
    regions = {f"face_{i}": (2, [face]) for i, face in enumerate(faces, 1)}
    regions |= volume_regions(volumes)
    unions = {name: [f"face_{i}" for i, face in enumerate(faces, 1) if owner[face] in shells] for name, shells in body.regions().items()}
    features = {name: tags for name, (dim, tags) in regions.items() if dim == 2}
    features |= {name: [tag for face in members for tag in features[face]] for name, members in unions.items()}
    return Geometry(volumes, regions, features=features, volume=body.volume(), rebuild=rebuild, unions=unions)


def volume_regions(volumes: list) -> dict:
    """`body`, and `volume_1`… if there are several."""
    several = {f"volume_{i}": (3, [volume]) for i, volume in enumerate(volumes, 1)} if len(volumes) > 1 else {}
    return several | {"body": (3, volumes)}
