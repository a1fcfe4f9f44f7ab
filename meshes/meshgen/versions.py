"""Versions of the packages a mesh depends on."""

from importlib import metadata

PACKAGES = ("gmsh", "cgal", "meshio", "numpy")


def versions() -> dict:
    """Package -> installed version, or null."""
    found = {}
    for name in PACKAGES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = None
    return found
