"""Repair of triangle surfaces from files: defects with a unique repair are repaired and reported, all others are refused with their position.

Lengths are in the unit of the file; tolerances are relative to its largest extent."""

import numpy as np

from . import surface
from .crossing import crossing_point, crossings, place
from .errors import BadRequest
from .surface import Surface

COINCIDENT = 1e-7  # nodes closer than this are merged, triangles of smaller height are flat, and surfaces closer than this are in contact
GAP = 1e-5  # nodes of open edges closer than this are joined
ROUNDS = 8
MOST_PAIRS = 300  # largest number of crossing pairs that are examined, since each takes a sum over the whole surface


def closed(name: str, points: np.ndarray, triangles: np.ndarray, may_cross: bool) -> Surface:
    """The closed surface of some triangles: joined, without flat and duplicate triangles, oriented, sorted into shells.

    may_cross: crossing triangles of one shell are reported and kept if they cover no space twice, for generators that only test what is inside."""
    size = np.ptp(points[np.unique(triangles)], axis=0).max()
    if size == 0:
        raise BadRequest(f"{name}: all points of the surface coincide", "export it again")
    repairs = []
    points, triangles = cleaned(points, triangles, COINCIDENT * size, repairs)
    triangles = flipped(points, triangles, COINCIDENT * size, repairs)
    points, triangles = joined(points, triangles, GAP * size, repairs)
    if not len(triangles):
        raise BadRequest(f"{name}: nothing of the surface is left without flat and doubled triangles", "export a closed surface")
    defects = edge_defects(points, triangles)
    if defects:
        refuse(name, defects)
    shell, reverse, conflict = surface.walk(surface.neighbours(triangles))
    if conflict is not None:
        refuse(name, [f"it has one side only, like a Moebius strip, seen at {spot(points[triangles[conflict]].mean(axis=0))}"])
    if reverse.any():
        repairs.append(f"{counted(reverse.sum(), 'triangle')} reversed to agree with the neighbours, one at {first(points, triangles, reverse)}")
    triangles = np.where(reverse[:, None], triangles[:, [0, 2, 1]], triangles)
    defects = node_defects(points, triangles)
    points, triangles, shell = without_flat_shells(points, triangles, shell, COINCIDENT * size, repairs)
    found = crossings(points, triangles, COINCIDENT * size)
    within = shell[found[:, 0]] == shell[found[:, 1]]
    if not within.all():
        where = spot(place(points, triangles, found[~within][0]))
        defects.append(f"two of its {shell.max() + 1} parts cross or touch, with {counted((~within).sum(), 'pair')} of triangles, one at {where}")
    twice = covered_twice(points, triangles, shell, found[within])
    if within.any():
        told = f"{counted(within.sum(), 'pair')} of triangles cross or touch, one at {spot(place(points, triangles, found[within][0]))}"
        if twice is not None:
            defects.append(f"{told}, and cover space twice, as at {spot(twice)}")
        elif may_cross:
            repairs.append(told + ": left as they are")
        else:
            defects.append(told)
    if defects:
        refuse(name, defects, twice is not None)
    triangles, solids = surface.nested(points, triangles, shell)
    used, inverse = np.unique(triangles, return_inverse=True)
    return Surface(points[used], inverse.reshape(-1, 3), shell, solids, repairs)


def covered_twice(points: np.ndarray, triangles: np.ndarray, shell: np.ndarray, pairs: np.ndarray) -> np.ndarray | None:
    """A point around which the shell of two crossing triangles winds twice: there the inside is not defined, and parity would make it a hole.

    Of very many pairs, as in a noisy scan, a sample from the whole surface is examined: successive pairs along a crossing are similar."""
    sign = [1 if surface.volume(points, triangles[shell == own]) > 0 else -1 for own in range(shell.max() + 1)]
    for a, b in pairs[:: -(-len(pairs) // MOST_PAIRS) or 1].tolist():
        at = crossing_point(points[triangles[a]], points[triangles[b]])
        if at is None:
            continue
        corners = points[triangles[shell == shell[a]]]
        inwards = -sign[shell[a]] * surface.normals(points, triangles[[a, b]]).sum(axis=0)
        probe = at + 10 * COINCIDENT * np.ptp(corners, axis=(0, 1)).max() * inwards
        if sign[shell[a]] * surface.winding(probe[None], corners)[0] > 1.5:
            return at
    return None


def refuse(name: str, defects: list, twice: bool = False) -> None:
    """Raise the error that names all defects."""
    remedy = "repair it there (the places are in the unit of the file)"
    if twice:
        remedy += "; where parts of a body meet, unite them in CAD"
    elif len(defects) == 1 and "of triangles cross or touch" in defects[0]:
        remedy += ', or try generator = "cgal", which meshes what is inside'
    raise BadRequest(f"{name} is no closed surface that bounds a body: {'; '.join(defects)}", remedy)


def cleaned(points: np.ndarray, triangles: np.ndarray, tolerance: float, repairs: list) -> tuple:
    """Merge coincident nodes; drop triangles that are left with two nodes, and duplicate triangles."""
    points, triangles = merged(points, triangles, np.unique(triangles), tolerance)
    keep = distinct(triangles)
    if not keep.all():
        repairs.append(f"{counted((~keep).sum(), 'triangle')} with coinciding corners dropped, one at {first(points, triangles, ~keep)}")
        triangles = triangles[keep]
    return points, once(points, triangles, repairs)


def merged(points: np.ndarray, triangles: np.ndarray, among: np.ndarray, tolerance: float) -> tuple:
    """Nodes of `among` within the tolerance of each other become the first of them.

    They are sorted along an oblique line, on which nearby nodes stay close."""
    line = points[among] @ np.array([0.61, 0.53, 0.59])
    order = np.argsort(line, kind="stable")
    pairs, step = [np.zeros((0, 2), int)], 1
    while step < len(order):
        a, b = order[:-step], order[step:]
        near = line[b] - line[a] <= tolerance
        if not near.any():
            break
        close = near & (np.linalg.norm(points[among[b]] - points[among[a]], axis=1) <= tolerance)
        pairs.append(np.stack([a[close], b[close]], axis=1))
        step += 1
    group = surface.components(len(among), np.concatenate(pairs))
    head = np.full(group.max(initial=-1) + 1, len(points))
    np.minimum.at(head, group, among)
    renumber = np.arange(len(points))
    renumber[among] = head[group]
    return points, renumber[triangles]


def distinct(triangles: np.ndarray) -> np.ndarray:
    """Mask of the triangles with three different nodes."""
    a, b, c = triangles.T
    return (a != b) & (b != c) & (c != a)


def once(points: np.ndarray, triangles: np.ndarray, repairs: list) -> np.ndarray:
    """Of triangles with the same nodes one is kept, or none if they face each other, as in a wall without thickness; of a closed shell of such pairs one."""
    turns = (triangles[:, 0] > triangles[:, 1]).astype(int) + (triangles[:, 1] > triangles[:, 2]) + (triangles[:, 0] > triangles[:, 2])
    _, group, counts = np.unique(np.sort(triangles, axis=1), axis=0, return_inverse=True, return_counts=True)
    group = group.ravel()
    if np.all(counts == 1):
        return triangles
    sign = np.where(turns % 2 == 0, 1, -1)
    net = np.zeros(len(counts), int)
    np.add.at(net, group, sign)
    heads = np.unique(group, return_index=True)[1]
    facing = np.flatnonzero(net == 0)
    net[facing[closed_shells(triangles[heads[facing]], triangles[heads[net != 0]])]] = 1
    seen, keep = set(), np.ones(len(triangles), bool)
    for row in np.flatnonzero(counts[group] > 1):
        g = int(group[row])
        keep[row] = net[g] * sign[row] > 0 and g not in seen
        if keep[row]:
            seen.add(g)
    repairs.append(f"{counted((~keep).sum(), 'doubled triangle')} dropped, one at {first(points, triangles, ~keep)}")
    return triangles[keep]


def closed_shells(triangles: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Mask of the triangles in parts without open edges of which no edge is one of another triangle."""
    if not len(triangles):
        return np.zeros(0, bool)
    keys, place, counts = surface.edge_groups(np.concatenate([triangles, others]))
    owner = surface.edges_of(np.concatenate([triangles, others]))[1]
    own = owner < len(triangles)
    inside = np.bincount(place[own], minlength=len(keys))
    order = np.argsort(place[own], kind="stable")
    rows, at = owner[own][order], place[own][order]
    part = surface.components(len(triangles), np.stack([rows[:-1], rows[1:]], axis=1)[at[:-1] == at[1:]])
    is_open = (inside[at] != 2) | (counts[at] != 2)
    return ~np.isin(part, part[rows[is_open]])


def flipped(points: np.ndarray, triangles: np.ndarray, tolerance: float, repairs: list) -> np.ndarray:
    """Remove flat triangles with three distinct corners: the edge that contains the middle corner is flipped."""
    triangles, count, where = triangles.copy(), 0, None
    for _ in range(ROUNDS):
        flat = np.flatnonzero(heights(points, triangles) <= tolerance)
        if not len(flat):
            break
        edges = {}
        for row, nodes in enumerate(triangles.tolist()):
            for i in range(3):
                edges.setdefault(frozenset((nodes[i], nodes[(i + 1) % 3])), []).append((row, nodes[(i + 2) % 3]))
        changed = set()
        for row in flat.tolist():
            nodes = triangles[row].tolist()
            lengths = [np.linalg.norm(points[nodes[i]] - points[nodes[(i + 1) % 3]]) for i in range(3)]
            i = int(np.argmax(lengths))
            a, b, c = nodes[i], nodes[(i + 1) % 3], nodes[(i + 2) % 3]
            around = edges[frozenset((a, b))]
            other = next((pair for pair in around if pair[0] != row), None)
            if len(around) != 2 or other is None or {row, other[0]} & changed or frozenset((c, other[1])) in edges:
                continue
            where = where if where is not None else points[c]
            triangles[row], triangles[other[0]] = (a, other[1], c), (other[1], b, c)
            changed |= {row, other[0]}
        count += len(changed) // 2
        if not changed:
            break
    if count:
        repairs.append(f"{counted(count, 'flat triangle')} removed by flipping an edge, one at {spot(where)}")
    return triangles


def heights(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Smallest height of every triangle."""
    corners = points[triangles]
    longest = np.linalg.norm(corners[:, [1, 2, 0]] - corners, axis=2).max(axis=1)
    twice = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return twice / np.maximum(longest, 1e-300)


def joined(points: np.ndarray, triangles: np.ndarray, tolerance: float, repairs: list) -> tuple:
    """Close open edges if there is a unique solution: gaps within the tolerance, nodes on edges, holes of three edges."""
    border = open_edges(triangles)
    if not len(border):
        return points, triangles
    before = len(border)
    where = spot(points[border[0]].mean(axis=0))
    points, triangles = merged(points, triangles, np.unique(border), tolerance)
    triangles = once(points, triangles[distinct(triangles)], [])
    for _ in range(ROUNDS):
        border = open_edges(triangles)
        split = divided(points, triangles, border, tolerance)
        if split is None:
            break
        triangles = once(points, split[distinct(split)], [])
    left = len(open_edges(triangles))
    if left < before:
        repairs.append(f"{before - left} open edges joined within {tolerance:.3g}, one at {where}")
    return points, filled(points, triangles, repairs)


def open_edges(triangles: np.ndarray) -> np.ndarray:
    """Directed edges (k, 2) that belong to one triangle only."""
    edges, _ = surface.edges_of(triangles)
    _, place, counts = surface.edge_groups(triangles)
    return edges[counts[place] == 1]


def divided(points: np.ndarray, triangles: np.ndarray, border: np.ndarray, tolerance: float) -> np.ndarray | None:
    """Divide triangles whose open edge passes through nodes of other open edges; None if there are none."""
    nodes, cuts = np.unique(border), {}
    for a, b in border.tolist():
        along = points[b] - points[a]
        length = np.linalg.norm(along)
        offset = points[nodes] - points[a]
        t = offset @ along / length**2
        apart = np.linalg.norm(offset - t[:, None] * along, axis=1)
        on = (apart <= tolerance) & (t * length > tolerance) & ((1 - t) * length > tolerance) & (nodes != a) & (nodes != b)
        if on.any():
            cuts[a, b] = nodes[on][np.argsort(t[on])].tolist()
    if not cuts:
        return None
    result = []
    for nodes_of in triangles.tolist():
        pieces = [nodes_of]
        for i in range(3):
            a, b, c = nodes_of[i], nodes_of[(i + 1) % 3], nodes_of[(i + 2) % 3]
            if (a, b) in cuts:
                chain = [a, *cuts[a, b], b]
                pieces = [[x, y, c] for x, y in zip(chain, chain[1:])]
                break  # another edge of the same triangle in the next round
        result += pieces
    return np.array(result)


def filled(points: np.ndarray, triangles: np.ndarray, repairs: list) -> np.ndarray:
    """Close holes of three edges by a triangle; the edges of a loose triangle are none."""
    border = open_edges(triangles)
    after, known = {}, set(map(tuple, np.sort(triangles, axis=1).tolist()))
    for a, b in border.tolist():
        after.setdefault(b, []).append(a)  # the missing triangle runs against the edge
    new = []
    for a in sorted(after):
        if len(after[a]) == 1:
            b = after[a][0]
            c = after.get(b, [None])[0]
            if c is not None and len(after[b]) == 1 and after.get(c) == [a] and a < b and a < c and tuple(sorted((a, b, c))) not in known:
                new.append([a, b, c])
    if not new:
        return triangles
    where = spot(points[new[0]].mean(axis=0))
    repairs.append(f"{counted(len(new), 'hole')} of three edges closed by a triangle, one at {where}")
    return np.concatenate([triangles, new])


def edge_defects(points: np.ndarray, triangles: np.ndarray) -> list:
    """Describe holes, and edges of more than two triangles."""
    keys, _, counts = surface.edge_groups(triangles)
    defects = []
    border = keys[counts == 1]
    if len(border):
        nodes, rows = np.unique(border, return_inverse=True)
        hole = surface.components(len(nodes), rows.reshape(-1, 2))
        spans = [np.ptp(points[nodes[hole == h]], axis=0).max() for h in range(hole.max() + 1)]
        widest = points[nodes[hole == int(np.argmax(spans))]]
        defects.append(
            f"it is open at {counted(len(spans), 'hole')} with {counted(len(border), 'border edge')}, the widest {max(spans):.4g} wide around {spot(widest.mean(axis=0))}"
        )
    many = keys[counts > 2]
    if len(many):
        defects.append(f"{counted(len(many), 'edge')} with more than two triangles, one at {spot(points[many[0]].mean(axis=0))}")
    return defects


def node_defects(points: np.ndarray, triangles: np.ndarray) -> list:
    """Describe nodes that two parts of the surface share without a common edge."""
    edges, owner = surface.edges_of(triangles)
    _, place, _ = surface.edge_groups(triangles)
    pair = np.argsort(place, kind="stable").reshape(-1, 2)
    start = np.tile([0, 1, 2], (len(triangles), 1)).T.ravel()  # corner of the triangle at which the directed edge begins
    corner = np.stack([owner * 3 + start, owner * 3 + (start + 1) % 3], axis=1)
    same = edges[pair[:, 0], 0] == edges[pair[:, 1], 0]
    one, other = corner[pair[:, 0]], np.where(same[:, None], corner[pair[:, 1]], corner[pair[:, 1]][:, ::-1])
    fan = surface.components(triangles.size, np.concatenate([np.stack([one[:, k], other[:, k]], axis=1) for k in (0, 1)]))
    heads = np.unique(np.stack([triangles.ravel(), fan], axis=1), axis=0)[:, 0]
    nodes, counts = np.unique(heads, return_counts=True)
    bad = nodes[counts > 1]
    return [f"two of its parts share {counted(len(bad), 'single node')}, one at {spot(points[bad[0]])}"] if len(bad) else []


def without_flat_shells(points: np.ndarray, triangles: np.ndarray, shell: np.ndarray, tolerance: float, repairs: list) -> tuple:
    """Drop shells that enclose no volume, compared with their area times the tolerance."""
    corners = points[triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    keep = np.ones(len(triangles), bool)
    for own in range(shell.max() + 1):
        rows = shell == own
        if abs(surface.volume(points, triangles[rows])) <= tolerance * area[rows].sum():
            keep[rows] = False
    if keep.all():
        return points, triangles, shell
    if not keep.any():
        raise BadRequest("the surface encloses no volume", "export the body, not a sheet")
    repairs.append(f"{counted((~keep).sum(), 'triangle')} of parts without volume dropped, one at {first(points, triangles, ~keep)}")
    return points, triangles[keep], np.unique(shell[keep], return_inverse=True)[1].ravel()


def first(points: np.ndarray, triangles: np.ndarray, mask: np.ndarray) -> str:
    """The position of the first masked triangle."""
    return spot(points[triangles[int(np.argmax(mask))]].mean(axis=0))


def spot(point: np.ndarray) -> str:
    """A position as text."""
    return "(" + ", ".join(f"{x:.6g}" for x in point) + ")"


def counted(count: int, word: str) -> str:
    """A number with its noun."""
    return f"{count} {word}{'' if count == 1 else 's'}"
