"""CAD of a bending actuator with a row of air chambers (PneuNet): bellows on a base that stretches less."""

import gmsh

from meshgen.errors import BadRequest
from meshgen.geometry import Geometry, lies_between, plane_rules, sort_faces


def build(params: dict) -> Geometry:
    """Build the actuator in the current gmsh model. `params` in mm, as named in body.toml."""
    check(params)
    occ = gmsh.model.occ
    wall, base = params["wall"], params["base"]
    width = params["chamber_width"] + 2 * wall
    spans = chamber_spans(params)
    length = spans[-1][1] + wall + params["end"]
    floor = base + params["channel_height"] + wall
    plate = occ.addBox(0, 0, 0, length, width, floor)
    height = base + params["chamber_height"] + wall
    bellows = [occ.addBox(a - wall, 0, 0, b - a + 2 * wall, width, height) for a, b in spans]
    solid = occ.fuse([(3, plate)], [(3, tag) for tag in bellows])[0]
    hollows = [occ.addBox(a, wall, base, b - a, params["chamber_width"], params["chamber_height"]) for a, b in spans]
    (first, _), (_, last) = spans[0], spans[-1]
    middle = (width - params["channel_width"]) / 2
    channel = occ.addBox(first, middle, base, last - first, params["channel_width"], params["channel_height"])
    air = occ.fuse([(3, channel)], [(3, tag) for tag in hollows])[0]
    (_, volume), = occ.cut(solid, air)[0]
    occ.removeAllDuplicates()
    occ.synchronize()
    # Every outer face reaches a side; the walls of the hollow do not.
    rules = plane_rules({"root": (0, 0.0), "tip": (0, length), "bottom": (2, 0.0)})
    rules.append(("cavity", lambda face: lies_between(face, 1, wall, width - wall)))
    regions = sort_faces([volume], rules, rest="skin")
    features = {"cavity": regions["cavity"][1]}
    return Geometry([volume], regions | {"body": (3, [volume])}, features=features)


def check(p: dict) -> None:
    """Refuse parameters that describe no actuator."""
    limits = [
        (p["channel_width"] < p["chamber_width"], "channel_width must be smaller than chamber_width"),
        (
            p["channel_height"] + p["wall"] < p["chamber_height"],
            "channel_height + wall must be smaller than chamber_height: the bellows rise above the channel",
        ),
    ]
    for holds, message in limits:
        if not holds:
            raise BadRequest(f"pneunet: {message}", "change the parameters of the body")


def chamber_spans(p: dict) -> list:
    """x ranges (from, to) of the hollow chambers [mm]."""
    pitch = p["chamber_length"] + 2 * p["wall"] + p["gap"]
    start = p["end"] + p["wall"]
    return [(start + pitch * i, start + pitch * i + p["chamber_length"]) for i in range(int(p["chambers"]))]
