"""Reduced models from Python: the numbers of the program, and refusals."""

import json
import subprocess
import sys
from pathlib import Path

import durometer
import numpy
import pytest
from conftest import BEAM, program

STUDY = """
kind = "reduction"
question = "How few?"
expectation = "Few."
scene = "scene.toml"
tolerance = "1 %"
training = 20
held_back = 12
modes = [4]
[[input]]
name = "weight"
key = "effect.gravity.acceleration"
range = ["0 m/s^2", "30 m/s^2"]
[[quantity]]
name = "xmax_z_m"
label = "height"
symbol = "z"
unit = "m"
"""


def test_a_twin_gives_the_numbers_of_the_program(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(BEAM)
    (tmp_path / "study.toml").write_text(STUDY)
    told = program("run", tmp_path / "study.toml", "--out", tmp_path / "out")
    assert told.returncode == 0, told.stderr
    [file] = (tmp_path / "out" / "models").glob("*.durom")
    twin = durometer.Twin(file)
    [name] = twin.ranges
    assert twin.ranges[name] == (0.0, 30.0) and twin.inputs == {name: 0.0}
    line = json.dumps({"inputs": {name: 12.5}}) + "\n"
    command = [sys.executable, "-P", "-m", "durometer", "twin", str(file)]
    stepped = subprocess.run(command, input=line, capture_output=True, text=True, check=True)
    answer = json.loads(stepped.stdout.splitlines()[1])["quantities"]["xmax_z_m"]
    values = twin.step({name: 12.5})
    assert values == {"xmax_z_m": answer["value"]} and twin.bars == {"xmax_z_m": answer["bar"]} and twin.in_range
    # Central differences with h = 1e-4 of the range
    slope = twin.sensitivities()
    assert slope.shape == (1, 1)
    ends = [twin.step({name: 12.5 + h})["xmax_z_m"] for h in (-3e-3, 3e-3)]
    assert abs(slope[0, 0] - (ends[1] - ends[0]) / 6e-3) < 1e-4 * abs(slope[0, 0])
    twin.reset()
    assert twin.reach({"xmax_z_m": values["xmax_z_m"]}) and abs(twin.inputs[name] - 12.5) < 0.1
    twin.step({name: 50.0})
    assert not twin.in_range and numpy.isinf(twin.bars["xmax_z_m"])
    assert durometer.Twin.from_bytes(file.read_bytes()).ranges == twin.ranges
    # At many addresses, which Python aligns to 16 bytes
    others = [durometer.Twin(file) for _ in range(20)]
    assert all(other.step({name: 12.5}) == values for other in others)
    for wrong in ({"none": 1.0}, {name: float("nan")}):
        with pytest.raises(durometer.InputError):
            twin.step(wrong)
    with pytest.raises(durometer.InputError):
        durometer.Twin.from_bytes(file.read_bytes()[:-1])
