"""A mesh file as it is: points, blocks of cells in gmsh's numbering of kinds and nodes, sets."""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class Blocks:
    """points (n, 3); cells: (gmsh's kind, rows (k, m) of nodes); sets: name -> one mask per block; node_sets: name -> nodes; notes: parts of the file that are left out;
    node_numbers, numbers: the numbers of the points, and of the cells of each block, in the file, or as its readers count them.

    A node set and a cell set of the same name are two sets."""

    points: np.ndarray
    cells: list
    sets: dict = field(default_factory=dict)
    node_sets: dict = field(default_factory=dict)
    notes: list = field(default_factory=list)
    node_numbers: np.ndarray | None = None
    numbers: list | None = None
