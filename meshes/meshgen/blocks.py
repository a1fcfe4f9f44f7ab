"""A mesh file as it is: points, blocks of cells in gmsh's numbering of kinds and nodes, sets."""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class Blocks:
    """points (n, 3); cells: (gmsh's kind, rows (k, m) of nodes); sets: name -> one mask per block; node_sets: name -> nodes; notes: what of the file is left out;
    node_numbers, numbers: those that the file gives the points, and the cells of each block, or in which its readers count them.

    A set of nodes and one of cells may have the same name, and are two sets then."""

    points: np.ndarray
    cells: list
    sets: dict = field(default_factory=dict)
    node_sets: dict = field(default_factory=dict)
    notes: list = field(default_factory=list)
    node_numbers: np.ndarray | None = None
    numbers: list | None = None
