"""Installed and missing packages, with the command that installs them."""

import importlib
import re

from .versions import versions

MODULES = {"gmsh": "gmsh", "meshio": "meshio", "numpy": "numpy", "cgal": "CGAL.CGAL_Mesh_3"}
# Debian packages of the shared libraries that the gmsh wheel needs and a bare system lacks.
LIBRARIES = {
    "libGLU.so": "libglu1-mesa",
    "libGL.so": "libgl1",
    "libXrender.so": "libxrender1",
    "libXcursor.so": "libxcursor1",
    "libXfixes.so": "libxfixes3",
    "libXext.so": "libxext6",
    "libXft.so": "libxft2",
    "libfontconfig.so": "libfontconfig1",
    "libXinerama.so": "libxinerama1",
    "libX11.so": "libx11-6",
    "libgomp.so": "libgomp1",
}
DEBIAN = "apt-get install -y --no-install-recommends libglu1-mesa libgl1 libxcursor1 libxft2 libxinerama1 libgomp1"
PIP = "python -m pip install -r meshes/meshgen/requirements.txt"


def examine() -> dict:
    """Import every package. `ok` tells whether gmsh meshes can be made; `errors` and `fix` state what is missing."""
    errors, fix = {}, set()
    for name, module in MODULES.items():
        try:
            importlib.import_module(module)
        except (ImportError, OSError) as error:
            library = re.match(r"(lib\w+\.so)\S*: cannot open", str(error))
            errors[name] = {"error": str(error), "missing_library": library and library.group(1)}
            fix.add(DEBIAN if library else PIP)
            if library:
                errors[name]["debian_package"] = LIBRARIES.get(library.group(1))
    return {
        "ok": not errors.keys() & {"gmsh", "numpy", "meshio"},
        "versions": versions(),
        "errors": errors,
        "fix": sorted(fix),
    }
