"""From a request to a mesh file and its manifest."""

import time

from . import bodies, gmsh_driver, importer, manifest, surface_mesh, write
from .request import Request


def run(request: Request) -> dict:
    """Make the requested mesh, write it and its manifest; returns the manifest."""
    start = time.monotonic()
    mesh, volume, paths, notes = generate(request)
    result = manifest.build(request, mesh, volume, paths, notes)
    write.write(mesh, request.output)
    result["wall_s"] = round(time.monotonic() - start, 3)
    manifest.save(result, request.output)
    return result


def generate(request: Request) -> tuple:
    """Mesh a CAD or surface: (mesh, its volume [m³], paths [mm], notes)."""
    if request.is_surface():
        return surface_mesh.mesh(request)
    with gmsh_driver.session(request.seed):
        if request.body == "file":
            geometry = importer.read_geometry(request)
        else:
            geometry = bodies.build(request.body, request.parameters)
        volume, solids = gmsh_driver.cad_volume(geometry), gmsh_driver.solid_volumes(geometry)
        if request.generator == "cgal":
            from . import cgal_driver as driver
        else:
            driver = gmsh_driver
        mesh, notes = driver.mesh(request, geometry, volume)
        told = {"volumes_cad_m3": solids, "dropped": geometry.dropped}
        return mesh, volume, geometry.paths, notes | {key: value for key, value in told.items() if value}
