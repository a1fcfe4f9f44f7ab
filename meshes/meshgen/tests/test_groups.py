"""Groups and values of mesh files as regions, nodes with any numbers, and files whose content does not match their extension."""

from pathlib import Path

import gmsh
import meshio
import numpy as np

from meshgen import convert
from meshgen.blocks import Blocks
from meshgen.errors import BadRequest

from .common import Case
from .test_conversion import CUBE, TETS

TRIANGLES = np.array([[0, 2, 1], [0, 3, 2]])


def universal(groups: dict) -> str:
    """A universal file with TETS, labelled from 11 on, and TRIANGLES, from 21 on, of one property and several materials, and with groups of elements."""
    record = lambda *numbers: "".join(f"{number:10}" for number in numbers) + "\n"  # noqa: E731
    nodes = "".join(record(i, 1, 1, 11) + "".join(f"{x:25.16E}" for x in point) + "\n" for i, point in enumerate(CUBE, 1))
    rows = [(11 + i, 111, material, row) for i, (material, row) in enumerate(zip((1, 2, 2, 3, 0), TETS))]
    rows += [(21 + i, 91, 1, row) for i, row in enumerate(TRIANGLES)]
    elements = "".join(record(label, kind, 5, material, 7, len(row)) + record(*(row + 1)) for label, kind, material, row in rows)
    text = ""
    for number, (name, labels) in enumerate(groups.items(), 1):
        words = [word for label in labels for word in (8, label, 0, 0)]
        text += record(number, *[0] * 6, len(labels)) + name + "\n" + "".join(record(*words[i : i + 8]) for i in range(0, len(words), 8))
    parts = [(2411, nodes), (2412, elements), *([(2467, text)] if groups else [])]
    return "".join(f"    -1\n{number:6}\n{lines}    -1\n" for number, lines in parts)


class Groups(Case):
    def read(self, file: str, format: str) -> Blocks:
        return convert.read(Path(self.path(file)), format)

    def stored(self, file: str, format: str, points: np.ndarray = CUBE, **data) -> Blocks:
        """Read two facets and five cells that meshio wrote, with data of them."""
        meshio.write(self.path(file), meshio.Mesh(points, [("triangle", TRIANGLES), ("tetra", TETS)], cell_data=data))
        return self.read(file, format)

    def test_numbers_of_nodes(self):
        """Nodes have any numbers in any order, and groups of one name are one."""
        tags, model = np.array([30, 7, 12, 5, 21, 8, 40, 3]), gmsh.model
        gmsh.initialize([], False, False)
        gmsh.option.setNumber("General.Terminal", 0)
        for dim, tag in ((3, 1), (3, 2), (2, 1)):
            model.addDiscreteEntity(dim, tag)
        model.mesh.addNodes(3, 1, tags, CUBE.ravel())
        for entity, kind, rows in ((1, 4, TETS[:2]), (2, 4, TETS[2:]), (1, 2, TRIANGLES)):
            model.mesh.addElementsByType(entity, kind, [], tags[rows].ravel())
        for dim, entities, name in ((3, [1], "part"), (2, [1], "part"), (3, [1, 2], "all")):
            model.setPhysicalName(dim, model.addPhysicalGroup(dim, entities), name)
        for ending in ("unv", "med"):
            gmsh.write(self.path(f"a.{ending}"))
        gmsh.finalize()
        for ending in ("unv", "med"):
            blocks = self.read(f"a.{ending}", "gmsh")
            found = {name: set() for name in blocks.sets}
            for name, masks in blocks.sets.items():
                for (_, rows), mask in zip(blocks.cells, masks):
                    found[name] |= {frozenset(map(tuple, x)) for x in blocks.points[rows[mask]].tolist()}
            wanted = {"part": [*TETS[:2], *TRIANGLES], "all": TETS}
            self.assertEqual(found, {name: {frozenset(map(tuple, CUBE[row].tolist())) for row in rows} for name, rows in wanted.items()}, ending)

    def test_groups_of_universal_files(self):
        """Groups of some cells of a part, and of nodes, have these cells and nodes, in every data set for groups."""
        model = gmsh.model
        gmsh.initialize([], False, False)
        gmsh.option.setNumber("General.Terminal", 0)
        model.addDiscreteEntity(3, 1)
        model.mesh.addNodes(3, 1, np.arange(1, len(CUBE) + 1), CUBE.ravel())
        model.mesh.addElementsByType(1, 4, np.arange(11, 11 + len(TETS)), (TETS + 1).ravel())
        model.addPhysicalGroup(3, [1])
        gmsh.write(self.path("a.unv"))
        gmsh.finalize()
        text = Path(self.path("a.unv")).read_text()
        number = self.read("a.unv", "gmsh").numbers[0]
        cells, nodes = number[[1, 3, 4]].tolist(), [2, 5]
        for label, after in ((2467, [0, 0]), (2477, [0, 0]), (2452, [0, 0]), (2430, [])):
            rows = [word for kind, numbers in ((8, cells), (7, nodes)) for one in numbers for word in (kind, one, *after)]
            body = "\n".join(" ".join(map(str, rows[at : at + 8])) for at in range(0, len(rows), 8))
            group = f"    -1\n  {label}\n 1 0 0 0 0 0 0 5\nmy group\n{body}\n    -1\n"
            Path(self.path("b.unv")).write_text(text[: text.index("    -1\n  2477")] + group if "  2477\n" in text else text + group)
            found = self.read("b.unv", "gmsh")
            members = {name: sorted(np.concatenate(found.numbers)[np.concatenate(masks)]) for name, masks in found.sets.items()}
            self.assertEqual(members, {"my group": cells}, label)
            self.assertEqual({name: (own + 1).tolist() for name, own in found.node_sets.items()}, {"my group": nodes}, label)
        Path(self.path("b.unv")).write_text(text + "    -1\n  2467\n 1 0 0 0 0 0 0 five\nmy group\n    -1\n")
        with self.assertRaisesRegex(BadRequest, "lines of groups from '1 0 0 0 0 0 0 five' on are not understood"):
            self.read("b.unv", "gmsh")

    def members(self, text: str) -> tuple:
        """Labels of the elements of each group in a universal file, and the notes."""
        Path(self.path("a.unv")).write_text(text)
        blocks = self.read("a.unv", "gmsh")
        return {name: sorted(np.concatenate(blocks.numbers)[np.concatenate(masks)]) for name, masks in blocks.sets.items()}, blocks.notes

    def test_materials_and_shared_elements_of_universal_files(self):
        """Materials are groups where the file has no others, also within one property; groups may share elements, and list some that are not in the file."""
        groups = {"one": [11], "Höhle": [11, 12], "mixed": [13, 21], "none": [], "far": [99, 14]}
        found, notes = self.members(universal(groups))
        self.assertEqual(found, {"one": [11], "Höhle": [11, 12], "mixed": [13, 21], "far": [14]})
        self.assertEqual(notes, ["1 of 2 members of group far are no nodes or elements that are read"])
        self.assertEqual(self.members(universal({}))[0], {"cells_1": [11], "cells_2": [12, 13], "cells_3": [14], "facets_1": [21, 22]})
        text = universal({})
        self.assertIn("       111         5", text)
        with self.assertRaisesRegex(BadRequest, "lines of elements from .* on are not understood"):
            self.members(text.replace("       111         5", "       111         x", 1))
        Path(self.path("b.unv")).write_bytes(universal(groups).encode("latin-1"))
        with self.assertRaisesRegex(BadRequest, "the name of group 2 is no text in UTF-8"):
            self.read("b.unv", "gmsh")

    def test_physical_numbers_of_msh_1(self):
        """Each element has its own physical number, also within one part."""
        nodes = [f"{i} {x} {y} {z}" for i, (x, y, z) in enumerate(CUBE.tolist(), 1)]
        rows = [(kind, group, corners + 1) for kind, group, corners in ((2, 7, TRIANGLES[0]), (2, 0, TRIANGLES[1]))]
        rows += [(4, 11 if i < 2 else 12, corners + 1) for i, corners in enumerate(TETS)]
        cells = [f"{i} {kind} {group} 1 {len(corners)} {' '.join(map(str, corners))}" for i, (kind, group, corners) in enumerate(rows, 1)]
        text = ["$NOD", str(len(nodes)), *nodes, "$ENDNOD", "$ELM", str(len(cells)), *cells, "$ENDELM", ""]
        Path(self.path("a.msh")).write_text("\n".join(text))
        found = self.read("a.msh", "gmsh")
        members = {name: sorted(np.concatenate(found.numbers)[np.concatenate(masks)]) for name, masks in found.sets.items()}
        self.assertEqual(members, {"facets_7": [1], "cells_11": [3, 4], "cells_12": list(range(5, 3 + len(TETS)))})

    def test_values(self):
        """Whole numbers of the cells are regions, not those of facets alone, nor more than 64 different ones."""
        self.assertEqual(set(self.stored("a.vtu", "vtu", part=[[1, 2], [3, 3, 4, 4, 3]]).sets), {"part_3", "part_4"})
        self.assertEqual(self.stored("a.vtu", "vtu", part=[[1, 2], [3, 3, 3, 3, 3]]).sets, {})
        for count, regions in ((64, 64), (65, 0)):
            mesh = meshio.Mesh(CUBE, [("tetra", np.tile(TETS, (13, 1)))], cell_data={"part": [np.arange(65) % count]})
            meshio.write(self.path("a.vtu"), mesh)
            self.assertEqual(len(self.read("a.vtu", "vtu").sets), regions)

    def test_references(self):
        """Those of Medit are regions of cells and of facets, but zero means none. Binary files may have the ending of the others."""
        data = {"medit:ref": [np.array([0, 7]), np.array([0, 0, 2, 2, 5])]}
        expected = {"facets_7": 1, "cells_2": 2, "cells_5": 1}
        for name, other in (("a.mesh", "b.mesh"), ("a.meshb", "b.meshb"), ("a.meshb", "c.mesh")):
            self.stored(name, "medit", **data)
            Path(self.path(name)).rename(self.path(other))
            blocks = self.read(other, "medit")
            self.assertEqual({name: sum(int(mask.sum()) for mask in masks) for name, masks in blocks.sets.items()}, expected)
            np.testing.assert_allclose(blocks.points, CUBE)

    def test_points_of_a_plane(self):
        with self.assertRaises(BadRequest) as caught:
            meshio.write(self.path("flat.mesh"), meshio.Mesh(CUBE[:, :2], {"triangle": TRIANGLES}))
            self.read("flat.mesh", "medit")
        self.assertIn("flat.mesh has points of dimension 2", caught.exception.error)
