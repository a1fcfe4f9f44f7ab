"""CAD of the octant of a hollow sphere."""

import math

import gmsh

from meshgen.errors import BadRequest
from meshgen.geometry import Geometry, plane_rules, point_on, sort_faces


def build(params: dict) -> Geometry:
    """Build the octant in the current gmsh model. `params` in mm, as named in body.toml."""
    inner, outer = params["inner_radius"], params["outer_radius"]
    if inner >= outer:
        raise BadRequest("thick_sphere: inner_radius must be smaller than outer_radius", "change the parameters of the body")
    balls = [gmsh.model.occ.addSphere(0, 0, 0, r, angle1=0, angle2=math.pi / 2, angle3=math.pi / 2) for r in (inner, outer)]
    (_, volume), = gmsh.model.occ.cut([(3, balls[1])], [(3, balls[0])])[0]
    gmsh.model.occ.synchronize()
    rules = plane_rules({"x0": (0, 0.0), "y0": (1, 0.0), "z0": (2, 0.0)})
    rules.append(("inner", lambda face: math.hypot(*point_on(face)) < (inner + outer) / 2))
    regions = sort_faces([volume], rules, rest="outer")
    features = {name: regions[name][1] for name in ("inner", "outer")}
    return Geometry([volume], regions | {"body": (3, [volume])}, features=features)
