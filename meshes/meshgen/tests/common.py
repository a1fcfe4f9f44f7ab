"""Requests for the tests, and a reader of the written files."""

import contextlib
import gzip
import io
import json
import re
import tempfile
import unittest
from pathlib import Path

import numpy as np

from meshgen import bodies
from meshgen.__main__ import serve

CAD = ("step", "brep", "iges")
UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}


def defaults(body: str, **changes) -> dict:
    """The parameters of a body in SI units."""
    values = {}
    for name, entry in bodies.declaration(body)["parameters"].items():
        number, _, unit = entry["default"].partition(" ")
        values[name] = float(number) * UNITS[unit] if unit else float(number)
    return values | changes


class Case(unittest.TestCase):
    """A test with a temporary folder of its own."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name: str) -> str:
        return str(Path(self.folder.name) / name)

    def parameters(self, file: str, unit: float = 1e-3) -> dict:
        """The parameters of a CAD or surface file as the program sends them: with the known format."""
        ending = file.removesuffix(".gz").rpartition(".")[2].lower()
        return {"path": self.path(file), "unit_m": unit, "kind": "cad" if ending in CAD else "surface", "format": ending}

    def ask(self, body: str, parameters: dict | None = None, name: str = "mesh.msh.gz", **request) -> tuple:
        """Send a request; returns (exit code, answer)."""
        parameters = defaults(body) if parameters is None else parameters
        text = json.dumps({"body": body, "version": 1, "parameters": parameters, "output": self.path(name)} | request)
        return self.send(text)

    def send(self, text: str) -> tuple:
        """Answer a request in this process; `test_process` tests a separate process."""
        with contextlib.redirect_stderr(io.StringIO()):
            answer, code = serve(text)
        return code, json.loads(json.dumps(answer))

    def made(self, *args, **kwargs) -> dict:
        """The manifest of a request that must succeed."""
        code, answer = self.ask(*args, **kwargs)
        self.assertEqual(code, 0, answer)
        answer_path = self.path(re.sub(r"\.msh(\.gz)?$", ".json", answer["request"]["output"]))
        self.assertEqual(json.loads(Path(answer_path).read_text()), answer)
        return answer

    def refused(self, code: int, words: str, *args, **kwargs) -> dict:
        """The error of a request that must fail, whose text must contain the given words."""
        got, answer = self.ask(*args, **kwargs)
        self.assertEqual(got, code, answer)
        self.assertIn(words, answer["error"] + " " + answer["hint"])
        return answer

    def covers_boundary(self, manifest: dict, names: str = "") -> None:
        """The facet regions whose names begin with a prefix together are the boundary, with each facet once."""
        counts = [region["count"] for name, region in manifest["regions"].items() if region["dim"] == 2 and name.startswith(names)]
        self.assertEqual(sum(counts), manifest["facets"])
        self.assertEqual(manifest["regions"]["body"], {"dim": 3, "count": manifest["cells"]})


def read_msh(path: str) -> dict:
    """A small strict reader: names, nodes, elements by (dim, entity), physical tags of entities."""
    data = Path(path).read_bytes()
    text = (gzip.decompress(data) if path.endswith(".gz") else data).decode()
    section = {name: body.strip().split("\n") for name, body in re.findall(r"\$(\w+)\n(.*?)\$End\1\n", text, re.S)}
    names = {}
    for line in section["PhysicalNames"][1:]:
        dim, tag, name = line.split(maxsplit=2)
        names[name.strip('"')] = (int(dim), int(tag))
    counts = list(map(int, section["Entities"][0].split()))
    dims = [dim for dim, count in enumerate(counts) for _ in range(count)]
    groups = {}
    for dim, line in zip(dims, section["Entities"][1:], strict=True):
        fields = line.split()[4 if dim == 0 else 7 :]
        groups[dim, int(line.split()[0])] = [int(tag) for tag in fields[1 : 1 + int(fields[0])]]
    assert len(groups) == sum(counts)
    count = int(section["Nodes"][0].split()[1])
    place = {int(number): i for i, number in enumerate(section["Nodes"][2 : 2 + count])}
    nodes = np.array([line.split() for line in section["Nodes"][2 + count :]], float)
    elements, lines = {}, iter(section["Elements"][1:])
    for line in lines:
        dim, entity, _, number = map(int, line.split())
        elements[dim, entity] = np.array([[place[int(node)] for node in next(lines).split()[1:]] for _ in range(number)], int)
    return {"names": names, "groups": groups, "nodes": nodes, "elements": elements}
