"""Fits to tests and calibrations by simulation recover the constants that made their data."""

import json
from pathlib import Path

import durometer
import numpy
import pytest
from conftest import PULLED, program

STRETCH = numpy.linspace(1.05, 1.6, 12)


def test_a_fit_recovers_its_constant_and_goes_into_a_scene(tmp_path: Path) -> None:
    fit = durometer.Fit.from_arrays(STRETCH, 40e3 * (STRETCH - STRETCH**-2), "neo_hookean", nu=0.45)
    assert abs(fit.constants["mu"] / 40e3 - 1) < 1e-9 and fit.units["mu"] == "Pa" and fit.is_determined
    lower, upper = fit.intervals["mu"]
    assert lower <= fit.constants["mu"] <= upper and fit.covariance.shape == (1, 1)
    assert list(fit.frame.columns) == ["value", "lower", "upper", "unit"]
    scene = durometer.Scene.from_toml(PULLED)
    assert scene.set("laws.silicone", fit.table).run().converged
    fit.save(tmp_path / "law.toml")
    assert (tmp_path / "law.toml").read_text() == fit.text


def test_a_fit_of_a_file_is_that_of_the_program(tmp_path: Path) -> None:
    strain, stress = STRETCH - 1, 40.0 * (STRETCH - STRETCH**-2)
    rows = "\n".join(f"{a},{b}" for a, b in zip(strain.tolist(), stress.tolist()))
    (tmp_path / "pull.csv").write_text(f"strain [1],stress [kPa]\n{rows}\n")
    told = program("fit", tmp_path / "pull.csv", "--law", "yeoh", "--terms", 2, "--mode", "uniaxial", "--out", tmp_path, "--json")
    assert told.returncode in (0, 3), told.stderr
    expected = {p["name"]: p["value"] for p in json.loads(told.stdout)["parameters"]}
    fit = durometer.Fit.from_csv(tmp_path / "pull.csv", "yeoh", terms=2, modes="uniaxial")
    assert fit.constants == expected


def test_a_calibration_recovers_its_constant() -> None:
    truth = durometer.Scene.from_toml(PULLED).set("numerics.tolerance", 1e-11).set("stage.0.dt", "0.25 s")
    run = truth.run()
    x, y = run.times[1:], run["xmin_reaction_x_N"][1:]
    start = truth.set("laws.silicone.E", "70 kPa")
    curve = durometer.Curve(start, "t_s", x, "xmin_reaction_x_N", y)
    found = durometer.Calibration.from_curves([curve], {"laws.silicone.E": ("20 kPa", "500 kPa")}, accuracy=1e-6)
    assert found.settled and abs(found.constants["laws.silicone.E"] / 100e3 - 1) < 1e-6
    assert found.units["laws.silicone.E"] == "Pa" and len(found.frame) == 1
    repeated = found.scene.run()["xmin_reaction_x_N"]
    assert numpy.abs(repeated[1:] / y - 1).max() < 1e-6


@pytest.mark.parametrize(
    "change, words",
    [({"x": [0.5]}, "1 x and 2 y"), ({"column": "no_such"}, "no_such"), ({"over": "no_such"}, "no_such")],
    ids=["length", "column", "signal"],
)
def test_a_wrong_curve_is_refused(pulled: durometer.Scene, change: dict, words: str) -> None:
    arguments = {"scene": pulled, "over": "t_s", "x": [0.5, 1.0], "column": "xmin_reaction_x_N", "y": [1.0, 2.0]}
    with pytest.raises(durometer.InputError, match=words):
        durometer.Calibration.from_curves([durometer.Curve(**{**arguments, **change})], ["laws.silicone.E"])
