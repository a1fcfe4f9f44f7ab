"""Coordinate systems of Abaqus nodes end with the part, instance or assembly in which they are defined."""

from pathlib import Path

from meshgen import convert

from .common import Case
from .test_abaqus import END, NODES, TETS

PART, ASSEMBLY, SHIFT = "*Part, name=P\n*End Part\n", "*Assembly, name=A\n", "*System\n 7, 0, 0\n"


def instance(number: int, system: str = "") -> str:
    """An instance with nodes of its own."""
    return f"*Instance, name=P-{number}, part=P\n{system}{NODES}{TETS}*End Instance\n"


class Systems(Case):
    def test_places(self):
        for text, begin in (
            (PART + ASSEMBLY + instance(1, SHIFT), [7]),
            (PART + ASSEMBLY + instance(1, SHIFT) + instance(2), [7, 0]),
            (PART + ASSEMBLY + SHIFT + instance(1), [0]),
            (PART + SHIFT + ASSEMBLY + instance(1), [0]),
            (SHIFT + PART + ASSEMBLY + instance(1), [0]),
        ):
            Path(self.path("a.inp")).write_text(text + END)
            points = convert.read(Path(self.path("a.inp")), "abaqus").points
            self.assertEqual(points[::5].tolist(), [[x, 0, 0] for x in begin])
            self.assertEqual(points[1::5].tolist(), [[x + 1, 0, 0] for x in begin])
