"""Abaqus input with instances, sets of sets and generated nodes: every member is found, or the file is refused."""

from pathlib import Path

import numpy as np

from meshgen import convert
from meshgen.blocks import Blocks
from meshgen.errors import BadRequest

from .common import Case

NODES = "*Node\n 1, 0, 0, 0\n 2, 1, 0, 0\n 3, 0, 1, 0\n 4, 0, 0, 1\n 5, 1, 1, 1\n"
TETS = "*Element, type=C3D4\n 1, 1, 2, 3, 4\n 2, 2, 3, 4, 5\n"
SETS = "*Nset, nset=Root\n 1, 2, 3\n*Elset, elset=all, generate\n 1, 2, 1\n"
PART = f"*Heading\n*Part, name=P\n{NODES}{TETS}{SETS}*End Part\n*Assembly, name=A\n*Instance, name=P-1, part=P\n*End Instance\n"
TWO = PART + "*Instance, name=P-2, part=P\n 0, 0, 5\n*End Instance\n"
END = "*End Assembly\n"


class Abaqus(Case):
    def read(self, text: str) -> Blocks:
        Path(self.path("a.inp")).write_text(text)
        return convert.read(Path(self.path("a.inp")), "abaqus")

    def sizes(self, text: str) -> dict:
        """Members of all sets; cells and facets with their kind."""
        blocks = self.read(text)
        of_cells = {name: {kind: int(m.sum()) for (kind, _), m in zip(blocks.cells, masks) if m.any()} for name, masks in blocks.sets.items()}
        return of_cells | {name: len(nodes) for name, nodes in blocks.node_sets.items()}

    def refuse(self, words: str, text: str) -> None:
        with self.assertRaises(BadRequest) as caught:
            self.read(text)
        self.assertIn(words, caught.exception.error)
        self.assertTrue(caught.exception.hint)

    def test_independent_instances(self):
        alone = f"*Part, name=P\n*End Part\n*Assembly, name=A\n*Instance, name=P-1, part=P\n{NODES}{TETS}{SETS}*End Instance\n"
        blocks = self.read(alone + END)
        self.assertEqual((len(blocks.points), len(blocks.cells[0][1])), (5, 2))
        self.assertEqual(self.sizes(alone + END), {"Root": 3, "all": {4: 2}})
        both = PART + f"*Instance, name=Q-1, part=Q\n 0, 0, 9\n{NODES}{TETS}*End Instance\n{END}"
        both = "*Part, name=Q\n*End Part\n" + both
        blocks = self.read(both)
        self.assertEqual((len(blocks.points), len(blocks.cells[0][1])), (10, 4))
        self.assertEqual(blocks.points[:, 2].max(), 10)
        # A set in one instance of a part is not in the others
        tip = "*Nset, nset=Tip\n 5\n*End Instance\n"
        self.assertEqual(self.sizes(TWO.replace(" 0, 0, 5\n*End Instance\n", f" 0, 0, 5\n{tip}") + END), {"Root": 6, "all": {4: 4}, "Tip": 1})

    def test_sets_of_the_assembly(self):
        text = TWO + "".join(
            [
                "*Nset, nset=clamp, instance=P-1\n Root, 4\n",
                "*Nset, nset=dotted\n P-2.Root, P-2.5, P-1.1\n",
                "*Nset, nset=of_sets\n clamp, dotted\n",
                "*Nset, nset=several, instance=P-1, generate\n 1, 3\n*Nset, nset=several, instance=P-2\n 1\n",
                "*Nset, nset=of_cells, elset=half\n",
                "*Elset, elset=half\n P-1.all\n",
                "*Elset, elset=later\n half, P-2.1\n",
                "*Surface, type=ELEMENT, name=low\n P-1.all, S1\n P-2.2, S4\n later, S2\n",
                "*Surface, name=quoted\n \"P-1\".\"all\", S1\n",
            ]
        )
        expected = {"clamp": 4, "dotted": 5, "of_sets": 4 + 4, "several": 4, "of_cells": 5, "half": {4: 2}, "later": {4: 3}}
        expected |= {"low": {2: 2 + 1 + 3}, "quoted": {2: 2}, "Root": 6, "all": {4: 4}}
        self.assertEqual(self.sizes(text + END), expected)

    def test_a_name_of_the_assembly(self):
        text = TWO + "*Nset, nset=root, instance=P-2\n 5\n" + END
        self.assertEqual(self.sizes(text), {"Root": 1, "P-1.Root": 3, "P-2.Root": 3, "all": {4: 4}})

    def test_sets_of_one_name(self):
        """The nodes of a face and the cells at it have one name in files of Abaqus/CAE, and are two sets."""
        nodes = "*Nset, nset=face\n 1, 2, 3\n"
        cells = "*Elset, elset=face\n 1\n*Elset, elset=wall\n 2\n*Surface, name=WALL\n wall, S3\n"
        blocks = self.read(f"*Heading\n{NODES}{TETS}{nodes}{cells}")
        self.assertEqual({name: len(list_) for name, list_ in blocks.node_sets.items()}, {"face": 3, "wall": 0})
        text = "".join(convert.lines(blocks))
        self.assertIn('$MeshgenNodeSets\n2\n1 "face"\n2 "wall"\n$EndMeshgenNodeSets\n', text)
        self.assertEqual({line.split()[0] for line in text.splitlines() if line.endswith(' "face"')}, {"0", "1", "3"})
        self.assertEqual({line.split()[0] for line in text.splitlines() if line.endswith(' "wall"')}, {"2", "3"})
        # The same holds for a surface of shells and an element set of solids, but not for an element set of solids and shells
        skin = "*Element, type=S3, elset=skin\n 9, 1, 3, 2\n*Elset, elset=both\n 1, 9\n"
        blocks = self.read(f"{NODES}{TETS}{skin}*Elset, elset=top\n 1\n*Surface, name=Top\n skin, SPOS\n")
        self.assertEqual({name: len(list_) for name, list_ in blocks.node_sets.items()}, {"top": 0})
        self.assertEqual([int(mask.sum()) for mask in blocks.sets["top"]], [1, 1])

    def test_two_of_one_name(self):
        self.refuse("another *PART is called 'finger' too", f"*Part, name=Finger\n{NODES}{TETS}*End Part\n*Part, name=finger\n{NODES}{TETS}*End Part\n")
        self.refuse("another *INSTANCE is called 'p-1' too", TWO + "*Instance, name=p-1, part=P\n*End Instance\n" + END)

    def test_members_that_are_missing(self):
        for words, more in (
            ("node set a refers to node set gone, which is not there", "*Nset, nset=a\n gone\n"),
            ("node set a refers to node set all, which is not in P-1", "*Nset, nset=a, instance=P-1\n all\n"),
            ("node set a refers to node 77, which is not in P-2", "*Nset, nset=a\n P-2.77\n"),
            ("element set a refers to element 3, which is not in P-1", "*Elset, elset=a, instance=P-1\n 1, 3\n"),
            ("element set a refers to element set P-3.all, which is not there", "*Elset, elset=a\n P-3.all\n"),
            ("element set a refers to instance P-3, which is not there", "*Elset, elset=a, instance=P-3\n 1\n"),
            ("surface a refers to element set Root, which", "*Surface, name=a\n P-1.Root, S1\n"),
            ("node set b refers to node set gone", "*Nset, nset=b\n a\n*Nset, nset=a\n gone\n"),
        ):
            self.refuse(words, TWO + more + END)
        # Generated labels may have gaps, and reference points and springs are not part of the mesh
        more = "*Node, nset=point\n 1, 9, 9, 9\n*Nset, nset=a, instance=P-1, generate\n 1, 1000000000, 2\n*Nset, nset=held\n point, a\n"
        self.assertEqual(self.sizes(TWO + more + END), {"point": 0, "a": 3, "held": 3, "Root": 6, "all": {4: 4}})
        self.assertEqual(len(self.read(TWO + more + END).points), 10)
        springs = f"{NODES}{TETS}*Element, type=SPRINGA, elset=springs\n 8, 1, 2\n*Elset, elset=some\n 1, 8\n*Elset, elset=most\n springs, some\n"
        self.assertEqual(self.sizes(springs), {"springs": {}, "some": {4: 1}, "most": {4: 1}})

    def test_sets_of_each_other(self):
        text = NODES + TETS + "*Nset, nset=a\n b, 1\n*Nset, nset=b\n a, c, 2\n*Nset, nset=c\n c, 3\n"
        self.assertEqual(self.sizes(text), {"a": 3, "b": 3, "c": 1})
        doubled = "".join(f"*Nset, nset=s{i}\n s{i + 1}, s{i + 1}\n" for i in range(200)) + "*Nset, nset=s200\n 4\n"
        self.assertEqual(self.sizes(f"{NODES}{TETS}{doubled}")["s0"], 1)

    def test_capital_letters(self):
        text = f"{NODES}{TETS}*NSET, NSET=Root\n 1\n*NSET, NSET=ROOT\n 2\n*Elset, elset=Some\n 1\n*Elset, elset=SOME\n 2\n"
        text += "*Surface, name=Top\n SOME, S1\n*Surface, name=TOP\n 2, S2\n*Nset, nset=other\n rOOt, 3\n"
        self.assertEqual(self.sizes(text), {"Root": 2, "Some": {4: 2}, "Top": {2: 3}, "other": 3})

    def test_coordinates(self):
        points = self.read(f"*Node, system=C\n 1, 2, 90, 3\n 2, 2, 0, 3\n 3, 2, 180., 3\n 4, 0, 30, 4\n*Node, SYSTEM=R\n 5, 1, 90, 3\n{TETS}").points
        np.testing.assert_allclose(points, [[0, 2, 3], [2, 0, 3], [-2, 0, 3], [0, 0, 4], [1, 90, 3]], atol=1e-12)
        self.refuse("line 1: *NODE, SYSTEM=S is not read", NODES.replace("*Node", "*Node, SYSTEM=S") + TETS)

    def test_names_in_messages(self):
        part = f"*Part, name=Finger\n{NODES}{TETS}*Nset, nset=Root\n 1, 77\n*End Part\n"
        self.refuse("node set Root refers to node 77, which is not in Finger", part)
        instance = "*Assembly, name=A\n*Instance, name=Finger-One, part=FINGER\n*End Instance\n*End Assembly\n"
        self.refuse("node set Root refers to node 77, which is not in Finger-One", part + instance)

    def test_coordinate_systems(self):
        def points(system: str, node: str = "*Node") -> np.ndarray:
            return self.read(f"{system}{NODES.replace('*Node', node)}{TETS}").points

        plain = points("")
        np.testing.assert_allclose(points("*System\n 1, 2, 3\n"), plain + [1, 2, 3])
        np.testing.assert_allclose(points("*System\n 1, 2, 3\n*SYSTEM\n"), plain)
        # The image of the axes: x along (3, 4, 0), c on the side of -z
        turned = points("*System\n 1, 1, 1, 4, 5, 1\n 1, 1, 0\n")
        np.testing.assert_allclose(turned[1:4] - turned[0], [[0.6, 0.8, 0], [0, 0, -1], [-0.8, 0.6, 0]], atol=1e-15)
        np.testing.assert_allclose(turned[0], [1, 1, 1])
        # Without c the z-axis stays, and the x-axis is projected
        flat = points("*System\n 1, 1, 1, 4, 5, 9\n")
        np.testing.assert_allclose(flat[1:4] - flat[0], [[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]], atol=1e-15)
        # Cylindrical coordinates are those of the system
        round_ = points("*System\n 1, 0, 0, 1, 1, 0\n", "*Node, system=C")
        np.testing.assert_allclose(round_[[1, 4]], [[1, 1, 0], [1 - np.sin(np.radians(1)), np.cos(np.radians(1)), 1]], atol=1e-15)
        # A system ends with its part
        two = TWO.replace("*Part, name=P\n", "*Part, name=Q\n*System\n 9, 9, 9\n*End Part\n*Part, name=P\n") + END
        np.testing.assert_allclose(self.read(two).points, self.read(TWO + END).points)
        for lines in (" 1, 1, 1, 1, 1, 1\n", " 0, 0, 0, 1, 1, 1\n 3, 3, 3\n", " 0, 0, 0, 0, 0, 1\n"):
            self.refuse("the points of *SYSTEM determine no axes", f"*System\n{lines}{NODES}{TETS}")
        for lines in (" 1, 1\n 1\n", " 1, 1, 1, 1, 1, 2, 3\n", " 1, 1, 1, 1, 1, 2\n 1, 1, 1, 1\n"):
            self.refuse("three or six coordinates, then three are wanted", f"*System\n{lines}{NODES}{TETS}")

    def test_abbreviated_keywords(self):
        text = TWO + "*Nset, nset=clamp, instance=P-1, generate\n 1, 3\n*Elset, elset=half, instance=P-2\n 2\n*Surface, name=low\n half, S1\n" + END
        whole = self.read(text)
        others = "*Node Print, nset=clamp\n U,\n*Node F\n U,\n*El Print\n S,\n*Element Output\n S,\n*Surface Int, name=hard\n 1.\n*End St\n"
        short = text
        for old, new in (("*Nset, nset=clamp, instance=P-1, generate", "*NSE, NS = clamp, INST=P-1, GEN"), ("*Elset, elset=all, generate", "*ELS , e=all,G"),
                         ("*Elset, elset=half, inst", "*elset, else=half, inst"), ("*Element, type", "*ELEM, T"), ("*Node\n", "* N O D E\n"),
                         ("*Surface, name", "*Surf, NA"), ("*End Part", "*ENDPART"), ("*End Instance", "*endinst"), ("*End Assembly", "*End A"), ("*Assembly, name", "*ASSEM, n"),
                         ("*Instance, name=P-1, part", "*Inst, n=P-1, pa")):  # fmt: skip
            self.assertIn(old, short)
            short = short.replace(old, new)
        self.assertEqual(self.sizes(short + others), {"Root": 6, "all": {4: 4}, "clamp": 3, "half": {4: 1}, "low": {2: 1}})
        found = self.read(short + others)
        np.testing.assert_array_equal(found.points, whole.points)
        np.testing.assert_array_equal(found.cells[0][1], whole.cells[0][1])
        Path(self.path("tet.txt")).write_text(TETS)
        self.assertEqual(len(self.read(f"{NODES}*Incl, inp=tet.txt\n").cells[0][1]), 2)
        self.refuse("line 7: *NGEN is not read", f"{NODES}*NGE\n 1, 2\n{TETS}")
        for words, more in (
            ("line 10: '*EL, TYPE=C3D4' can mean ELSET, ELGEN, ", "*EL, TYPE=C3D4\n"),
            ("line 10: '*NOD' can mean NODE, ", "*NOD\n"),
            ("line 10: '*NSET, NSET=a, IN=P-1' can mean INPUT, INSTANCE, INTERNAL", "*NSET, NSET=a, IN=P-1\n"),
            ("line 10: *NSET with 'GENX' is not read", "*NSET, NSET=a, GENX\n"),
            ("line 10: *ELEMENT with 'MAPPED' is not read", "*ELEMENT, TYPE=C3D4, MAPPED\n"),
        ):
            self.refuse(words, NODES + TETS + more)

    def test_generated_meshes(self):
        for keyword in ("NCOPY", "NGEN", "NFILL", "NMAP", "ELCOPY", "ELGEN"):
            self.refuse(f"line 7: *{keyword} is not read", f"{NODES}*{keyword.capitalize()}, x=1\n 1, 2, 3\n{TETS}")

    def test_types_of_elements(self):
        for name in ("SC6R", "SC8R", "SC8RT", "CSS8", "COH3D8", "CIN3D8", "Q3D8", "GK3D8", "AC3D8", "DC3D8", "EC3D8R", "CCL12", "VOXEL", "U1"):
            self.refuse(f"line 10: elements of the type {name} are not read", f"{NODES}{TETS}*Element, type={name}, elset=layer\n 8, 1, 2, 3, 4, 5\n")
        self.refuse("line 7: *ELEMENT has no TYPE", f"{NODES}{TETS.replace(', type=C3D4', '')}")
        for name in ("S8R", "B32", "T3D2H", "M3D8R", "CAX4", "SPRINGA", "CONN3D2", "MASS", "GAPUNI", "DCOUP3D"):
            blocks = self.read(f"{NODES}{TETS}*Element, type={name}\n 8, 1, 2\n")
            self.assertEqual([len(rows) for kind, rows in blocks.cells if kind == 4], [2], name)

    def test_plates_apart_from_the_solids(self):
        """A rigid counterpart of a contact, a membrane or a shell with nodes of its own is left out of its sets, with a note."""
        apart = "*Node\n 11, 0, 0, -5\n 12, 1, 0, -5\n 13, 1, 1, -5\n 14, 0, 1, -5\n"
        for kind in ("R3D4", "S4R", "M3D4"):
            plate = f"{apart}*Element, type={kind}, elset=plate\n 8, 11, 12, 13, 14\n*Surface, name=counterpart\n plate, SPOS\n"
            blocks = self.read(f"{NODES}{TETS}{plate}")
            self.assertFalse(any(mask.any() for masks in blocks.sets.values() for mask in masks), kind)
            self.assertEqual(blocks.notes, ["sets whose elements are neither solids nor faces of solids are no regions: plate, counterpart"])
            both = f"{plate}*Element, type=S3, elset=skin\n 9, 1, 3, 2\n*Elset, elset=all, generate\n 1, 9, 1\n"
            blocks = self.read(f"{NODES}{TETS}{both}")
            self.assertEqual({name: [int(mask.sum()) for mask in masks] for name, masks in blocks.sets.items() if name in ("skin", "all")}, {"skin": [0, 0, 1], "all": [2, 0, 1]})
            self.assertEqual(blocks.notes[0], "left out of the set all: 1 element (shells, membranes or rigid faces) apart from the solids")
            more = both.replace(" 9, 1, 3, 2\n", " 9, 1, 3, 2\n 7, 11, 12, 13\n")
            self.assertEqual(self.read(f"{NODES}{TETS}{more}").notes[0], "left out of the set skin: 1 element (shells, membranes or rigid faces) apart from the solids")
            self.assertIn("left out of the set all: 2 elements (shells, membranes or rigid faces) apart from the solids", self.read(f"{NODES}{TETS}{more}").notes)
        self.assertEqual(self.read(f"{NODES}{TETS}*Element, type=S8R, elset=thick\n 8, 1, 2, 3, 4, 1, 2, 3, 4\n").notes, ["sets whose elements are neither solids nor faces of solids are no regions: thick"])
        # A surface without cells is the surface of a body that is made from it
        self.assertEqual(self.read(f"{apart}*Element, type=S4R, elset=plate\n 8, 11, 12, 13, 14\n").notes, [])

    def test_shells_with_six_nodes(self):
        middles = "*Node\n 6, .5, 0, 0\n 7, .5, .5, 0\n 8, 0, .5, 0\n 9, 0, 0, .5\n 10, .5, 0, .5\n 11, 0, .5, .5\n"
        text = f"{NODES}{middles}*Element, type=C3D10\n 1, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11\n*Element, type=S6, elset=skin\n 2, 1, 3, 2, 8, 7, 6\n"
        self.assertEqual(self.sizes(text), {"skin": {9: 1}})

    def test_labels_that_are_given_twice(self):
        once, twice = self.read(NODES + TETS + SETS), self.read(NODES + TETS + SETS + NODES + TETS)
        np.testing.assert_array_equal(once.points, twice.points)
        np.testing.assert_array_equal(once.cells[0][1], twice.cells[0][1])
        self.refuse("line 15: node 1 is defined before, and differently", NODES + TETS + SETS + NODES.replace(" 1, 0, 0, 0", " 1, 0, 0, 9"))
        self.refuse("line 11: element 2 is defined before, and differently", NODES + TETS + "*Element, type=C3D4\n 2, 1, 3, 4, 5\n")
        self.refuse("line 13: element 1 is defined before, and differently", NODES + TETS + "*Element, type=C3D10\n 1, 1, 2, 3, 4, 5,\n 6, 7, 8, 9,\n 10\n")
        # Each part and instance has its own labels, and an instance can add to those of its part
        self.assertEqual(len(self.read(TWO + END).points), 10)
        more = TWO.replace(" 0, 0, 5\n", " 0, 0, 5\n*Node\n 1, 7, 7, 7\n")
        self.refuse("node 1 is defined before, and differently", more + END)
        Path(self.path("more.txt")).write_text("** nodes\n 1, 7, 7, 7\n")
        self.refuse("cannot read more.txt: line 2: node 1 is defined before", NODES + TETS + "*Node, input=more.txt\n")

    def test_places_of_instances(self):
        def shift(*lines: str) -> np.ndarray:
            blocks = self.read(TWO.replace(" 0, 0, 5\n", "".join(f"{line}\n" for line in lines)) + END)
            return blocks.points[5:] - blocks.points[:5]

        for line, expected in (("20.", [20, 0, 0]), ("20.,", [20, 0, 0]), ("20., 3.", [20, 3, 0]), ("20., ,", [20, 0, 0]), (", 2.D1, 3", [0, 20, 3])):
            np.testing.assert_array_equal(shift(line), [expected] * 5, line)
        # Half a turn about the axis through (1, 0, 0) along z
        np.testing.assert_allclose(shift(",", "1, , , 1, , 1, 180")[0], [2, 0, 0], atol=1e-12)
        for lines in (["1, 2, 3, 4"], ["0, 0, 0, 0, 0, 1, 90"], ["1, 2, x"], ["1, 2, nan"], ["0", "1, 0, 0, 0, 0, 1"], ["0", "1, 0, 0, 1, 0, 0, 90"],
                      ["0", "0, 0, 0, 0, 0, 1, 90, 1"], ["0", "0, 0, 0, 0, 0, 1, 90", "1"]):  # fmt: skip
            with self.assertRaisesRegex(BadRequest, f"line {20 + len(lines)}: '{lines[-1]}' does not fit \\*instance"):
                shift(*lines)

    def test_surfaces_without_a_face(self):
        # Both cells share the face of the nodes 2, 3 and 4
        self.assertEqual(self.sizes(f"{NODES}{TETS}*Surface, name=a\n 1,\n*Surface, name=b\n 1\n 2, S1\n"), {"a": {2: 3}, "b": {2: 4}})
        blocks = self.read(f"{NODES}{TETS}*Elset, elset=all, generate\n 1, 2\n*Surface, type=element, name=skin\n all,\n")
        facets = next(rows for (kind, rows) in blocks.cells if kind == 2)
        self.assertNotIn([1, 2, 3], np.sort(facets).tolist())
        self.assertEqual(len(facets), 6)
        # Cells of different instances share no face
        self.assertEqual(self.sizes(TWO + "*Surface, name=skin\n P-1.all,\n P-2.1\n" + END)["skin"], {2: 6 + 3})
        inside = "*Node\n 6, .2, .2, .2\n" + "".join(f"*Element, type=C3D4\n {i}, {n}, 6\n" for i, n in enumerate(("1, 2, 3", "1, 4, 2", "1, 3, 4", "2, 4, 3"), 3))
        self.refuse("surface a holds no face", f"{NODES}{inside}*Element, type=C3D4\n 1, 1, 2, 3, 4\n 2, 2, 4, 3, 5\n 7, 1, 2, 4, 5\n 8, 1, 3, 2, 5\n"
                    " 9, 1, 4, 3, 5\n*Surface, name=a\n 1,\n")  # fmt: skip

    def test_surfaces_of_shells_and_nodes(self):
        shells = f"{NODES}{TETS}*Element, type=S3, elset=skin\n 8, 1, 3, 2\n 9, 1, 2, 4\n"
        for side in ("", ", SPOS", ", SNEG"):
            self.assertEqual(self.sizes(f"{shells}*Surface, name=a\n skin{side}\n"), {"skin": {2: 2}, "a": {2: 2}}, side)
        nodes = f"{SETS}*Surface, type=NODE, name=Tip\n Root, 1.\n 5,\n"
        self.assertEqual(self.sizes(NODES + TETS + nodes), {"Root": 3, "all": {4: 2}, "Tip": 4})
        for words, more in (
            ("surface a names the face E1 of element 9, which has none", "*Surface, name=a\n skin, E1\n"),
            ("surface a names the face SPOS of element 1, which has none", "*Surface, name=a\n 1, SPOS\n"),
            ("surface a names the face S5 of element 1, which has none", "*Surface, name=a\n 1, S5\n"),
            ("surface a holds no face", "*Element, type=S8R, elset=thick\n 10, 1, 2, 3, 4\n*Surface, name=a\n 10, SPOS\n"),
            ("line 13: surfaces made of others are not read", "*Surface, name=a, combine=union\n b, c\n"),
        ):
            self.refuse(words, shells + more)
