"""CAD of the tensile specimen: an extruded outline, cut into ends, transitions and gauge.

The outline rises from the narrow part to the end by two arcs, concave and convex, tangent to the
straight edges and to each other: with R and r their radii and t the angle at their junction,
(R + r)(1 - cos t) = (grip_width - gauge_width) / 2, over a length of (R + r) sin t.
"""

import math

import gmsh

from meshgen.errors import BadRequest
from meshgen.geometry import SNAP, Geometry, boundary_faces, lies_between, plane_rules, sort_faces


def build(params: dict) -> Geometry:
    """Build the specimen in the current gmsh model. `params` in mm, as named in body.toml."""
    end, gauge, grip = params["length"] / 2, params["gauge_length"] / 2, params["grip_distance"] / 2
    angle = junction_angle(params)
    check(params, angle)
    extrude_outline(params, angle)
    volumes = cut_across([-grip, -gauge, gauge, grip], params)

    def between(low, high):
        return [v for v in volumes if low - SNAP < centre_x(v) < high + SNAP]

    regions = sort_faces(volumes, plane_rules({"end_a": (0, -end), "end_b": (0, end)}), rest="skin")
    narrow = [face for face in boundary_faces(volumes) if lies_between(face, 0, -gauge, gauge)]
    regions |= {
        "body": (3, volumes),
        "gauge": (3, between(-gauge, gauge)),
        "grip_a": (3, between(-end, -grip)),
        "grip_b": (3, between(grip, end)),
    }
    return Geometry(volumes, regions, features={"gauge": narrow})


def junction_angle(p: dict) -> float:
    """Angle of both arcs, from the straight edge to their junction [rad]."""
    rise = (p["grip_width"] - p["gauge_width"]) / 2
    cosine = 1 - rise / (p["inner_radius"] + p["outer_radius"])
    if not 0 < cosine < 1:
        raise BadRequest(
            "dumbbell: the two radii must bridge the step from gauge_width to grip_width",
            "grip_width must exceed gauge_width by less than 2 (inner_radius + outer_radius)",
        )
    return math.acos(cosine)


def check(p: dict, angle: float) -> None:
    """Refuse parameters that describe no specimen."""
    shoulder = p["gauge_length"] + 2 * (p["inner_radius"] + p["outer_radius"]) * math.sin(angle)
    limits = [
        (shoulder < p["length"], f"the transitions end {shoulder:.2f} mm apart, beyond length"),
        (p["grip_distance"] < p["length"], "grip_distance must be smaller than length"),
        (p["grip_distance"] > p["gauge_length"], "grip_distance must be larger than gauge_length"),
    ]
    for holds, message in limits:
        if not holds:
            raise BadRequest(f"dumbbell: {message}", "change the parameters of the body")


def extrude_outline(p: dict, angle: float) -> None:
    """The outline in the plane z = -thickness/2, extruded by the thickness."""
    occ = gmsh.model.occ
    big, small, bottom = p["inner_radius"], p["outer_radius"], -p["thickness"] / 2
    gauge, narrow, end, wide = p["gauge_length"] / 2, p["gauge_width"] / 2, p["length"] / 2, p["grip_width"] / 2
    meet = (gauge + big * math.sin(angle), narrow + big * (1 - math.cos(angle)))
    shoulder = gauge + (big + small) * math.sin(angle)
    # One quadrant from the narrow part to the end, then mirrored into the others, counter-clockwise.
    quadrant = [(gauge, narrow), meet, (shoulder, wide), (end, wide)]
    centres = {(0, 1): (gauge, narrow + big), (1, 2): (shoulder, wide - small)}
    points, arcs = [], []
    for sx, sy, backwards in ((1, 1, True), (-1, 1, False), (-1, -1, True), (1, -1, False)):
        order = [3, 2, 1, 0] if backwards else [0, 1, 2, 3]
        points += [(sx * quadrant[i][0], sy * quadrant[i][1]) for i in order]
        pairs = [tuple(sorted(pair)) for pair in zip(order, order[1:])]
        arcs += [(sx * centres[q][0], sy * centres[q][1]) if q in centres else None for q in pairs] + [None]
    tags = [occ.addPoint(x, y, bottom) for x, y in points]
    curves = []
    for i, centre in enumerate(arcs):
        a, b = tags[i], tags[(i + 1) % len(tags)]
        curves.append(occ.addCircleArc(a, occ.addPoint(*centre, bottom), b) if centre else occ.addLine(a, b))
    face = occ.addPlaneSurface([occ.addCurveLoop(curves)])
    occ.extrude([(2, face)], 0, 0, p["thickness"])
    occ.synchronize()


def cut_across(positions: list, p: dict) -> list:
    """Cut the specimen by planes x = position; returns the tags of the pieces, from left to right."""
    occ = gmsh.model.occ
    wide, thick = 2 * p["grip_width"], 2 * p["thickness"]
    planes = []
    for x in positions:
        plane = occ.addRectangle(-thick / 2, -wide / 2, x, thick, wide)
        occ.rotate([(2, plane)], 0, 0, x, 0, 1, 0, math.pi / 2)
        occ.translate([(2, plane)], x, 0, -x)
        planes.append((2, plane))
    occ.fragment(gmsh.model.getEntities(3), planes)
    occ.synchronize()
    loose = [pair for pair in gmsh.model.getEntities(2) if not len(gmsh.model.getAdjacencies(*pair)[0])]
    occ.remove(loose, recursive=True)
    occ.synchronize()
    return sorted((tag for _, tag in gmsh.model.getEntities(3)), key=centre_x)


def centre_x(volume: int) -> float:
    """x of a volume's centre of mass [mm]."""
    return gmsh.model.occ.getCenterOfMass(3, volume)[0]
