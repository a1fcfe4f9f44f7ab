"""The module computes the numbers of the program, bit for bit."""

import csv
from pathlib import Path

import durometer
import numpy
import pytest
from conftest import BEAM, PULLED, program


@pytest.mark.parametrize("text", [BEAM, PULLED], ids=["weight", "pulled"])
def test_every_column_of_a_run_has_the_bits_of_the_program(tmp_path: Path, text: str) -> None:
    # A folder with a blank in its name works like any other
    folder = tmp_path / "a folder"
    folder.mkdir()
    (folder / "scene.toml").write_text(text)
    told = program("simulate", folder / "scene.toml", "--out", folder / "out", "--no-view")
    assert told.returncode == 0, told.stderr
    with (folder / "out" / "scene.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    written = numpy.array(rows[1:], dtype=float)
    for threads in [1, 2]:
        run = durometer.Scene.from_toml(folder / "scene.toml").run(threads=threads)
        assert run.columns == rows[0]
        assert run.values.tobytes() == written.tobytes()


def test_a_text_and_a_file_are_the_same_scene(tmp_path: Path, beam: durometer.Scene) -> None:
    (tmp_path / "scene.toml").write_text(BEAM)
    from_file = durometer.Scene.from_toml(tmp_path / "scene.toml")
    assert from_file.text == beam.text
    assert from_file.run().values.tobytes() == beam.run().values.tobytes()


def test_a_change_is_that_of_the_flag_set(tmp_path: Path, beam: durometer.Scene) -> None:
    (tmp_path / "scene.toml").write_text(BEAM)
    change = "laws.silicone.E=80 kPa"
    told = program("simulate", tmp_path / "scene.toml", "--set", change, "--out", tmp_path, "--no-view")
    assert told.returncode == 0, told.stderr
    written = numpy.loadtxt(tmp_path / "scene.csv", delimiter=",", skiprows=1)
    changed = beam.set("laws.silicone.E", "80 kPa")
    assert changed.run().values.tobytes() == written.tobytes()
    assert changed.get("laws.silicone.E") == "80 kPa"
    assert beam.get("laws.silicone.E") == "100 kPa", "a scene does not change"
