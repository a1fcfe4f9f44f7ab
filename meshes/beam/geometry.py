"""CAD of the beam."""

import gmsh

from meshgen.geometry import Geometry, plane_rules, sort_faces


def build(params: dict) -> Geometry:
    """Build the beam in the current gmsh model. `params` in mm, as named in body.toml."""
    length = params["length"]
    volume = gmsh.model.occ.addBox(0, 0, 0, length, params["width"], params["height"])
    gmsh.model.occ.synchronize()
    regions = sort_faces([volume], plane_rules({"root": (0, 0.0), "tip": (0, length)}), rest="sides")
    features = {name: regions[name][1] for name in ("root", "tip")}
    return Geometry([volume], regions | {"body": (3, [volume])}, features=features)
