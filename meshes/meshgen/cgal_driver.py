"""CGAL's Mesh_3 on a polyhedral domain: Delaunay refinement of the volume inside a triangle surface.

Sharp edges and labels are not passed to it: edges are rounded, and regions are recovered afterwards."""

import os
import random
import tempfile
from pathlib import Path

import numpy as np

from . import recover, sizing
from .errors import BadRequest, MesherFailed
from .geometry import MM, Geometry
from .gmsh_driver import log
from .mesh import assemble, boundary
from .request import CGAL_LENGTHS, Request

# Default criteria; lengths as fractions of the edge length.
DEFAULTS = {"facet_angle": 25.0, "cell_ratio": 3.0, "facet_size": 1.0, "facet_approximation": 0.1, "cell_size": 1.0}
OPTIMISERS = {"odt": False, "lloyd": False, "perturb": True, "exude": True}
CONVERGENCE, FREEZE = 0.02, 0.01  # of odt and lloyd, CGAL's defaults


def mesh(request: Request, geometry: Geometry, volume: float) -> tuple:
    """Mesh the volume of the current gmsh model with CGAL. Returns the mesh and notes for the manifest.

    volume: that of the CAD [m³], for the first guess of the length."""
    cgal = load()
    guess = request.length or (volume * sizing.CELLS_PER_CUBE / (request.cells or 5000)) ** (1 / 3)
    criteria = criteria_for(request, guess, 1.0)
    size = min(criteria["facet_size"], criteria["cell_size"]) / MM / 2
    if request.seed:  # CGAL draws its first points from the triangles of the surface: another surface, another sample
        size *= random.Random(request.seed).uniform(0.6, 1.0)
    skin = recover.skin(geometry, size)
    polyhedron = make_polyhedron(skin.points, skin.triangles)
    found = {}

    def generate(length: float, _jitter: int) -> int:
        found["criteria"] = criteria_for(request, guess, length / guess)
        found["mesh"] = make_mesh(cgal, polyhedron, found["criteria"], switches(request))
        return len(found["mesh"][1])

    if request.cells:
        length, _ = sizing.find_length(generate, volume, request.cells, request.tolerance, log)
    else:
        length = guess
        log(f"{generate(length, 0)} cells")
    points, cells = found["mesh"]
    facets = boundary(cells)
    names = recover.facet_regions(points, facets, skin, geometry)
    labels = {name: facets[rows] for name, rows in names.items()}
    cell_labels = recover.cell_regions(points[cells].mean(axis=1), geometry)
    result = assemble(points * MM, cells, cell_labels, labels)
    notes = {
        "length_m": length if request.length or request.cells else None,
        "cgal": found["criteria"] | switches(request),
        "edge_error_m": recover.edge_error(points, facets, skin) * MM,
    }
    return result, notes


def criteria_for(request: Request, length: float, scale: float) -> dict:
    """The criteria [degrees, 1, m]: those of the request, otherwise defaults for the length; lengths are multiplied by `scale`."""
    values = {name: value * (length if name in CGAL_LENGTHS else 1) for name, value in DEFAULTS.items()}
    values |= {name: value for name, value in request.cgal.items() if name in DEFAULTS}
    return {name: value * (scale if name in CGAL_LENGTHS else 1) for name, value in values.items()}


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


def make_mesh(cgal, polyhedron, criteria: dict, optimisers: dict) -> tuple:
    """Points [mm] and cells of one run of CGAL. Optimisers have no time limit, so that the result is reproducible."""
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
    complex_ = cgal.make_mesh_3(domain, wanted, parameters)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cgal.mesh"
        complex_.output_to_medit(str(path))
        return read_medit(path.read_text())


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
