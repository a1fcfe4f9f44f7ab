"""The body of a run as a pyvista grid or a meshio mesh."""

from typing import Any

import numpy

from ._extras import extra

#: Number of nodes of a cell → its VTK type and its name in meshio
KINDS = {4: (10, "tetra"), 10: (24, "tetra10")}


def at(fields: dict[str, numpy.ndarray], k: int) -> dict[str, numpy.ndarray]:
    """Returns copies of the fields at one time; fields of one component have no axis for components."""
    return {name: (values[k, :, 0] if values.shape[2] == 1 else values[k]).copy() for name, values in fields.items()}


def pyvista_grid(run: Any, k: int) -> Any:
    """Returns the body with the fields of one time, displaced if its displacements were recorded."""
    pyvista = extra("pyvista", "view")
    cells = run.cells.astype(numpy.int64)
    kind = KINDS[cells.shape[1]][0]
    listed = numpy.hstack([numpy.full((len(cells), 1), cells.shape[1]), cells]).ravel()
    points = run.nodes + (run.fields["displacement_m"][k] if "displacement_m" in run.fields else 0.0)
    grid = pyvista.UnstructuredGrid(listed, numpy.full(len(cells), kind, dtype=numpy.uint8), points)
    for name, values in at(run.fields, k).items():
        grid.point_data[name] = values
    for name, values in at(run.cell_fields, k).items():
        grid.cell_data[name] = values
    return grid


def meshio_mesh(run: Any, k: int) -> Any:
    """Returns the body at rest with the fields of one time as a mesh, which meshio can write in its formats."""
    meshio = extra("meshio", "mesh")
    name = KINDS[run.cells.shape[1]][1]
    of_cells = {field: [values] for field, values in at(run.cell_fields, k).items()}
    # Its formats do not support unsigned integers
    return meshio.Mesh(run.nodes.copy(), [(name, run.cells.astype(numpy.int64))], point_data=at(run.fields, k), cell_data=of_cells)
