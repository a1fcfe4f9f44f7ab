"""CAD of the cylinder."""

import gmsh

from meshgen.geometry import Geometry, plane_rules, sort_faces


def build(params: dict) -> Geometry:
    """Build the cylinder in the current gmsh model. `params` in mm, as named in body.toml."""
    length = params["length"]
    volume = gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, length, params["radius"])
    gmsh.model.occ.synchronize()
    regions = sort_faces([volume], plane_rules({"bottom": (2, 0.0), "top": (2, length)}), rest="side")
    features = {name: faces for name, (_, faces) in regions.items()}
    return Geometry([volume], regions | {"body": (3, [volume])}, features=features)
