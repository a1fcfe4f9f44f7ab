"""CAD of an octant of the tensile specimen between its grips, cut at the end of the narrow part.

Two arcs, concave and convex, tangent to the straight edges and to each other, lead from the narrow part
to the end: with R and r their radii and t the angle at their junction,
(R + r)(1 - cos t) = (grip_width - gauge_width) / 2, over a length of (R + r) sin t.
"""

import math

import gmsh

from meshgen.errors import BadRequest
from meshgen.geometry import SNAP, Geometry, boundary_faces, lies_between, plane_rules, sort_faces


def build(params: dict) -> Geometry:
    """Build the octant in the current gmsh model. `params` in mm, as named in body.toml."""
    occ = gmsh.model.occ
    big, small, top = params["inner_radius"], params["outer_radius"], params["thickness"] / 2
    gauge, grip = params["gauge_length"] / 2, params["grip_distance"] / 2
    narrow, wide = params["gauge_width"] / 2, params["grip_width"] / 2
    cosine = 1 - (wide - narrow) / (big + small)
    if not 0 < cosine < 1:
        raise BadRequest(
            "dumbbell_octant: the two radii must bridge the step from gauge_width to grip_width",
            "grip_width must exceed gauge_width by less than 2 (inner_radius + outer_radius)",
        )
    if grip <= gauge:
        raise BadRequest(
            "dumbbell_octant: grip_distance must be larger than gauge_length", "change the parameters of the body"
        )
    sine = math.sqrt(1 - cosine**2)
    meet = (gauge + big * sine, narrow + big * (1 - cosine))
    shoulder = gauge + (big + small) * sine
    far = max(shoulder, grip) + wide
    points = [(0, 0), (far, 0), (far, wide), (shoulder, wide), meet, (gauge, narrow), (0, narrow)]
    tags = [occ.addPoint(x, y, 0) for x, y in points]
    lines = {i: (tags[i], tags[(i + 1) % len(tags)]) for i in range(len(tags))}
    centres = {3: (shoulder, wide - small), 4: (gauge, narrow + big)}
    curves = [
        occ.addCircleArc(a, occ.addPoint(*centres[i], 0), b) if i in centres else occ.addLine(a, b)
        for i, (a, b) in lines.items()
    ]
    outline = occ.addPlaneSurface([occ.addCurveLoop(curves)])
    (_, solid), = [pair for pair in occ.extrude([(2, outline)], 0, 0, top) if pair[0] == 3]
    box = occ.addBox(0, -wide, -top, grip, 3 * wide, 3 * top)
    occ.intersect([(3, solid)], [(3, box)])
    plane = occ.addRectangle(-2 * top, -2 * wide, gauge, 5 * top, 5 * wide)
    occ.rotate([(2, plane)], 0, 0, gauge, 0, 1, 0, math.pi / 2)
    occ.translate([(2, plane)], gauge, 0, -gauge)
    occ.fragment(gmsh.model.occ.getEntities(3), [(2, plane)])
    occ.synchronize()
    loose = [pair for pair in gmsh.model.getEntities(2) if not len(gmsh.model.getAdjacencies(*pair)[0])]
    occ.remove(loose, recursive=True)
    occ.synchronize()
    volumes = [tag for _, tag in gmsh.model.getEntities(3)]
    rules = plane_rules({"x0": (0, 0.0), "y0": (1, 0.0), "z0": (2, 0.0), "grip": (0, grip)})
    regions = sort_faces(volumes, rules, rest="skin")
    flanks = set(regions["skin"][1])
    inside = [f for f in boundary_faces(volumes) if f in flanks and lies_between(f, 0, 0, gauge)]
    narrow_part = [v for v in volumes if occ.getCenterOfMass(3, v)[0] < gauge + SNAP]
    regions |= {"body": (3, volumes), "gauge": (3, narrow_part)}
    return Geometry(volumes, regions, features={"gauge": inside})
