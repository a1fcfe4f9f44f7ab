"""gmsh: the session, and volume meshes of the CAD in the current model."""

import contextlib
import sys

import gmsh
import numpy as np

from . import curved, nested, sizing
from .errors import BadRequest, MesherFailed, MeshgenError
from .geometry import MM, Geometry
from .mesh import TetMesh, assemble
from .request import Request

OPTIONS = {
    "General.Terminal": 0,
    "General.NumThreads": 1,
    "Geometry.OCCBoundsUseStl": 0,
    "Mesh.MeshSizeFromPoints": 0,
    "Mesh.MeshSizeFromCurvature": 0,
    "Mesh.MeshSizeExtendFromBoundary": 0,
    "Mesh.HighOrderOptimize": 0,
}


# Words in messages of gmsh if facets of a surface mesh cross each other: on the two sides of a thin wall, or where the faces of many struts join.
SIGNS_OF_CROSSING = ("PLC", "overlapping facets", "intersect")
CROSSED = (
    "facets of the surface mesh cross each other. If a wall is thinner than a cell, take a size no larger than the wall is thick, or more cells; "
    'if not, write generator = "cgal" and element = "tet4" in [mesh] of a scene: CGAL meshes no face by itself, and rounds sharp edges. '
    "Bores that are thin against the cells, as for cables, are best filled in the CAD: a cable is given by guides within the body, and needs none"
)
OTHER_SIZE = "change the size a little, or the parameters"


def log(message: str) -> None:
    """One line of progress on stderr."""
    print(f"meshgen: {message}", file=sys.stderr, flush=True)


@contextlib.contextmanager
def session(seed: int = 0):
    """An empty gmsh model with one thread and a fixed seed; gmsh's own errors become MesherFailed."""
    gmsh.initialize([], False, False, False)
    try:
        for name, value in OPTIONS.items():
            gmsh.option.setNumber(name, value)
        gmsh.option.setNumber("Mesh.RandomSeed", seed)
        gmsh.logger.start()
        yield
    except MeshgenError:
        raise
    except Exception as error:
        told = [line for line in gmsh.logger.get() if line.startswith("Error")]
        cause = (told or [str(error) or repr(error)])[-1]
        raise MesherFailed(f"gmsh: {cause}", CROSSED if any(sign in cause for sign in SIGNS_OF_CROSSING) else OTHER_SIZE) from error
    finally:
        gmsh.finalize()


def cad_volume(geometry: Geometry) -> float:
    """Volume of the CAD [m³]."""
    return (geometry.volume or mass(geometry.volumes)) * MM**3


def solid_volumes(geometry: Geometry) -> dict:
    """Volumes of the cell regions that are a part of the CAD [m³]; empty if the CAD kernel does not know them."""
    if geometry.volume:
        return {}
    parts = {name: tags for name, (dim, tags) in geometry.regions.items() if dim == 3 and set(tags) != set(geometry.volumes)}
    return {name: mass(tags) * MM**3 for name, tags in parts.items()}


def mass(volumes: list) -> float:
    """Volume of solids of the CAD [mm³], also of solids that are inside out in the file."""
    return sum(abs(gmsh.model.occ.getMass(3, tag)) for tag in volumes)


def mesh(request: Request, geometry: Geometry, volume: float) -> tuple:
    """Mesh the CAD as requested. Returns the mesh and notes for the manifest.

    volume: volume of the CAD [m³], for the first guess of the length."""
    check_grading(request, geometry)
    gmsh.option.setNumber("Mesh.OptimizeNetgen", 1 if request.optimise else 0)

    def generate(length: float, jitter: int) -> int:
        geometry.clear_mesh(length / MM)
        sizing.apply(length, request.seed + 7919 * jitter, request, geometry)
        gmsh.model.mesh.generate(3)
        return count_cells()

    if request.cells:
        length, jitter = sizing.find_length(generate, volume, request.cells, request.tolerance, log, "the graded lengths" if request.grading else sizing.FACES)
    else:
        length, jitter = request.length, 0
        log(f"{generate(length, jitter)} cells at length {length:.4g} m")
    off = [np.zeros(0)]
    for level in range(request.levels):
        off.append(nested.refine(collect_cells, log))
        log(f"level {level + 1}: {count_cells()} cells")
    if request.order == 2:
        gmsh.model.mesh.setOrder(2)
        off.append(curved.untangle(collect_cells, log))
    off = np.concatenate(off)
    return collect(geometry), {"length_m": length, "jitter": jitter, "straightened_edges": len(off), "straightened_m": float(off.max(initial=0))}


def check_grading(request: Request, geometry: Geometry) -> None:
    """Refuse grading at features that the body does not have, and at places that it does not reach."""
    features = [entry["feature"] for entry in request.grading if "feature" in entry]
    for feature in features:
        if feature not in geometry.features:
            known = ", ".join(sorted(geometry.features)) or "none; use points or a box"
            raise BadRequest(f"{request.body} has no grading feature {feature}", f"its features: {known}")
    bounds = gmsh.model.getBoundingBox(-1, -1)
    low, high = bounds[:3], bounds[3:]
    outside = [point for entry in request.grading for point in sizing.beyond(entry, (low, high))]
    if outside:
        places = ", ".join(named(point) for point in outside)
        raise BadRequest(f"grading at {places} mm does not reach the body", f"its bounding box is {named(low)} to {named(high)} mm")


def named(point: list) -> str:
    """A point as text."""
    return f"({', '.join(f'{x:.4g}' for x in point)})"


def count_cells() -> int:
    """Number of tetrahedra in the model; refuses volumes without any."""
    total = 0
    for _, tag in gmsh.model.getEntities(3):
        count = sum(map(len, gmsh.model.mesh.getElements(3, tag)[1]))
        if count == 0:
            raise MesherFailed(f"gmsh left volume {tag} without cells", "try another size or seed")
        total += count
    return total


def collect_nodes() -> tuple:
    """All nodes [m] and the map from gmsh's tags to rows."""
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    row = np.full(int(tags.max()) + 1, -1)
    order = np.argsort(tags)
    row[tags[order].astype(int)] = np.arange(len(tags))
    return xyz.reshape(-1, 3)[order] * MM, row


def collect_elements(dim: int, tags: list) -> np.ndarray:
    """Node tags of all elements on some entities, one row per element."""
    rows = []
    for tag in tags:
        for kind, nodes in zip(*gmsh.model.mesh.getElements(dim, tag)[::2]):
            rows.append(nodes.astype(int).reshape(-1, gmsh.model.mesh.getElementProperties(kind)[3]))
    return np.concatenate(rows) if rows else np.zeros((0, 3), int)


def collect_cells() -> tuple:
    """Points [m] and cells of the whole model, for checks."""
    points, row = collect_nodes()
    return points, row[collect_elements(3, [tag for _, tag in gmsh.model.getEntities(3)])]


def collect(geometry: Geometry) -> TetMesh:
    """The model's mesh with the geometry's regions."""
    points, row = collect_nodes()
    cells = [row[collect_elements(3, [tag])] for tag in geometry.volumes]
    owner = np.repeat(geometry.volumes, [len(block) for block in cells])
    cell_labels, facet_labels = {}, {}
    for name, (dim, tags) in geometry.regions.items():
        if dim == 3:
            cell_labels[name] = np.isin(owner, tags)
        else:
            facet_labels[name] = row[collect_elements(2, tags)[:, :3]]
    mesh = assemble(points, np.concatenate(cells), cell_labels, facet_labels)
    add_unions(mesh, geometry.unions)
    return mesh


def add_unions(mesh: TetMesh, unions: dict) -> None:
    """Add the facet regions that are unions of others."""
    for name, members in unions.items():
        mesh.regions[name] = (2, np.sort(np.concatenate([mesh.regions[member][1] for member in members])))
