"""CAD of the block."""

import gmsh

from meshgen.geometry import Geometry, plane_rules, sort_faces


def build(params: dict) -> Geometry:
    """Build the block in the current gmsh model. `params` in mm, as named in body.toml."""
    sizes = [params["lx"], params["ly"], params["lz"]]
    volume = gmsh.model.occ.addBox(0, 0, 0, *sizes)
    gmsh.model.occ.synchronize()
    planes = {f"{axis}{end}": (i, at) for i, axis in enumerate("xyz") for end, at in (("min", 0.0), ("max", sizes[i]))}
    regions = sort_faces([volume], plane_rules(planes), rest="other")
    features = {name: faces for name, (_, faces) in regions.items()}
    return Geometry([volume], regions | {"body": (3, [volume])}, features=features)
