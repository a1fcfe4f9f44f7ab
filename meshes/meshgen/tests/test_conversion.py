"""Conversion of volume meshes: every cell and set of the file is in the result, with its defects."""

import gzip
import importlib.util
import json
import os
import re
import zlib
from pathlib import Path

import gmsh
import meshio
import numpy as np

from meshgen import convert

from .common import Case, read_msh

CUBE = np.array([[x, y, z] for z in (0.0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
TETS = np.array([[0, 1, 2, 5], [0, 2, 7, 5], [0, 2, 3, 7], [0, 5, 7, 4], [2, 7, 5, 6]])

XDMF = f"""<Xdmf Version="3.0"><Domain><Grid Name="Grid"><Geometry GeometryType="XYZ">
<DataItem DataType="Float" Dimensions="8 3" Format="XML" Precision="8">{" ".join(map(str, CUBE.ravel()))}</DataItem></Geometry>
<Topology TopologyType="Tetrahedron" NumberOfElements="5" NodesPerElement="4">
<DataItem DataType="Int" Dimensions="5 4" Format="XML" Precision="8">{" ".join(map(str, TETS.ravel()))}</DataItem></Topology>
</Grid></Domain></Xdmf>"""

CAE = """*Heading
** made by CAE
*Part, name=Brick
*Node
 1, 0, 0, 0
 2, 1, 0, 0
 3, 1, 1, 0
 4, 0, 1, 0
 5, 0, 0, 1
 6, 1, 0, 1
 7, 1, 1, 1
 8, 0, 1, 1
*Element, type=C3D8RH, elset=all
 1, 1, 2, 3, 4,
 5, 6, 7, 8
*Nset, nset=low, generate
 1, 4, 1
*Elset, elset=again
 all
*Surface, type=ELEMENT, name=top
 all, S2
*End Part
*Assembly, name=A
*Instance, name=B-1, part=Brick
*End Instance
*Instance, name=B-2, part=Brick
 0, 0, 1
 0, 0, 0, 0, 0, 1, 90
*End Instance
*Nset, nset=tip, instance=B-2
 5, 6, 7, 8
*Elset, elset=_side_S1, internal, instance=B-1
 1,
*Surface, type=ELEMENT, name=side
 _side_S1, S1
*End Assembly
"""


class Conversion(Case):
    def converted(self, file: str, format: str) -> dict:
        code, answer = self.send(self.request(file, format))
        self.assertEqual(code, 0, answer)
        return read_msh(self.path("out.msh"))

    def reject(self, words: str, file: str, format: str) -> None:
        code, answer = self.send(self.request(file, format))
        self.assertEqual(code, 2, answer)
        self.assertIn(words, answer["error"] + " " + answer["hint"])

    def request(self, file: str, format: str) -> str:
        return json.dumps({"convert": {"path": self.path(file), "format": format, "output": self.path("out.msh")}})

    def store(self, name: str, **options) -> None:
        mesh = meshio.Mesh(CUBE, {"tetra": TETS}, **options.pop("data", {}))
        meshio.write(self.path(name), mesh, **options)

    def test_formats(self):
        self.store("a.vtu", file_format="vtu", binary=True)
        self.store("b.vtu", file_format="vtu", binary=False)
        self.store("c.inp")
        self.store("d.mesh")
        Path(self.path("e.xdmf")).write_text(XDMF)
        self.store("f.bdf")
        self.store("g.ele")
        self.store("h.vol")
        Path(self.path("i.vtk")).write_bytes(Path(self.path("a.vtu")).read_bytes())
        Path(self.path("j.vtu.gz")).write_bytes(gzip.compress(Path(self.path("a.vtu")).read_bytes()))
        Path(self.path("k.inp")).write_bytes(b"\xef\xbb\xbf" + Path(self.path("c.inp")).read_bytes().replace(b"\n", b"\r\n"))
        formats = {"inp": "abaqus", "mesh": "medit", "bdf": "nastran", "ele": "tetgen", "vol": "netgen", "vtk": "vtu", "gz": "vtu"}
        for path in sorted(Path(self.folder.name).glob("[a-k].*")):
            ending = path.suffix[1:]
            if ending == "node":
                continue
            if ending == "xdmf" and importlib.util.find_spec("h5py") is None:
                self.reject("pip install h5py", path.name, "xdmf")
                continue
            mesh = self.converted(path.name, formats.get(ending, ending))
            (cells,) = [rows for (dim, _), rows in mesh["elements"].items() if dim == 3]
            self.assertEqual(len(cells), 5, path.name)
            self.assertTrue(np.allclose(mesh["nodes"], CUBE), path.name)
            self.assertEqual(sorted(map(sorted, cells.tolist())), sorted(map(sorted, TETS.tolist())), path.name)

    def test_sets(self):
        sets = {"cell_sets": {"hard": [np.array([1, 2])], "left": [np.array([2, 3])]}, "point_sets": {"held": np.array([0, 3])}}
        self.store("sets.inp", data=sets)
        mesh = self.converted("sets.inp", "abaqus")
        groups = {name: [len(mesh["elements"][key]) for key, tags in mesh["groups"].items() if tag in tags and key[0] == dim]
                  for name, (dim, tag) in mesh["names"].items() if dim == 3}
        self.assertEqual({name: sum(counts) for name, counts in groups.items()}, {"hard": 2, "left": 2})
        (held,) = [rows for (dim, _), rows in mesh["elements"].items() if dim == 0]
        self.assertEqual(sorted(held.ravel().tolist()), [0, 3])
        self.store("data.vtu", data={"cell_data": {"part": [np.array([4, 4, 7, 7, 7])], "level": [np.zeros(5)]}})
        self.assertEqual(set(self.converted("data.vtu", "vtu")["names"]), {"part_4", "part_7"})
        text = Path(self.path("data.vtu")).read_text()
        self.assertNotIn('Name="part" NumberOfComponents', text)
        Path(self.path("column.vtu")).write_text(text.replace('Name="part"', 'Name="part" NumberOfComponents="1"'))
        self.assertEqual(set(self.converted("column.vtu", "vtu")["names"]), {"part_4", "part_7"})

    def numbers(self, file: str, format: str) -> tuple:
        """Numbers of the nodes and of the cells with volume in a converted file, cells with their nodes."""
        code, answer = self.send(self.request(file, format))
        self.assertEqual(code, 0, answer)
        text = Path(self.path("out.msh")).read_text()
        head, *nodes = re.search(r"\$Nodes\n.*\n(.*)\n((?:.*\n)*?)\$EndNodes", text).expand(r"\1\n\2").splitlines()
        cells, lines = {}, iter(text.partition("$Elements\n")[2].partition("$EndElements")[0].splitlines()[1:])
        for line in lines:
            dim, _, _, count = map(int, line.split())
            rows = [[int(word) for word in next(lines).split()] for _ in range(count)]
            cells |= {row[0]: row[1:] for row in rows if dim == 3}
        return [int(label) for label in nodes[: int(head.split()[3])]], cells

    def test_numbers_are_those_of_the_file(self):
        data = {"cell_sets": {"odd": [np.array([0, 2, 4])], "even": [np.array([1, 3])]}, "point_sets": {"held": np.array([0, 3])}}
        self.store("a.inp", data=data)
        text = Path(self.path("a.inp")).read_text()
        self.assertEqual(self.numbers("a.inp", "abaqus"), (list(range(1, 9)), {i: (row + 1).tolist() for i, row in enumerate(TETS, 1)}))
        labels = {"*NODE": 70, "*ELEMENT": 900}
        lines, shift = [], ""
        for line in text.splitlines():
            shift = next((key for key in labels if line.upper().startswith(key)), "" if line.startswith("*") else shift)
            words = [word.strip() for word in line.split(",")]
            if shift and words[0].isdigit():
                words[0] = str(int(words[0]) + labels[shift])
                words[1:] = [str(int(word) + 70) if shift == "*ELEMENT" else word for word in words[1:]]
            lines.append(", ".join(words))
        Path(self.path("b.inp")).write_text("\n".join(lines[: next(i for i, line in enumerate(lines) if "SET" in line.upper())]) + "\n*ELSET, ELSET=a\n901, 904\n")
        self.assertEqual(self.numbers("b.inp", "abaqus"), (list(range(71, 79)), {i: (row + 71).tolist() for i, row in enumerate(TETS, 901)}))
        # The labels of two instances are the same: all are counted
        Path(self.path("cae.inp")).write_text(CAE)
        nodes, cells = self.numbers("cae.inp", "abaqus")
        self.assertEqual((nodes, list(cells)), (list(range(1, 17)), [1, 2]))
        self.store("c.bdf")
        text = Path(self.path("c.bdf")).read_text()
        moved = re.sub(r"^CTETRA,(\d+)", lambda m: f"CTETRA,{int(m[1]) + 40}", re.sub(r"^CTETRA +(\d+)", lambda m: f"CTETRA  {int(m[1]) + 40:<8}", text, flags=re.M), flags=re.M)
        self.assertNotEqual(moved, text)
        Path(self.path("d.bdf")).write_text(moved)
        self.assertEqual(list(self.numbers("d.bdf", "nastran")[1]), list(range(41, 46)))
        self.store("e.vtu", data={"cell_data": {"part": [np.array([4, 7, 4, 7, 7])]}}, file_format="vtu")
        self.assertEqual(self.numbers("e.vtu", "vtu"), (list(range(8)), {i: row.tolist() for i, row in enumerate(TETS)}))
        self.store("g.ele")
        self.assertEqual(self.numbers("g.ele", "tetgen"), (list(range(8)), {i: row.tolist() for i, row in enumerate(TETS)}))
        for name in ("g.node", "g.ele"):
            head, *rows = [line for line in Path(self.path(name)).read_text().splitlines() if line and not line.startswith("#")]
            columns = slice(0, 1) if name == "g.node" else slice(0, None)
            words = [row.split() for row in rows]
            for row in words:
                row[columns] = [str(int(word) + 1) for word in row[columns]]
            Path(self.path(name)).write_text("\n".join([head, *map(" ".join, words)]) + "\n")
        self.assertEqual(self.numbers("g.ele", "tetgen"), (list(range(1, 9)), {i: (row + 1).tolist() for i, row in enumerate(TETS, 1)}))
        self.store("f.mesh", data={"cell_data": {"medit:ref": [np.array([4, 7, 4, 7, 7])]}})
        self.assertEqual(self.numbers("f.mesh", "medit"), (list(range(1, 9)), {i: (row + 1).tolist() for i, row in enumerate(TETS, 1)}))

    def test_voxels_and_unknown_cells(self):
        hexahedron = CUBE + [2, 0, 0]
        mesh = meshio.Mesh(np.vstack([CUBE, hexahedron]), {"tetra": TETS[:1], "hexahedron": [np.arange(8, 16)]})
        meshio.write(self.path("plain.vtu"), mesh, binary=False)
        text = Path(self.path("plain.vtu")).read_text()
        self.assertIn("\n10\n12\n", text)
        nodes = "\n".join(map(str, range(8, 16)))
        self.assertIn(nodes, text)
        voxel = text.replace("\n10\n12\n", "\n10\n11\n").replace(nodes, "\n".join(map(str, [8, 9, 11, 10, 12, 13, 15, 14])))
        Path(self.path("voxel.vtu")).write_text(voxel)
        self.assertEqual(str(self.converted("voxel.vtu", "vtu")), str(self.converted("plain.vtu", "vtu")))
        Path(self.path("unknown.vtu")).write_text(text.replace("\n10\n12\n", "\n10\n99\n"))
        self.reject("it has cells of the type 99, which are not read write it with tetrahedra", "unknown.vtu", "vtu")
        # A polyline has no volume: the solids are read without it, as in legacy files
        Path(self.path("line.vtu")).write_text(text.replace("\n10\n12\n", "\n10\n4\n"))
        blocks = convert.read(Path(self.path("line.vtu")), "vtu")
        self.assertEqual([(kind, rows.tolist()) for kind, rows in blocks.cells], [(4, TETS[:1].tolist())])
        self.assertEqual((len(blocks.notes), blocks.numbers), (1, None))
        self.assertIn("(type 4)", blocks.notes[0])

    def test_new_versions_and_raw_data_of_vtu(self):
        self.store("a.vtu", file_format="vtu", binary=False)
        text = Path(self.path("a.vtu")).read_text()
        self.assertIn('version="0.1"', text)
        whole = str(self.converted("a.vtu", "vtu"))
        for version in ("1.0", "2.0", "2.2", "2.3"):
            Path(self.path("b.vtu")).write_text(text.replace('version="0.1"', f'version="{version}" header_type="UInt64"'))
            self.assertEqual(str(self.converted("b.vtu", "vtu")), whole, version)
        Path(self.path("b.vtu")).write_text(text.replace('version="0.1"', 'version="3.0"'))
        self.reject("Unknown VTU file version '3.0'", "b.vtu", "vtu")
        values = [("Float64", 3, CUBE), ("Int64", 1, TETS), ("Int64", 1, np.arange(4, 24, 4)), ("UInt8", 1, np.full(5, 10))]
        for packed in (False, True):
            raw, arrays = b"", []
            for name, (kind, components, content) in zip(("Points", "connectivity", "offsets", "types"), values):
                arrays.append(f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="appended" offset="{len(raw)}"/>')
                block = np.ascontiguousarray(content, kind.lower()).tobytes()
                head = [len(block)] if not packed else [1, len(block), len(block), len(zlib.compress(block))]
                raw += np.array(head, "<u4").tobytes() + (zlib.compress(block) if packed else block)
            compressor = ' compressor="vtkZLibDataCompressor"' if packed else ""
            begin = f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian"{compressor}>\n<UnstructuredGrid>\n'
            begin += f'<Piece NumberOfPoints="8" NumberOfCells="5">\n<Points>{arrays[0]}</Points>\n<Cells>{"".join(arrays[1:])}</Cells>\n</Piece>\n'
            for end in ("", "\n", "\n   "):
                text = f'{begin}</UnstructuredGrid>\n<AppendedData encoding="raw">\n_'.encode() + raw + f"{end}</AppendedData>\n</VTKFile>\n".encode()
                Path(self.path("raw.vtu")).write_bytes(text)
                self.assertEqual(str(self.converted("raw.vtu", "vtu")), whole, (packed, end))
            Path(self.path("raw.vtu")).write_bytes(text[: len(text) // 2])
            self.reject("cannot read raw.vtu", "raw.vtu", "vtu")

    def test_warnings_are_kept(self):
        self.store("a.mesh")
        text = Path(self.path("a.mesh")).read_text()
        Path(self.path("b.mesh")).write_text(text.replace("\nEnd", "\nRidges\n1\n1\nEnd"))
        self.converted("b.mesh", "medit")
        (notes,) = re.findall(r"\$MeshgenNotes\n1\n1 \"the reader of medit says: (.*)\"\n\$EndMeshgenNotes\n", Path(self.path("out.msh")).read_text())
        self.assertIn("keyword Ridges", notes)

    def test_abaqus(self):
        Path(self.path("cae.inp")).write_text(CAE)
        mesh = self.converted("cae.inp", "abaqus")
        sizes = {}
        for name, (dim, tag) in mesh["names"].items():
            sizes[name] = sum(len(mesh["elements"][key]) for key, tags in mesh["groups"].items() if key[0] == dim and tag in tags)
        self.assertEqual(sizes, {"all": 2, "again": 2, "low": 8, "tip": 4, "top": 2, "side": 1})
        placed = {tuple(np.round(x, 9) + 0.0) for x in mesh["nodes"].tolist()}
        self.assertIn((-1, 1, 2), placed)  # (1, 1, 1), shifted and turned by a right angle
        for old, new, words in [
            (" 2, 1, 0, 0", " 2, 1, 0", "line 6: '2, 1, 0' does not fit *node"),
            (" 5, 6, 7, 8\n*Nset", " 5, 6, 7\n*Nset", "line 16: the element before has too few nodes"),
            ("part=Brick\n*End", "part=Brik\n*End", "there is no part Brik"),
            (" 1, 1, 2, 3, 4,", " 1, 1, 2, 3, 44,", "element 1 refers to node 44"),
            ("C3D8RH", "AC3D8", "elements of the type AC3D8 are not read"),
        ]:
            self.assertIn(old, CAE)
            Path(self.path("bad.inp")).write_text(CAE.replace(old, new))
            self.reject(words, "bad.inp", "abaqus")
        Path(self.path("main.inp")).write_text("*Heading\n*Include, input=absent.inp\n")
        self.reject("cannot read absent.inp", "main.inp", "abaqus")

    def test_included_files(self):
        node, element = CAE.index("*Node"), CAE.index("*Element")
        Path(self.path("nodes.inp")).write_text(CAE[node:element].replace("*Node", "*NODE"))
        main = CAE[:node] + "*Include,\n Input=\"nodes.inp\"\n" + CAE[element:]
        Path(self.path("main.inp")).write_text(main)
        Path(self.path("packed.inp.gz")).write_bytes(gzip.compress(main.encode()))
        for name in ("main.inp", "packed.inp.gz"):
            self.assertEqual(len(self.converted(name, "abaqus")["nodes"]), 16, name)
        # Data lines in files of their own
        (nodes_head, *nodes), (elements_head, *elements) = (block.splitlines() for block in (CAE[node:element], CAE[element:].split("*Nset")[0]))
        rest = CAE[element:].partition("*Nset")[2]
        Path(self.path("n.txt")).write_text("\n".join(nodes))
        Path(self.path("e.txt")).write_text("\n".join(elements))
        Path(self.path("main.inp")).write_text(
            f"{CAE[:node]}{nodes_head}, INPUT=n.txt\n{elements_head}, input = e.txt\n*Nset{rest}"
        )
        apart = self.converted("main.inp", "abaqus")
        Path(self.path("one.inp")).write_text(CAE)
        one = self.converted("one.inp", "abaqus")
        for key in one:
            self.assertEqual(str(apart[key]), str(one[key]), key)
        Path(self.path("main.inp")).write_text("*Heading\n*Include\n")
        self.reject("line 2: *INCLUDE names no file", "main.inp", "abaqus")

    def test_files_of_windows(self):
        node = CAE.index("*Node")
        head = "** Prüfkörper\n*Heading\nGröße\n*Material, name=Weiß\n"
        os.mkdir(self.path("sub"))
        Path(self.path("sub/rest.inp")).write_bytes(("** für alle\n" + CAE[node:]).encode("latin-1"))
        Path(self.path("main.inp")).write_bytes(f"{head}{CAE[:node]}*Include, input=.\\sub\\rest.inp\n".encode("latin-1"))
        Path(self.path("one.inp")).write_text(CAE)
        self.assertEqual(str(self.converted("main.inp", "abaqus")), str(self.converted("one.inp", "abaqus")))

    def test_included_files_without_an_end(self):
        def write(name: str, *included: str) -> None:
            Path(self.path(name)).write_text("*Heading\n" + "".join(f"*INCLUDE, INPUT={other}\n" for other in included))

        write("a.inp", "b.inp")
        write("b.inp", "a.inp")
        self.reject("files include each other: a.inp → b.inp → a.inp", "a.inp", "abaqus")
        for i in range(20):
            write(f"l{i}.inp", f"l{i + 1}.inp")
        for i in range(12):
            write(f"t{i}.inp", f"t{i + 1}.inp", f"t{i + 1}.inp")
        write("t12.inp")
        self.reject("more than 16 levels", "l0.inp", "abaqus")
        self.reject("more than 1000 included files", "t0.inp", "abaqus")
        write("device.inp", os.devnull)
        self.reject("it is not a regular file", "device.inp", "abaqus")
        if hasattr(os, "mkfifo"):
            os.mkfifo(self.path("pipe"))
            write("pipe.inp", "pipe")
            self.reject("cannot read pipe: it is not a regular file", "pipe.inp", "abaqus")

    def of_gmsh(self, *names: str) -> None:
        """Two boxes side by side, with groups of cells and facets, as gmsh writes them."""
        gmsh.initialize([], False, False)
        gmsh.option.setNumber("General.Terminal", 0)
        model = gmsh.model
        model.occ.fragment([(3, model.occ.addBox(0, 0, 0, 1, 1, 1)), (3, model.occ.addBox(1, 0, 0, 1, 1, 1))], [])
        model.occ.synchronize()
        for dim, tags, number, name in ((3, [1], 1, "soft"), (3, [2], 2, "hard part"), (2, [1], 3, "root")):
            model.addPhysicalGroup(dim, tags, number, name)
        model.mesh.generate(3)
        gmsh.option.setNumber("Mesh.SaveElementTagType", 2)  # The groups
        for name in names:
            gmsh.write(self.path(name))
        gmsh.finalize()

    def test_nastran(self):
        self.of_gmsh("gmsh.bdf")
        text = Path(self.path("gmsh.bdf")).read_text()
        self.assertNotIn("BEGIN BULK", text)
        lines = text.splitlines()
        first = next(i for i, line in enumerate(lines) if line.startswith("CTETRA"))
        head = "ID A,B\nSOL 101\nCEND\nBegin bulk\n"
        whole = {"same.bdf": text, "head.bdf": head + text, "small.bdf": text.lower(), "windows.bdf": text.replace("\n", "\r\n")}
        for name, content in whole.items():
            Path(self.path(name)).write_text(content, newline="")
            blocks = convert.read(Path(self.path(name)), "nastran")
            cells = sum(len(rows) for kind, rows in blocks.cells if kind == 4)
            self.assertEqual(cells, text.count("CTETRA"), name)
            self.assertEqual(set(blocks.sets), {"cells_1", "cells_2", "facets_3"}, name)
            self.assertEqual(sum(map(sum, (blocks.sets["cells_1"] + blocks.sets["cells_2"]))), cells, name)
        for name, content in {
            "cut.bdf": "\n".join(lines[: first + 5]),
            "bulk.bdf": "BEGIN BULK\n" + "\n".join(lines[: first + 5]),
            "comment.bdf": "BEGIN BULK\n" + "\n".join([*lines[: first + 5], "$ ENDDATA"]),
            "begin.bdf": "$ a comment\nBEGIN BULK\n\n",
            "before.bdf": "ENDDATA\nBEGIN BULK\n",
        }.items():
            Path(self.path(name)).write_text(content)
            self.reject("its last line must be ENDDATA", name, "nastran")
        Path(self.path("empty.bdf")).write_text("BEGIN BULK\nENDDATA\n")
        self.reject("holds no cells", "empty.bdf", "nastran")
        for words, old, new in (
            ("line 3: INCLUDE is not read", lines[2], "INCLUDE 'more.bdf'"),
            ("elements in wide fields", lines[first], "CTETRA* 1               1               1               2"),
            ("coordinate system of their own (CP)", lines[1], lines[1][:16] + "1       " + lines[1][24:]),
        ):
            Path(self.path("other.bdf")).write_text(text.replace(old, new))
            self.reject(words, "other.bdf", "nastran")

    def test_avs(self):
        triangles = np.array([[0, 2, 1], [0, 3, 2]])
        data = {"part": [np.array([5, 5]), np.array([1, 1, 1, 2, 2])], "load": [np.zeros(2), np.ones(5)], "flow": [np.zeros((2, 3)), np.ones((5, 3))]}
        mesh = meshio.Mesh(CUBE, [("triangle", triangles), ("tetra", TETS)], {"heat": np.arange(8.0)}, data)
        meshio.write(self.path("two.avs"), mesh)
        text = Path(self.path("two.avs")).read_text()
        self.assertIn("8 7 1 4 0", text)
        mesh = self.converted("two.avs", "avsucd")
        self.assertEqual({"avsucd:material_1", "avsucd:material_2"}, set(mesh["names"]))
        self.assertTrue(np.allclose(mesh["nodes"], CUBE))
        cells = np.vstack([rows for (dim, _), rows in mesh["elements"].items() if dim == 3])
        self.assertEqual(sorted(map(sorted, cells.tolist())), sorted(map(sorted, TETS.tolist())))
        lines = text.splitlines(keepends=True)
        for kept in (-1, -9, 18, 16):
            Path(self.path("cut.avs")).write_text("".join(lines[:kept]))
            self.reject("lines of at least", "cut.avs", "avsucd")
        Path(self.path("cut.avs")).write_text("".join(lines[:14]))
        self.reject("cannot read cut.avs", "cut.avs", "avsucd")
        Path(self.path("wrong.avs")).write_text("8 7\n")
        self.reject("cannot read wrong.avs", "wrong.avs", "avsucd")

    def test_lines_of_nastran(self):
        middles = [[0.5, 0, 0], [0.5, 0.5, 0], [0, 0.5, 0], [0, 0, 0.5], [0.5, 0, 0.5], [0, 0.5, 0.5]]
        nodes = CUBE[[0, 1, 3, 4]].tolist() + middles
        grids = "".join(f"GRID,{i},,{x},{y},{z}\n" for i, (x, y, z) in enumerate(nodes, 1))

        def small(*words) -> str:
            return "".join(f"{word:<8}" for word in words)

        def read(text: str) -> convert.Blocks:
            Path(self.path("a.bdf")).write_text(f"BEGIN BULK\n{text}ENDDATA\n")
            return convert.read(Path(self.path("a.bdf")), "nastran")

        expected = read(f"{grids}CTETRA,1,1,1,2,3,4,5,6,+\n+,7,8,9,10\n")
        self.assertEqual([kind for kind, _ in expected.cells], [11])
        np.testing.assert_array_equal(expected.points, nodes)
        others = "CELAS1,2,2,1,1,2,1\nCBUSH,3,2,1,2\nCONM2,4,1,,1.\nCBAR,5,1,1,2,3\nCBEAM,6,1,1,2,3\nCPLSTN3,7,1,1,2,3\n"
        others += "CORD1R,1,1,2,3\nCORD2R,5,,0.,0.,0.,0.,0.,1.\n+,1.,0.,0.\nPSOLID,1,1\n"
        self.assertEqual([kind for kind, _ in read(f"{grids}{others}CTETRA,1,1,1,2,3,4,5,6,+\n+,7,8,9,10\n").cells], [11])
        first, rest = ("CTETRA", 1, 1, 1, 2, 3, 4, 5, 6), (7, 8, 9, 10)
        tabs = "".join("GRID\t{}\t\t{}\t{}\t{}\n".format(i, *x) for i, x in enumerate(nodes, 1))
        powers = "".join("GRID,{},,{}D0,{}+0,{}E0\n".format(i, *x) for i, x in enumerate(nodes, 1))
        wide = "".join("GRID*   {:<16}{:<16}{:<16}{:<16}\n        {:<16}\n".format(i, "", *x) for i, x in enumerate(nodes, 1))
        for points in (grids, tabs, powers, powers.replace("D0", "-0"), wide):
            for cell in (f"{small(*first)}\n{small('', *rest)}", f"{small(*first)}+A\n{small('+A', *rest)}", "CTETRA,1,1,1,2,3,4,5,6\n,7,8,9,10",
                         "CTETRA,1,1,1,2,3,4,5,6,7,8,9,10", "CTETRA\t1\t1\t1\t2\t3\t4\t5\t6\n\t7\t8\t9\t10 $ the end"):  # fmt: skip
                found = read(f"{points}$ cells\n\n{cell}\n")
                np.testing.assert_array_equal(found.points, expected.points)
                np.testing.assert_array_equal(found.cells[0][1], expected.cells[0][1])
        for words, text in (
            ("line 12: CTETRA: 8 nodes, where 4 or 10 are wanted", f"{grids}CTETRA,1,1,1,2,3,4\n,7,8,9,10\n"),
            ("line 12: CTETRA: 5 nodes, where 4 or 10 are wanted", f"{grids}CTETRA,1,1,1,2,3,4,5\n"),
            ("line 12: CTETRA: '2.5' is not a whole number", f"{grids}CTETRA,1,1,1,2.5,3,4\n"),
            ("line 12: there is no GRID 11", f"{grids}CTETRA,1,1,1,2,3,11\n"),
            ("line 12: GRID: '1.0.0' is not a number", f"{grids}GRID,11,,1.0.0,2.,3.\n"),
            ("line 12: GRID: node 3 is defined before, and differently", f"{grids}GRID,3,,1.0,2.,3.\n"),
            ("line 2: GRDSET: nodes in a coordinate system of their own (CP)", f"GRDSET,,5\n{grids}"),
            ("line 2 continues no entry", f"+,1.\n{grids}"),
            ("line 12: CTETPR: elements of this kind are not read", f"{grids}CTETPR,1,1,1,2,3,4\n"),
            ("line 13: CTETRAA: elements of this kind are not read", f"{grids}CTETRA,1,1,1,2,3,4\n{small('CTETRAA', 2, '', 2, 3, 4, 1)}\n"),
            ("line 12: elements in wide fields are not read", f"{grids}CTETRA_*1               1               1               2\n"),
        ):
            with self.assertRaises(convert.BadRequest) as caught:
                read(text)
            self.assertIn(words, caught.exception.error)
        self.assertEqual(len(read(f"GRDSET,,0\n{grids}CTETRA,1,1,1,2,3,4\nCTRIA3,2,3,1,2,3,0.,0.5\n").cells), 2)

    def test_nastran_of_meshio(self):
        def cell(corners: np.ndarray, edges: list) -> np.ndarray:
            return np.vstack([corners, [corners[[a, b]].mean(axis=0) for a, b in edges]])

        kinds = {
            "tetra10": cell(CUBE[[0, 1, 3, 4]], [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]),
            "hexahedron20": cell(CUBE + 9, [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]),
            "tetra": CUBE[[0, 1, 3, 4]] + 20,
        }
        cells, count = [], 0
        for kind, points in kinds.items():
            cells.append((kind, np.arange(count, count + len(points))[None]))
            count += len(points)
        meshio.write(self.path("a.bdf"), meshio.Mesh(np.vstack(list(kinds.values())), cells))
        self.assertIn("CTETRA_", Path(self.path("a.bdf")).read_text())
        blocks = convert.read(Path(self.path("a.bdf")), "nastran")
        self.assertEqual([(kind, len(rows)) for kind, rows in blocks.cells], [(convert.KINDS[kind][1], 1) for kind in kinds])
        for (kind, points), (_, rows) in zip(kinds.items(), blocks.cells):
            expected = points[[0, 1, 2, 3, 4, 5, 6, 7, 9, 8]] if kind == "tetra10" else points
            np.testing.assert_allclose(blocks.points[rows[0]], expected, err_msg=kind)

    def test_names_of_groups(self):
        self.of_gmsh("a.med", "a.inp")
        for name, format in (("a.med", "gmsh"), ("a.inp", "abaqus")):
            blocks = convert.read(Path(self.path(name)), format)
            counts = {group: sum(int(mask.sum()) for mask in masks) for group, masks in blocks.sets.items()}
            cells = sum(len(rows) for kind, rows in blocks.cells if kind == 4)
            hard = "hard part" if "hard part" in counts else "hard_part"
            self.assertLessEqual({"soft", hard, "root"}, set(counts), name)
            self.assertEqual(counts["soft"] + counts[hard], cells, name)
            self.assertEqual(counts["root"], sum(int(mask.sum()) for (kind, _), mask in zip(blocks.cells, blocks.sets["root"]) if kind == 2))
            self.assertGreater(counts["root"], 0, name)

    def test_cells_of_order_three(self):
        gmsh.initialize([], False, False)
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(3)
        gmsh.option.setNumber("Mesh.MshFileVersion", 4.0)
        gmsh.write(self.path("a.msh"))
        gmsh.finalize()
        self.reject("a.msh has cells of the kind Triangle 10, Line 4, Tetrahedron 20 write it", "a.msh", "gmsh")

    def test_universal_files_that_are_cut_off(self):
        self.of_gmsh("a.unv")
        text = Path(self.path("a.unv")).read_text()
        whole = convert.read(Path(self.path("a.unv")), "gmsh")
        self.assertEqual({name: int(sum(map(sum, masks))) > 0 for name, masks in whole.sets.items()}, {"soft": True, "hard_part": True, "root": True})
        marks = [i for i, line in enumerate(text.splitlines()) if line.strip() == "-1"]
        self.assertEqual(len(marks), 6)  # Nodes, elements, groups
        for begin, end in zip(marks[::2], marks[1::2]):
            for line in (begin + 3, (begin + end) // 2, end):
                Path(self.path("cut.unv")).write_text("\n".join(text.splitlines()[:line]))
                self.reject(f"cannot read cut.unv: the data set that begins in line {begin + 1} has no line with -1 at its end", "cut.unv", "gmsh")
        # A field of ten columns within a data set is no mark, and gmsh passes over a second mark at a beginning
        label = "    -1\n  2414\n        -1\nfield\n    -1\n"
        for name, more in (("label.unv", text + label), ("twice.unv", text.replace("    -1\n  2412", "    -1\n    -1\n  2412", 1))):
            self.assertNotEqual(more, text)
            Path(self.path(name)).write_text(more)
            self.assertEqual(self.sizes(name, "gmsh"), self.sizes("a.unv", "gmsh"))
        Path(self.path("cut.unv")).write_text(text + label[:-7])
        self.reject("has no line with -1 at its end", "cut.unv", "gmsh")

    def test_files_of_tetgen_that_are_damaged(self):
        self.store("a.ele")
        nodes, cells = (Path(self.path(f"a.{ending}")).read_text() for ending in ("node", "ele"))
        wide = "\n".join(["1 10 0", "1 " + " ".join(map(str, range(10)))])
        for words, node, ele in (
            ("cannot read b.ele: it does not begin with the numbers of its cells", nodes, "# a comment\n"),
            ("cannot read b.ele: it does not begin with the numbers of its cells", nodes, ""),
            ("cannot read b.ele: it does not begin with the numbers of its cells", nodes, "five 4 0\n"),
            ("cannot read b.ele: it does not begin with the numbers of its cells", nodes, "5 4 -5\n"),
            ("cannot read b.node: it does not begin with the numbers of its nodes", "\n# a comment", cells),
            ("cannot read b.ele: it announces 5 cells, of which 4 are there", nodes, cells[: cells.rstrip().rindex(" ")]),
            ("cannot read b.node: it announces 8 nodes, of which 7 are there", "\n".join(nodes.splitlines()[:-1]), cells),
            ("cannot read b.ele: it announces 5 cells, and holds numbers for 10", nodes, cells + cells),
            ("cannot read b.ele: its cells have 10 nodes write tetrahedra with 4 nodes", nodes, wide),
        ):
            Path(self.path("b.node")).write_text(node)
            Path(self.path("b.ele")).write_text(ele)
            self.reject(words, "b.ele", "tetgen")
            self.reject(words, "b.node", "tetgen")
        Path(self.path("b.node")).write_text(nodes + "# the end\n")
        Path(self.path("b.ele")).write_text(cells + "# the end\n")
        self.assertEqual(len(self.converted("b.node", "tetgen")["nodes"]), 8)

    def sizes(self, name: str, format: str) -> dict:
        """Members of the sets by the kind of their cells."""
        blocks = convert.read(Path(self.path(name)), format)
        found = {}
        for group, masks in blocks.sets.items():
            for (kind, _), mask in zip(blocks.cells, masks):
                if mask.any():
                    found.setdefault(group, {}).setdefault(kind, 0)
                    found[group][kind] += int(mask.sum())
        return found

    def test_su2(self):
        points = "".join(f"{x} {y} {z} {i}\n" for i, (x, y, z) in enumerate(CUBE))
        cells = "".join(f"10 {' '.join(map(str, row))} {i}\n" for i, row in enumerate(TETS))
        box = "FFD_NBOX= 1\nFFD_CORNER_POINTS= 1\n0.0 0.0\n"
        marks = "NMARK= 4\nMARKER_TAG= left\nMARKER_ELEMS= 2\n5 0 2 1\n5 0 3 2\nMARKER_TAG= SEND_RECEIVE\nMARKER_ELEMS= 1\nSEND_RECV= 1\n1 0 0\n"
        marks += "MARKER_TAG= 7\nMARKER_ELEMS= 1\n5 4 5 7\nMARKER_TAG= left\nMARKER_ELEMS= 1 % again\n5 5 6 7\n"
        text = f"% made by hand\nNDIME= 3\nNELEM= 5\n{cells}NPOIN= 8 8\n\n{points}{marks}{box}"
        Path(self.path("a.su2")).write_text(text)
        self.assertEqual(self.sizes("a.su2", "su2"), {"left": {2: 3}, "facets_7": {2: 1}, "SEND_RECEIVE": {15: 1}})
        mesh = self.converted("a.su2", "su2")
        np.testing.assert_array_equal(mesh["nodes"], CUBE)
        (rows,) = [rows for (dim, _), rows in mesh["elements"].items() if dim == 3]
        np.testing.assert_array_equal(rows, TETS)
        for words, old, new in (
            ("line 4: elements of the type 24 are not read SU2 has linear cells", "10 0 1 2 5 0", "24 0 1 2 5 0 1 2 3 4 5 0"),
            ("line 3: NELEM= 6, but 5 lines follow", "NELEM= 5", "NELEM= 6"),
            ("line 7: '10 0 5 7 4 3' is one line more than was announced", "NELEM= 5", "NELEM= 3"),
            ("line 9: NPOIN= 9, but 8 lines follow", "NPOIN= 8", "NPOIN= 9"),
            ("MARKER_ELEMS= 1, but 0 lines follow", text[text.index("5 5 6 7") :], ""),
            ("line 19: NMARK= 4, but 2 markers follow", text[text.index("MARKER_TAG= 7") :], ""),
            ("line 4: 3 nodes, where 4 are wanted", "10 0 1 2 5 0", "10 0 1 2"),
            ("line 4: '10 0 1 2 x' is no list of nodes", "10 0 1 2 5 0", "10 0 1 2 x"),
            ("'0.0 0.0' has no three coordinates", "0.0 0.0 0.0 0", "0.0 0.0"),
            ("an element refers to node 9, which is not there", "10 0 1 2 5 0", "10 0 1 2 9 0"),
            ("has points of dimension 2 a body has three", "NDIME= 3", "NDIME= 2"),
            ("line 2: 2 zones are not read", "NDIME= 3", "NZONE= 2"),
            ("line 3: NELEM is not a whole number", "NELEM= 5", "NELEM= five"),
        ):
            self.assertIn(old, text)
            Path(self.path("bad.su2")).write_text(text.replace(old, new))
            self.reject(words, "bad.su2", "su2")
        for old, new in (("made by hand", "Würfel"), ("again", "Rückseite")):
            Path(self.path("latin.su2")).write_bytes(text.replace(old, new).encode("latin-1"))
            self.assertEqual(self.sizes("latin.su2", "su2"), self.sizes("a.su2", "su2"))
        Path(self.path("latin.su2")).write_bytes(text.replace("left", "rück").encode("latin-1"))
        self.reject("cannot read latin.su2: line 20: it is no text in UTF-8 save the file as UTF-8", "latin.su2", "su2")

    def test_netgen(self):
        triangles = np.array([[0, 2, 1], [0, 3, 2], [4, 5, 7], [5, 6, 7]])
        index = {"netgen:index": [np.array([1, 2, 3, 0]), np.array([1, 1, 2, 2, 2])]}
        meshio.write(self.path("a.vol"), meshio.Mesh(CUBE, [("triangle", triangles), ("tetra", TETS)], cell_data=index))
        text = Path(self.path("a.vol")).read_text()
        begin, end = text.index("materials"), text.index("endmesh")
        self.assertLess(begin, end)
        Path(self.path("plain.vol")).write_text(text[:begin] + text[end:])
        self.assertEqual(self.sizes("plain.vol", "netgen"), {"cells_1": {4: 2}, "cells_2": {4: 3}, "facets_1": {2: 1}, "facets_2": {2: 1}, "facets_3": {2: 1}})
        names = "materials\n2\n1 soft\n2 hard part\nbcnames\n3\n1 default\n2 default\n3 soft\n\n"
        Path(self.path("named.vol")).write_text(text[:begin] + names + text[end:])
        self.assertEqual(self.sizes("named.vol", "netgen"), {"soft": {4: 2, 2: 1}, "hard part": {4: 3}, "default": {2: 2}})
        Path(self.path("packed.vol.gz")).write_bytes(gzip.compress(Path(self.path("named.vol")).read_bytes()))
        self.assertEqual(self.sizes("packed.vol.gz", "netgen"), self.sizes("named.vol", "netgen"))
        Path(self.path("cut.vol")).write_text(text[:begin])
        self.reject("cannot read cut.vol: it has no line endmesh", "cut.vol", "netgen")
        # As Netgen writes them: by a tab
        names = "materials\n2\n1 soft\n2 hard part\n\n\nbcnames\n3\n1\tinner wall\n2\t\n3\tsoft\n\n\n"
        Path(self.path("tab.vol")).write_text(text[:begin] + names + text[end:])
        self.assertEqual(self.sizes("tab.vol", "netgen"), {"soft": {4: 2, 2: 1}, "hard part": {4: 3}, "inner wall": {2: 1}, "facets_2": {2: 1}})
        for key, damaged in (("materials", names.replace("2", "4", 1)), ("bcnames", names.replace("\n3\n", "\n30\n"))):
            Path(self.path("short.vol")).write_text(text[:begin] + damaged + text[end:])
            self.reject(f"cannot read short.vol: {key} has fewer names than it announces", "short.vol", "netgen")

    def test_nothing_is_run(self):
        script = f'// BEGIN BULK\nSystemCall "echo run > {self.path("run")}";\n'
        for name in ("a.geo", "b.fem"):
            Path(self.path(name)).write_text(script)
            self.reject("its last line must be ENDDATA", name, "nastran")
        Path(self.path("c.geo")).write_text("    -1\n   151\n" + script + "    -1\n")
        self.reject("holds no cells", "c.geo", "gmsh")
        self.assertFalse(Path(self.path("run")).exists())

    def test_readers_that_give_no_reason(self):
        mesh = "MeshVersionFormatted 2\nDimension\n3\nVertices\n1\n0 0 0 0\n TetrahedraP2\n1\n1 1 1 1 1 1 1 1 1 1 1\nTrianglesP2\n0\nEnd\n"
        Path(self.path("a.mesh")).write_text(mesh)
        self.reject("cells of second order (TetrahedraP2, TrianglesP2) are not read from Medit write them in another format", "a.mesh", "medit")
        Path(self.path("b.mesh")).write_text(mesh.replace(" TetrahedraP2", "3").replace("TrianglesP2", "End"))
        self.reject("the reader of medit refuses it without a reason check that the file is complete, or write another format", "b.mesh", "medit")
        Path(self.path("c.mesh")).write_text(mesh.replace("Formatted 2", "Formatted 7").replace("P2", ""))
        self.reject("the reader of medit does not know '7' check that", "c.mesh", "medit")
        meshio.write(self.path("d.dat"), meshio.Mesh(CUBE, [("quad", np.array([[0, 1, 2, 3]])), ("hexahedron", np.arange(8)[None])]), file_format="tecplot")
        self.reject("cannot read d.dat: as tecplot its cells are called quad and have 8 nodes write cells of one kind", "d.dat", "tecplot")

    def test_refusals(self):
        self.store("good.vtu")
        text = Path(self.path("good.vtu")).read_bytes()
        Path(self.path("cut.vtu")).write_bytes(text[: len(text) // 2])
        self.reject("not well formed", "cut.vtu", "vtu")
        piece = text[text.index(b"<Piece") : text.index(b"</Piece>") + 8]
        Path(self.path("pieces.vtu")).write_bytes(text.replace(piece, piece + b"\n<!-- <Piece> -->" + piece))
        self.reject("it has 2 pieces, of which only one is read merge them", "pieces.vtu", "vtu")
        Path(self.path("wrong.vtu")).write_text("<VTKFile type=\"PolyData\"></VTKFile>")
        self.reject("cannot read", "wrong.vtu", "vtu")
        for number, text in ((2, "*NODE, NSET=Größe\n1, 0, 0, 0\n"), (4, "*NODE\n*NSET, NSET=a\nGröße\n"), (2, "*PART, NAME=Größe\n")):
            Path(self.path("latin.inp")).write_bytes(f"** Größe\n{text}".encode("latin-1"))
            self.reject(f"line {number}: it is no text in UTF-8 save", "latin.inp", "abaqus")
        Path(self.path("empty.mesh")).write_text("MeshVersionFormatted 1\nDimension 3\nVertices\n1\n0 0 0 0\nEnd\n")
        self.reject("holds no cells", "empty.mesh", "medit")
        meshio.write(self.path("flat.vtu"), meshio.Mesh(CUBE[:, :3], {"polygon": [[0, 1, 2, 3, 4]]}))
        self.reject("polygon", "flat.vtu", "vtu")
