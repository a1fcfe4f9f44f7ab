"""Size of the cells: edge length, graded places, target cell counts."""

import math
import random

import gmsh
import numpy as np

from .errors import BadRequest, SizeNotReached
from .geometry import MM

CELLS_PER_CUBE = 5.5  # cells per cube of edge length in a fine gmsh mesh, for the first guess
NOISE = 0.05  # relative variation of the length in meshes with a seed
ATTEMPTS = 24  # for a target count within the tolerance
ALIKE = 0.05  # relative difference of counts that are bounded from below
ABOVE = 1.2  # ratio of a number of cells that can be reached to that bound
LEAST_SAMPLES, MOST_SAMPLES = 40, 1000  # sample points along the diagonal of a face, for distances from it
FACES = "the faces of the body"
NEAR = 0.1  # the nearest attempt is accepted within this relative deviation, if none is within the tolerance


def apply(length: float, wave: int, request, geometry) -> None:
    """Set gmsh's size fields: `length` [m] everywhere, smaller near graded places.

    A place's length holds up to `distance` from it and grows to the base length over another `distance`.
    A wave other than 0 varies the base length smoothly in space by 5 %: see `noise`. A size field of the request
    multiplies the base length."""
    for tag in gmsh.model.mesh.field.list():
        gmsh.model.mesh.field.remove(tag)
    for tag in gmsh.view.getTags():
        gmsh.view.remove(tag)
    h = length / MM
    if request.size_field:
        return apply_field(h, wave, request, geometry)
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", h * (1 + NOISE))
    fields = [add_field("MathEval", {}, F=noise(h, wave))]
    for entry in request.grading:
        fields += graded(entry, geometry, h)
    if len(fields) > 1 or wave:
        gmsh.model.mesh.field.setAsBackgroundMesh(add_field("Min", {"FieldsList": fields}))
    else:
        gmsh.option.setNumber("Mesh.MeshSizeMin", h)
        gmsh.option.setNumber("Mesh.MeshSizeMax", h)


def apply_field(h: float, wave: int, request, geometry) -> None:
    """Set h times the size field of the request, smaller near graded places; h in mm."""
    field = request.size_field
    corners = field["points"][field["cells"]] / MM
    columns = [corners[:, :, axis] for axis in range(3)] + [field["sizes"][field["cells"]]]
    data = np.concatenate(columns, axis=1)
    view = gmsh.view.add("size")
    gmsh.view.addListData(view, "SS", len(data), data.ravel())
    relative = add_field("PostView", {}, ViewTag=view)
    fields = [add_field("MathEval", {}, F=f"F{relative}*({noise(h, wave)})")]
    for entry in request.grading:
        fields += graded(entry, geometry, h * field["sizes"].max())
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", h * field["sizes"].max() * (1 + NOISE))
    gmsh.model.mesh.field.setAsBackgroundMesh(add_field("Min", {"FieldsList": fields}))


def noise(h: float, wave: int) -> str:
    """A formula for the base length [mm]: constant for wave 0, otherwise a plane wave of random direction and phase.

    The seed of a request chooses the wave, so that meshes with different seeds are different samples of the
    same size; gmsh's own random seed hardly changes the mesh."""
    if wave == 0:
        return f"{h:.17g}"
    draw = random.Random(wave)
    axis = [draw.gauss(0, 1) for _ in range(3)]
    number = 2 * math.pi / (8 * h * math.hypot(*axis))
    kx, ky, kz = (number * a for a in axis)
    return f"{h:.17g}*(1+{NOISE}*sin(({kx:.12g})*x+({ky:.12g})*y+({kz:.12g})*z+{draw.uniform(0, 2 * math.pi):.12g}))"


def graded(entry: dict, geometry, h: float) -> list:
    """Fields for one grading entry: a ball around each point, a box, or the distance from faces."""
    small, near = entry["length"] / MM, entry["distance"] / MM
    if "box" in entry:
        low, high = entry["box"] / MM
        sides = {f"{axis}{end}": value for end, corner in (("Min", low - near), ("Max", high + near)) for axis, value in zip("XYZ", corner)}
        return [add_field("Box", {}, VIn=small, VOut=h, Thickness=near, **sides)]
    points = entry["points"] / MM if "points" in entry else geometry.features[entry["feature"]]
    if not np.isscalar(points[0]):
        return [
            add_field("Ball", {}, VIn=small, VOut=h, Radius=near, Thickness=near, XCenter=x, YCenter=y, ZCenter=z)
            for x, y, z in points
        ]
    alike = {}
    for face in points:
        alike.setdefault(sampling(face, near), []).append(face)
    distances = [add_field("Distance", {"SurfacesList": faces}, Sampling=number) for number, faces in alike.items()]
    return [add_field("Threshold", {}, InField=field, SizeMin=small, SizeMax=h, DistMin=near, DistMax=2 * near) for field in distances]


def sampling(face: int, distance: float) -> int:
    """Number of points along the diagonal of a face by which gmsh finds distances from it: two or more for each `distance` [mm] of grading."""
    box = gmsh.model.getBoundingBox(2, face)
    wanted = 2 * math.dist(box[:3], box[3:]) / distance
    if wanted > MOST_SAMPLES:
        fact = f"a distance of grading of {distance * MM:.3g} m is less than a {MOST_SAMPLES // 2}th of the diagonal of a face"
        raise BadRequest(fact, "use a larger distance, or grade at points or in a box")
    return LEAST_SAMPLES << max(0, math.ceil(math.log2(wanted / LEAST_SAMPLES)))


def beyond(entry: dict, bounds: tuple) -> list:
    """Corners or points [mm] of a grading entry that has no effect, because it is farther than twice its distance from the bounds [mm] of a body."""
    if "feature" in entry:
        return []
    low, high = (np.asarray(corner) for corner in bounds)
    reach = 2 * entry["distance"] / MM
    if "box" in entry:
        box = entry["box"] / MM
        return list(box) if np.any((box[1] + reach < low) | (box[0] - reach > high)) else []
    return [point for point in entry["points"] / MM if np.any((point + reach < low) | (point - reach > high))]


def add_field(kind: str, lists: dict, **values) -> int:
    """A gmsh size field with its options."""
    tag = gmsh.model.mesh.field.add(kind)
    for name, value in lists.items():
        gmsh.model.mesh.field.setNumbers(tag, name, value)
    for name, value in values.items():
        setter = gmsh.model.mesh.field.setString if isinstance(value, str) else gmsh.model.mesh.field.setNumber
        setter(tag, name, value)
    return tag


def find_length(generate, volume: float, target: int, tolerance: float, log, bound: str = FACES) -> tuple:
    """The edge length [m] and jitter for which generate(length, jitter) makes `target` cells within the tolerance.

    Secant method in log length and log count, within the bracket of previous attempts. The count jumps where
    an edge of the CAD is divided differently; once the bracket is as narrow as such a jump, other waves of the size
    field (jitter 1, 2, …) are tried around it. If none is within the tolerance, the nearest is made again, if it is within NEAR.
    The last call of generate() is the accepted one. bound: the reason why cells stay small if the edge length does not limit them."""
    goal, tried, near = math.log(target), [], max(tolerance, NEAR)
    scatter = random.Random(0)
    x, jitter = math.log((volume * CELLS_PER_CUBE / target) ** (1 / 3)), 0
    for _ in range(ATTEMPTS):
        count = generate(math.exp(x), jitter)
        log(f"length {math.exp(x):.5g} m: {count} cells, wanted {target}")
        if abs(count - target) <= tolerance * target:
            return math.exp(x), jitter
        tried.append((x, math.log(count) - goal, jitter))
        # Longer edges do not reduce the number of cells
        if len(tried) > 3 and not coarse(tried) and abs(tried[-1][1] - tried[-3][1]) < 0.01:
            break
        if is_bounded(tried) and min(excess for _, excess in fine(tried)) > math.log(1 + near):
            break
        x = next_guess(tried)
        if jitter or is_stuck(tried):
            jitter += 1
            x = (max(fine(tried))[0] + min(coarse(tried))[0]) / 2 + scatter.uniform(-0.04, 0.04)
    nearest = min(tried, key=lambda attempt: abs(attempt[1]))
    if abs(math.exp(nearest[1]) - 1) <= near:
        log(f"within {100 * tolerance:g} % after {len(tried)} attempts there was none: {generate(math.exp(nearest[0]), nearest[2])} cells are taken")
        return math.exp(nearest[0]), nearest[2]
    cells = round(math.exp(goal + nearest[1]))
    missed = f"{target} cells within {100 * near:g} % not reached in {len(tried)} attempts; "
    if is_bounded(tried):
        alike = [excess for _, excess in fine(tried) if excess <= nearest[1] + math.log(1 + ALIKE)]
        hint = f"cells = {cells}" if max(alike) == nearest[1] else f"cells = {rounded_up(ABOVE * cells)} or more"
        raise SizeNotReached(f"{missed}{bound} allow no fewer than about {cells} cells", f"ask for {hint}", cells)
    hint = f"ask for cells = {cells}, or take another seed" + (f"; {bound} bound the count from below" if bound != FACES else "")
    raise SizeNotReached(f"{missed}the nearest was {cells} cells at length {math.exp(nearest[0]):.5g} m", hint, cells)


def rounded_up(count: float) -> int:
    """The next number with two significant digits."""
    unit = 10 ** max(len(str(int(count))) - 2, 0)
    return math.ceil(count / unit) * unit


def fine(tried: list) -> list:
    """(log length, log(count / target)) of the attempts with too many cells."""
    return [attempt[:2] for attempt in tried if attempt[1] > 0]


def coarse(tried: list) -> list:
    """(log length, log(count / target)) of the attempts with too few cells."""
    return [attempt[:2] for attempt in tried if attempt[1] <= 0]


def is_stuck(tried: list) -> bool:
    """Whether the lengths with too many and with too few cells have converged without reaching the target."""
    return bool(fine(tried) and coarse(tried)) and min(coarse(tried))[0] - max(fine(tried))[0] < 2e-3


def is_bounded(tried: list) -> bool:
    """Whether longer edges do not reduce the number of cells: every attempt has too many, and three or more, whose lengths differ by a factor of two or more, have
    counts within ALIKE of the smallest."""
    if coarse(tried):
        return False
    least = min(excess for _, excess in fine(tried))
    lengths = [x for x, excess in fine(tried) if excess <= least + math.log(1 + ALIKE)]
    return len(lengths) > 2 and max(lengths) - min(lengths) >= math.log(2)


def next_guess(tried: list) -> float:
    """Next log length from (log length, log(count / target), jitter) of the attempts."""
    if not fine(tried) or not coarse(tried):
        x, excess = tried[-1][:2]
        slope = 3.0
        if len(tried) > 1 and x != tried[-2][0]:
            slope = min(max((tried[-2][1] - excess) / (x - tried[-2][0]), 0.5), 6.0)
        return x + min(max(excess / slope, -0.7), 0.7)
    (a, too_many), (b, too_few) = max(fine(tried)), min(coarse(tried))
    x = a + (b - a) * too_many / (too_many - too_few)
    margin = 0.1 * (b - a)
    return min(max(x, a + margin), b - margin)
