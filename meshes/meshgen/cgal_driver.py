"""CGAL's Mesh_3 on a polyhedral domain: Delaunay refinement of the volume inside a triangle surface.

Sharp edges and labels are not passed to it: edges are rounded, and regions are recovered afterwards. Surface files are passed
unchanged; CAD is triangulated by gmsh first."""

import os
import random
import tempfile
from pathlib import Path

import numpy as np

from . import recover, sizing, surface
from .errors import BadRequest, MesherFailed
from .geometry import MM, Geometry
from .gmsh_driver import add_unions, log
from .mesh import assemble, boundary, check_volume
from .request import CGAL_LENGTHS, Request
from .surface import Surface

# Default criteria; lengths as fractions of the edge length.
DEFAULTS = {"facet_angle": 25.0, "cell_ratio": 3.0, "facet_size": 1.0, "facet_approximation": 0.1, "cell_size": 1.0}
OPTIMISERS = {"odt": False, "lloyd": False, "perturb": True, "exude": True}
SPACING = 3  # of the first points on a surface, in edge lengths
REMESHINGS = 5  # rounds of splitting, collapsing, flipping and smoothing
COARSE = "use more cells or a smaller size"
CONVERGENCE, FREEZE = 0.02, 0.01  # of odt and lloyd, CGAL's defaults


def mesh(request: Request, geometry: Geometry, volume: float) -> tuple:
    """Mesh the volume of the current gmsh model with CGAL. Returns the mesh and notes for the manifest.

    volume: volume of the CAD [m³], for the first guess of the length."""
    guess = request.length or (volume * sizing.CELLS_PER_CUBE / (request.cells or 5000)) ** (1 / 3)
    criteria = criteria_for(request, guess)
    size = min(criteria["facet_size"], criteria["cell_size"]) / MM / 2
    if request.seed:  # CGAL draws its first points from the triangles of the surface: a different triangulation gives a different sample
        size *= random.Random(request.seed).uniform(0.6, 1.0)
    body, skin = recover.skin(geometry, size)
    points, cells, notes = sized(request, body, volume)
    facets = boundary(cells)
    shells = np.zeros(skin.face.max() + 1, int)
    shells[skin.face] = body.shell
    face, _ = placed(points, facets, skin, shells, body)
    labels = {name: facets[np.isin(face, faces)] for name, (dim, faces) in geometry.regions.items() if dim == 2}
    cell_labels = recover.cell_regions(points[cells].mean(axis=1), skin, geometry)
    empty = [name for name, cells_of in cell_labels.items() if not np.any(cells_of)]
    if empty:
        raise MesherFailed(f"no cell of CGAL's mesh has its centre in {', '.join(empty)}", COARSE)
    faceless = [name for name, rows in labels.items() if not len(rows)]
    geometry.dropped += [f"{', '.join(faceless)} of the CAD: no facet of CGAL's mesh is nearest to them, and there are no such regions"] if faceless else []
    labels = {name: rows for name, rows in labels.items() if len(rows)}
    result = assemble(points * MM, cells, cell_labels, labels)
    check_volume(result, volume)
    return result, notes | {"edge_error_m": recover.edge_error(points, facets, skin) * MM}


def mesh_surface(request: Request, body: Surface, patch: np.ndarray) -> tuple:
    """Mesh the inside of a surface [mm] with CGAL, which rounds its creases. Returns the mesh and notes.

    patch: number of the face of every triangle, within one shell each."""
    points, cells, notes = sized(request, body, body.volume() * MM**3)
    facets = boundary(cells)
    length = float(np.median(np.linalg.norm(points[facets[:, 0]] - points[facets[:, 1]], axis=1)))
    skin = recover.Skin(*recover.fine(body.points, body.triangles, patch, length))
    shells = np.zeros(patch.max() + 1, int)
    shells[patch] = body.shell
    face, shell = placed(points, facets, skin, shells, body)
    labels = {f"face_{i + 1}": facets[face == i] for i in range(len(shells)) if np.any(face == i)}
    unions = {
        name: [f"face_{i + 1}" for i in range(len(shells)) if shells[i] in members and np.any(face == i)]
        for name, members in body.regions().items()
    }
    result = assemble(points * MM, cells, solid_labels(cells, facets, shell, body), labels)
    check_volume(result, body.volume() * MM**3)
    add_unions(result, unions)
    middles = recover.sharp_middles(body.points, body.triangles)
    return result, notes | {"edge_error_m": recover.farthest(points, facets, middles) * MM}


def placed(points: np.ndarray, facets: np.ndarray, skin: recover.Skin, shells: np.ndarray, body: Surface) -> tuple:
    """Face and shell of every facet; shells: shell of each face of the skin."""
    face = recover.nearest_faces(points, facets, skin)
    shell = facet_shells(facets, shells[face], body)
    for own in np.unique(shell):  # in walls thinner than a facet, a facet on one side may be nearer to the other side
        lost = (shell == own) & (shells[face] != own)
        if lost.any():
            part = shells[skin.face] == own
            face[lost] = recover.nearest_faces(points, facets[lost], recover.Skin(skin.points, skin.triangles[part], skin.face[part]))
    return face, shell


def facet_shells(facets: np.ndarray, nearest: np.ndarray, body: Surface) -> np.ndarray:
    """Shell of every facet: the one nearest to most facets of its connected part. Refuses a mesh that lacks a shell."""
    part = connected(facets)
    shell = np.empty(len(facets), int)
    for own in range(part.max() + 1):
        rows = part == own
        shell[rows] = np.bincount(nearest[rows]).argmax()
    lost = sorted(set(range(body.shell.max() + 1)) - set(shell.tolist()))
    if lost:
        row = int(np.argmax(body.shell == lost[0]))
        where = (body.points[body.triangles[row]].mean(axis=0) * MM).tolist()
        fact = f"the cells are too coarse for the walls: in CGAL's mesh {len(lost)} of {body.shell.max() + 1} shells"
        raise MesherFailed(f"{fact} are no closed surface of their own, one at {where} m", COARSE)
    return shell


def solid_labels(cells: np.ndarray, facets: np.ndarray, shell: np.ndarray, body: Surface) -> dict:
    """Masks of the cells of `body` and, if there are several solids, of `volume_1`…"""
    labels = {"body": np.ones(len(cells), bool)}
    if len(body.solids) == 1:
        return labels
    part = surface.components(cells.max() + 1, np.concatenate([cells[:, [0, k]] for k in (1, 2, 3)]))
    for number, solid in enumerate(body.solids, 1):
        own = np.unique(part[facets[np.isin(shell, solid)]])
        labels[f"volume_{number}"] = np.isin(part[cells[:, 0]], own)
    return labels


def connected(facets: np.ndarray) -> np.ndarray:
    """Number of the connected part of every facet; facets that share an edge are connected."""
    _, place, _ = surface.edge_groups(facets)
    _, owner = surface.edges_of(facets)
    order = np.argsort(place, kind="stable")
    same = place[order][1:] == place[order][:-1]
    return surface.components(len(facets), np.stack([owner[order][1:][same], owner[order][:-1][same]], axis=1))


def sized(request: Request, body: Surface, volume: float) -> tuple:
    """Points [mm] and cells inside a surface, of the size of the request, and notes for the manifest."""
    cgal, polyhedron = load(), make_polyhedron(body.points, body.triangles)
    guess = request.length or (volume * sizing.CELLS_PER_CUBE / (request.cells or 5000)) ** (1 / 3)
    found = {}

    def generate(length: float, _jitter: int) -> int:
        found["criteria"] = criteria_for(request, length)
        first = first_points(body, found["criteria"]["facet_size"] / MM, request.seed)
        found["mesh"] = make_mesh(cgal, polyhedron, first, found["criteria"], switches(request))
        return len(found["mesh"][1])

    if request.cells:
        length, _ = sizing.find_length(generate, volume, request.cells, request.tolerance, log, bound="CGAL's criteria")
    else:
        length = guess
        log(f"{generate(length, 0)} cells")
    notes = {"length_m": length if request.length or request.cells else None, "cgal": found["criteria"] | switches(request)}
    return *found["mesh"], notes


def criteria_for(request: Request, length: float) -> dict:
    """The criteria [degrees, 1, m]: those of the request, otherwise defaults for the length."""
    values = {name: value * (length if name in CGAL_LENGTHS else 1) for name, value in DEFAULTS.items()}
    return values | {name: value for name, value in request.cgal.items() if name in DEFAULTS}


def switches(request: Request) -> dict:
    """Optimisers to run: those requested, otherwise perturbation and exudation if the request asks for optimisation."""
    return {name: request.cgal.get(name, default and request.optimise) for name, default in OPTIMISERS.items()}


def load():
    """CGAL's module, restricted to one core: on several, its refinement is parallel, not reproducible and no faster."""
    cores = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {cores[os.getpid() % len(cores)]})
    try:
        from CGAL import CGAL_Mesh_3
    except ImportError as error:
        raise MesherFailed(f"cgal is not installed: {error}", "python -m meshgen --doctor says what is missing") from error
    return CGAL_Mesh_3


def make_polyhedron(points: np.ndarray, triangles: np.ndarray):
    """CGAL polyhedron of outward triangles."""
    from CGAL.CGAL_Kernel import Point_3
    from CGAL.CGAL_Polyhedron_3 import Polyhedron_3, Polyhedron_modifier

    modifier = Polyhedron_modifier()
    modifier.begin_surface(len(points), len(triangles))
    for point in points.tolist():
        modifier.add_vertex(Point_3(*point))
    for triangle in triangles.tolist():
        modifier.begin_facet()
        for node in triangle:
            modifier.add_vertex_to_facet(node)
        modifier.end_facet()
    modifier.end_surface()
    polyhedron = Polyhedron_3()
    polyhedron.delegate(modifier)
    if not polyhedron.is_closed():
        raise BadRequest("CGAL finds the surface open", "give a closed surface")
    return polyhedron


def first_points(body: Surface, size: float, seed: int) -> np.ndarray:
    """Points (k, 3) on every shell, to start the refinement with: CGAL's own few points may miss a shell, or a slender body entirely.

    About one for each cube of `SPACING` edge lengths, or of the thickness of a thinner shell, four times its volume over its area."""
    found = []
    for shell in range(body.shell.max() + 1):
        own = body.triangles[body.shell == shell]
        vectors = np.cross(body.points[own[:, 1]] - body.points[own[:, 0]], body.points[own[:, 2]] - body.points[own[:, 0]])
        across = 4 * abs(surface.volume(body.points, own)) / (np.linalg.norm(vectors, axis=1).sum() / 2)
        step = min(SPACING * size, max(across, size / 2), np.ptp(body.points[np.unique(own)], axis=0).max() / 3)
        points, triangles, _ = recover.fine(body.points, own, np.zeros(len(own), int), step / 2)
        centres = points[triangles].mean(axis=1)
        shift = np.random.default_rng(seed).uniform(0, 1, 3) if seed else 0
        _, first = np.unique(np.floor(centres / step + shift).astype(int), axis=0, return_index=True)
        found.append(centres[first])
    return np.concatenate(found)


def make_mesh(cgal, polyhedron, first: np.ndarray, criteria: dict, optimisers: dict) -> tuple:
    """Points [mm] and cells of one run of CGAL from the first points. Optimisers have no time limit, so that the result is
    reproducible."""
    wanted = cgal.Default_mesh_criteria()
    wanted.facet_angle(criteria["facet_angle"])
    wanted.cell_radius_edge_ratio(criteria["cell_ratio"])
    wanted.facet_size(criteria["facet_size"] / MM)
    wanted.facet_distance(criteria["facet_approximation"] / MM)
    wanted.cell_size(criteria["cell_size"] / MM)
    parameters = cgal.Mesh_3_parameters()
    parameters.no_perturb()
    parameters.no_exude()
    if optimisers["odt"]:
        parameters.set_odt(0, 0, CONVERGENCE, FREEZE)
    if optimisers["lloyd"]:
        parameters.set_lloyd(0, 0, CONVERGENCE, FREEZE)
    if optimisers["perturb"]:
        parameters.set_perturb(0, 0)
    if optimisers["exude"]:
        parameters.set_exude(0, 0)
    domain = cgal.Polyhedral_mesh_domain_3(polyhedron)
    complex_ = begun(cgal, first)
    cgal.refine_mesh_3(complex_, domain, wanted, parameters)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cgal.mesh"
        complex_.output_to_medit(str(path))
        return read_medit(path.read_text())


def begun(cgal, first: np.ndarray):
    """A complex with the first points on its surface."""
    from CGAL.CGAL_Kernel import Point_3, Weighted_point_3

    complex_ = cgal.Mesh_3_Complex_3_in_triangulation_3()
    triangulation = complex_.triangulation()
    for point in first.tolist():
        vertex = triangulation.insert(Weighted_point_3(Point_3(*point), 0))
        complex_.set_dimension(vertex, 2)
        complex_.set_index(vertex, cgal.Mesh_3_Index((0, 1)))  # the surface between outside and inside
    return complex_


def read_medit(text: str) -> tuple:
    """Points and tetrahedra of the medit file that CGAL writes."""
    head, rest = text.split("\nVertices\n", 1)
    vertices, rest = rest.split("\nTriangles\n", 1)
    _, rest = rest.split("\nTetrahedra\n", 1)
    points = np.array(vertices.split()[1:], float).reshape(-1, 4)[:, :3]
    cells = np.array(rest.split("End")[0].split()[1:], int).reshape(-1, 5)[:, :4] - 1
    if not len(cells):
        raise MesherFailed("CGAL made no cells", "use smaller facet_size and cell_size")
    return points, cells


def remesh(body: Surface, patch: np.ndarray, length: float) -> tuple:
    """Points and outward triangles with edges of about `length` on a surface [mm], whose edges between patches are kept."""
    from CGAL import CGAL_Polygon_mesh_processing as processing

    polyhedron = make_polyhedron(body.points, body.triangles)
    for row, facet in enumerate(polyhedron.facets()):  # in the order in which they were added
        facet.set_id(row)
    kept = []
    for facet in polyhedron.facets():
        for halfedge in around(facet):
            if patch[facet.id()] < patch[halfedge.opposite().facet().id()]:
                kept.append(halfedge)
    processing.isotropic_remeshing(list(polyhedron.facets()), length, polyhedron, REMESHINGS, kept, False)
    if processing.does_self_intersect(polyhedron):
        raise MesherFailed(f"triangles of {length * MM:.3g} m cross each other", "use a smaller size")
    points = []
    for row, vertex in enumerate(polyhedron.vertices()):
        vertex.set_id(row)
        point = vertex.point()
        points.append((point.x(), point.y(), point.z()))
    triangles = [[halfedge.vertex().id() for halfedge in around(facet)] for facet in polyhedron.facets()]
    return np.array(points), np.array(triangles)


def around(facet) -> list:
    """The three halfedges of a triangle of a polyhedron."""
    first = facet.halfedge()
    return [first, first.next(), first.next().next()]
