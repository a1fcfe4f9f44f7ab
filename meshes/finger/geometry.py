"""Parametric CAD of the finger: an extruded profile in the x-z plane, its end face filleted."""

import gmsh

from meshgen.errors import BadRequest
from meshgen.geometry import SNAP, Geometry, lies_between, lies_in_plane, plane_rules, sort_faces


def build(params: dict) -> Geometry:
    """Build the finger in the current gmsh model. `params` in mm, as named in body.toml."""
    check(params)
    volume = extrude_profile(params)
    volume = round_tip(volume, params)
    length, height = params["length"], params["height"]

    def in_notch(face):
        return any(lies_between(face, 0, a, b) for a, b in notch_spans(params)) and lies_between(
            face, 2, 0.0, params["notch_depth"]
        )

    planes = {"root": (0, 0.0), "tip": (0, length), "palm": (2, 0.0), "back": (2, height)}
    rules = plane_rules(planes) + [("notches", in_notch)]
    regions = sort_faces([volume], rules, rest="skin")
    rounding = [f for f in regions["skin"][1] if lies_between(f, 0, length - params["tip_radius"], length)]
    cable = cable_path(params)
    features = {"tip": regions["tip"][1] + rounding, "guides": cable["guides"]}
    if "notches" in regions:
        features["notches"] = regions["notches"][1]
    regions["body"] = (3, [volume])
    return Geometry([volume], regions, {"cable": cable}, features)


def check(p: dict) -> None:
    """Refuse parameters that describe no finger."""
    phalanx = phalanx_length(p)
    limits = [
        (p["notch_depth"] < p["height"], "notch_depth must be smaller than height: the back joins the phalanges"),
        (2 * p["notch_fillet"] <= p["notch_width"] + SNAP, "notch_fillet must not exceed half of notch_width"),
        (p["notch_fillet"] < p["notch_depth"], "notch_fillet must be smaller than notch_depth"),
        (phalanx > 0, "the notches leave no room: (phalanges - 1) * notch_width must be smaller than length"),
        (p["tip_radius"] < phalanx, f"tip_radius must be smaller than a phalanx ({phalanx:g} mm)"),
        (2 * p["tip_radius"] < p["width"], "tip_radius must be smaller than half of width"),
        (2 * p["tip_radius"] < p["height"], "tip_radius must be smaller than half of height"),
        (p["cable_height"] < p["height"], "cable_height must be smaller than height"),
        (2 * p["guide_inset"] < phalanx, f"guide_inset must be smaller than half of a phalanx ({phalanx:g} mm)"),
        (
            p["guide_inset"] + p["guide_tip_inset"] < phalanx,
            f"guide_inset + guide_tip_inset must be smaller than a phalanx ({phalanx:g} mm)",
        ),
    ]
    for holds, message in limits:
        if not holds:
            raise BadRequest(f"finger: {message}", "change the parameters of the body")


def phalanx_length(p: dict) -> float:
    """Length of one phalanx [mm]."""
    return (p["length"] - (p["phalanges"] - 1) * p["notch_width"]) / p["phalanges"]


def notch_spans(p: dict) -> list:
    """x ranges (from, to) of the notches [mm]."""
    pitch = phalanx_length(p) + p["notch_width"]
    return [(pitch * i - p["notch_width"], pitch * i) for i in range(1, int(p["phalanges"]))]


def cable_path(p: dict) -> dict:
    """Two guide points per phalanx, and the pull point in front of the root [mm]."""
    phalanx, pitch = phalanx_length(p), phalanx_length(p) + p["notch_width"]
    xs = []
    for i in range(int(p["phalanges"])):
        xs += [pitch * i + p["guide_inset"], pitch * i + phalanx - p["guide_inset"]]
    xs[-1] = p["length"] - p["guide_tip_inset"]
    y, z = p["width"] / 2, p["cable_height"]
    return {
        "guides": [[x, y, z] for x in xs],
        "pull_point": [-p["pull_distance"], y, z],
        "guide_radius": p["guide_radius"],
    }


def extrude_profile(p: dict) -> int:
    """The profile with its notches in the plane y = 0, extruded by the width. Returns the volume's tag."""
    occ = gmsh.model.occ
    curves, first = [], occ.addPoint(0, 0, 0)
    here = [first]

    def line_to(point):
        curves.append(occ.addLine(here[0], point))
        here[0] = point

    def arc_to(point, centre):
        curves.append(occ.addCircleArc(here[0], occ.addPoint(*centre), point))
        here[0] = point

    depth, r = p["notch_depth"], p["notch_fillet"]
    for a, b in notch_spans(p):
        line_to(occ.addPoint(a, 0, 0))
        if r <= SNAP:
            line_to(occ.addPoint(a, 0, depth))
            line_to(occ.addPoint(b, 0, depth))
        else:
            line_to(occ.addPoint(a, 0, depth - r))
            arc_to(occ.addPoint(a + r, 0, depth), (a + r, 0, depth - r))
            if b - a > 2 * r + SNAP:
                line_to(occ.addPoint(b - r, 0, depth))
            arc_to(occ.addPoint(b, 0, depth - r), (b - r, 0, depth - r))
        line_to(occ.addPoint(b, 0, 0))
    line_to(occ.addPoint(p["length"], 0, 0))
    line_to(occ.addPoint(p["length"], 0, p["height"]))
    line_to(occ.addPoint(0, 0, p["height"]))
    line_to(first)
    face = occ.addPlaneSurface([occ.addCurveLoop(curves)])
    extruded = occ.extrude([(2, face)], 0, p["width"], 0)
    occ.synchronize()
    return next(tag for dim, tag in extruded if dim == 3)


def round_tip(volume: int, p: dict) -> int:
    """Fillet the four edges of the end face together, so that their corners are blended."""
    if p["tip_radius"] <= SNAP:
        return volume
    faces = [tag for _, tag in gmsh.model.getBoundary([(3, volume)], oriented=False)]
    end = next(face for face in faces if lies_in_plane(face, 0, p["length"]))
    edges = [tag for _, tag in gmsh.model.getBoundary([(2, end)], oriented=False)]
    filleted = gmsh.model.occ.fillet([volume], edges, [p["tip_radius"]])
    gmsh.model.occ.synchronize()
    return filleted[0][1]
