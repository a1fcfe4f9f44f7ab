"""Reduced models from Python: the numbers of the program, and refusals."""

import json
import subprocess
import sys
from pathlib import Path
from types import MappingProxyType

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


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("reduction")
    (folder / "scene.toml").write_text(BEAM)
    (folder / "study.toml").write_text(STUDY)
    told = program("run", folder / "study.toml", "--out", folder / "out")
    assert told.returncode == 0, told.stderr
    [file] = (folder / "out" / "models").glob("*.durom")
    return file


def test_a_twin_gives_the_numbers_of_the_program(file: Path) -> None:
    twin = durometer.Twin(file)
    [name] = twin.ranges
    assert twin.ranges[name] == (0.0, 30.0) and twin.inputs == {name: 9.81}
    line = json.dumps({"inputs": {name: 12.5}}) + "\n"
    command = [sys.executable, "-P", "-m", "durometer", "twin", str(file)]
    stepped = subprocess.run(command, input=line, capture_output=True, text=True, check=True)
    answer = json.loads(stepped.stdout.splitlines()[1])["quantities"]["xmax_z_m"]
    assert numpy.isnan(twin.sensitivities()).all()
    values = twin.step(MappingProxyType({name: numpy.float32(12.5)}))
    assert values == {"xmax_z_m": answer["value"]} and twin.bars == {"xmax_z_m": answer["bar"]} and twin.in_range
    # Central differences with h = 1e-4 of the range
    slope = twin.sensitivities()
    assert slope.shape == (1, 1)
    ends = [twin.step({name: 12.5 + h})["xmax_z_m"] for h in (-3e-3, 3e-3)]
    assert abs(slope[0, 0] - (ends[1] - ends[0]) / 6e-3) < 1e-4 * abs(slope[0, 0])
    assert repr(twin).startswith(f"<Twin at {name} = 1.25") and "xmax_z_m = " in repr(twin)
    twin.reset()
    assert numpy.isnan(twin.sensitivities()).all()
    assert twin.reach({"xmax_z_m": values["xmax_z_m"]}) and abs(twin.inputs[name] - 12.5) < 0.1
    twin.step({name: 50.0})
    assert not twin.in_range and numpy.isinf(twin.bars["xmax_z_m"])
    assert durometer.Twin.from_bytes(file.read_bytes()).ranges == twin.ranges
    # At many addresses, since Python aligns to 16 bytes
    others = [durometer.Twin(file) for _ in range(20)]
    assert all(other.step({name: 12.5}) == values for other in others)
    for wrong in ({"none": 1.0}, {name: float("nan")}, {name: "12.5"}, {name: None}, {name: [1.0, 2.0]}, {1: 1.0}, [1.0], 1.0):
        with pytest.raises(durometer.InputError):
            twin.step(wrong)
    for wrong in ({"none": 1.0}, {"xmax_z_m": "low"}, {"xmax_z_m": float("inf")}, [1.0]):
        with pytest.raises(durometer.InputError):
            twin.reach(wrong)
    with pytest.raises(durometer.InputError, match="no input none"):
        twin.reach({"xmax_z_m": 0.0}, moving=["none"])
    with pytest.raises(durometer.InputError, match="moving is of the type str, and no list of names"):
        twin.reach({"xmax_z_m": 0.0}, moving=name)
    with pytest.raises(durometer.InputError, match="tolerance is 0"):
        twin.reach({"xmax_z_m": 0.0}, tolerance=0.0)

    class Ended:
        def __float__(self) -> float:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        twin.step({name: Ended()})
    with pytest.raises(durometer.InputError):
        durometer.Twin.from_bytes(file.read_bytes()[:-1])


#: Numbers whose value Python computes, in a thread that yields to the other one
SHARED = """
import sys
import threading
import time

import durometer


class Number:
    def __float__(self):
        time.sleep(1e-4)
        return 12.5


twin = durometer.Twin(sys.argv[1])
[name] = twin.ranges
steps = threading.Thread(target=lambda: [twin.step({name: Number()}) for _ in range(100)], daemon=True)
steps.start()
while steps.is_alive():
    twin.values, twin.bars, twin.inputs
assert twin.inputs == {name: 12.5}
"""


def test_threads_share_a_twin(file: Path) -> None:
    subprocess.run([sys.executable, "-P", "-c", SHARED, str(file)], check=True, timeout=60)


def test_an_exception_of_a_law_in_python_comes_through(tmp_path: Path) -> None:
    from test_laws import PythonNeoHookean

    class InModel(PythonNeoHookean):
        name = "python_in_model"
        fails = False

        def stress(self, F):
            if InModel.fails:
                raise ZeroDivisionError("in the model")
            return super().stress(F)

    durometer.register_law(InModel)
    (tmp_path / "scene.toml").write_text(BEAM.replace("neo_hookean", "python_in_model").replace("[4, 2, 2]", "[2, 1, 1]"))
    (tmp_path / "study.toml").write_text(STUDY)
    durometer.Study.load(tmp_path).run(tmp_path / "out", isolation="threads", check=False)
    [file] = (tmp_path / "out" / "models").glob("*.durom")
    twin = durometer.Twin(file)
    [name] = twin.ranges
    before = twin.step({name: 12.5})
    InModel.fails = True
    with pytest.raises(ZeroDivisionError, match="in the model"):
        twin.step({name: 13.5})
    with pytest.raises(ZeroDivisionError, match="in the model"):
        durometer.Twin(file)
    InModel.fails = False
    twin.reset()
    assert twin.step({name: 12.5})["xmax_z_m"] == pytest.approx(before["xmax_z_m"], abs=1e-9)
