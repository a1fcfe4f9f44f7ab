"""From a request to a mesh file and its manifest."""

import time

from . import bodies, gmsh_driver, manifest, write
from .request import Request


def run(request: Request) -> dict:
    """Make the requested mesh, write it and its manifest; returns the manifest."""
    start = time.monotonic()
    with gmsh_driver.session(request.seed):
        geometry = bodies.build(request.body, request.parameters)
        volume = gmsh_driver.cad_volume(geometry)
        mesh, notes = gmsh_driver.mesh(request, geometry, volume)
    result = manifest.build(request, mesh, volume, geometry.paths, notes)
    write.write(mesh, request.output)
    result["wall_s"] = round(time.monotonic() - start, 3)
    manifest.save(result, request.output)
    return result
