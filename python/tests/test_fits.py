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


def test_constants_and_covariance_have_one_order() -> None:
    stress = 2 * (STRETCH - STRETCH**-2) * (20e3 + 5e3 / STRETCH)
    fit = durometer.Fit.from_arrays(STRETCH, stress * (1 + 1e-3 * numpy.sin(40 * STRETCH)), "mooney_rivlin", terms=2, nu=0.45)
    names = [parameter["name"] for parameter in fit.result["parameters"]]
    assert list(fit.constants) == list(fit.units) == list(fit.intervals) == list(fit.frame.index) == names
    run = durometer.Scene.from_toml(PULLED).run()
    unknowns = ["laws.silicone.nu", "effect.gravity.density", "laws.silicone.E"]
    columns = ["xmin_reaction_x_N", "xmin_reaction_z_N"]
    start = durometer.Scene.from_toml(PULLED)
    curves = [durometer.Curve(start, "t_s", run.times[1:], column, run[column][1:] * [1.001, 0.999], column) for column in columns]
    found = durometer.Calibration.from_curves(curves, unknowns, check=False)
    assert list(found.constants) == list(found.units) == list(found.intervals) == list(found.frame.index) == unknowns
    assert found.units == {"laws.silicone.nu": "1", "effect.gravity.density": "kg/m^3", "laws.silicone.E": "Pa"}


def test_several_specimens_count_by_the_scatter_between_them() -> None:
    start = durometer.Scene.from_toml(PULLED)
    run = start.run()
    x, column = run.times[1:], "xmin_reaction_x_N"
    curves = [durometer.Curve(start, "t_s", x, column, level * run[column][1:], f"{level}") for level in (0.9, 1.0, 1.1)]
    found = durometer.Calibration.from_curves(curves, ["laws.silicone.E"], accuracy=1e-6)
    lower, upper = found.intervals["laws.silicone.E"]
    # t of two degrees of freedom times the standard error of the three levels, up to the correction for so few of them
    half_width = (upper - lower) / 2 / found.constants["laws.silicone.E"]
    assert 0.95 < half_width / (4.303 * 0.1 / 3**0.5) < 1.25
    one = [durometer.Curve(start, "t_s", x, column, curve.y, curve.name, "one") for curve in curves]
    assert durometer.Calibration.from_curves(one, ["laws.silicone.E"], accuracy=1e-6).intervals["laws.silicone.E"] != (lower, upper)
    with pytest.raises(durometer.InputError, match="hold the same numbers"):
        durometer.Calibration.from_curves([curves[0], curves[0]], ["laws.silicone.E"])


BOUNDED = {"over": "t_s", "x": [0.5, 1.0], "column": "xmin_reaction_x_N", "y": [-1e-3, -2e-3]}


@pytest.mark.parametrize(
    "ends", [("90 kPa", "1 MPa"), ["90 kPa", "1 MPa"], numpy.array(["90 kPa", "1 MPa"]), (90e3, 1e6), numpy.array([90e3, 1e6])]
)
def test_bounds_are_any_pair(pulled: durometer.Scene, ends: object) -> None:
    curve = durometer.Curve(pulled, **BOUNDED)
    found = durometer.Calibration.from_curves([curve], {"laws.silicone.E": ends}, check=False)
    assert abs(found.constants["laws.silicone.E"] / 90e3 - 1) < 1e-12, "the curve asks for less"
    free = durometer.Calibration.from_curves([curve], {"laws.silicone.E": None}, check=False)
    assert free.constants["laws.silicone.E"] < 90e3


@pytest.mark.parametrize(
    "ends, words",
    [
        (("10 kPa", "80 kPa", "x"), "no pair"),
        ("10 kPa", "no pair"),
        (5, "no pair"),
        (numpy.float64(5), "no pair"),
        ({"lower": "10 kPa", "upper": "80 kPa"}, "no pair"),
        (("10 kPa", None), "of the type NoneType"),
        (("10 mm", "20 mm"), "wrong dimension"),
    ],
)
def test_other_bounds_are_refused(pulled: durometer.Scene, ends: object, words: str) -> None:
    with pytest.raises(durometer.InputError, match=words):
        durometer.Calibration.from_curves([durometer.Curve(pulled, **BOUNDED)], {"laws.silicone.E": ends})


def test_a_force_of_the_other_sign_is_refused(pulled: durometer.Scene) -> None:
    curve = durometer.Curve(pulled, **{**BOUNDED, "y": [1.0, 2.0]})
    with pytest.raises(durometer.InputError, match="give y the other sign"):
        durometer.Calibration.from_curves([curve], ["laws.silicone.E"])


@pytest.mark.parametrize(
    "options, words",
    [
        ({"nu": 0.45, "kappa": 1e6}, "both given"),
        ({"noise": -5.0, "weight": "noise"}, "no standard deviation"),
        ({"noise": float("nan"), "weight": "noise"}, "no standard deviation"),
        ({"noise": 5.0}, "no effect"),
        ({"tolerance": float("nan")}, "a share above zero"),
        ({"tolerance": -1}, "a share above zero"),
    ],
)
def test_options_that_say_nothing_are_refused(options: dict, words: str) -> None:
    with pytest.raises(durometer.InputError, match=words):
        durometer.Fit.from_arrays(STRETCH, 40e3 * (STRETCH - STRETCH**-2), "neo_hookean", **options)


def test_arrays_have_no_option_for_their_unit() -> None:
    fit = durometer.Fit.from_arrays(STRETCH, 40e-3 * (STRETCH - STRETCH**-2), "neo_hookean", nu=0.45)
    [warning] = [warning for warning in fit.warnings if "range of rubbers" in warning]
    assert warning.endswith("are the stresses in MPa rather than Pa? Give them in Pa"), warning


def test_arrays_of_the_other_sign_are_answered_without_an_option_of_tables() -> None:
    with pytest.raises(durometer.InputError, match="give the stresses the other sign") as caught:
        durometer.Fit.from_arrays(STRETCH, -40e3 * (STRETCH - STRETCH**-2), "neo_hookean", nu=0.45)
    assert "stress_positive" not in str(caught.value)


def test_no_data_are_refused() -> None:
    with pytest.raises(durometer.InputError, match="no data points"):
        durometer.Fit.from_arrays([], [], "neo_hookean")


def test_the_stress_of_a_table_may_be_positive_in_compression(tmp_path: Path) -> None:
    rows = [f"{stretch - 1},{-40e3 * (stretch - stretch**-2)}" for stretch in STRETCH]
    (tmp_path / "pull.csv").write_text("strain (-),stress (Pa)\n" + "\n".join(rows))
    fit = durometer.Fit.from_csv(tmp_path / "pull.csv", "neo_hookean", modes="uniaxial", nu=0.45, stress_positive="compression")
    assert abs(fit.constants["mu"] / 40e3 - 1) < 1e-9


def test_displacement_and_force_become_strain_and_stress(tmp_path: Path) -> None:
    # A strip of 33 mm x 6 mm x 3 mm; displacement in mm, force in N
    force = 40e3 * (STRETCH - STRETCH**-2) * 18e-6
    rows = [f"{33 * (stretch - 1)},{f}" for stretch, f in zip(STRETCH.tolist(), force.tolist())]
    table = tmp_path / "machine.csv"
    table.write_text("Displacement (mm),Force (N)\n" + "\n".join(rows))
    texts = {"gauge_length": "33 mm", "width": "6 mm", "thickness": "3 mm"}
    numbers = {"gauge_length": 33e-3, "area": 18e-6}
    for sizes in (texts, numbers):
        fit = durometer.Fit.from_csv(table, "neo_hookean", mode="uniaxial", nu=0.45, **sizes)
        assert abs(fit.constants["mu"] / 40e3 - 1) < 1e-9
    with pytest.raises(durometer.InputError, match="the option gauge_length, or gauge_length under .* with name, file and status"):
        durometer.Fit.from_csv(table, "neo_hookean", mode="uniaxial")
    (tmp_path / "card.toml").write_text('[specimen]\ngauge_length = "33 mm"\n')
    with pytest.raises(durometer.InputError, match="missing field `name`") as caught:
        durometer.Fit.from_csv(table, "neo_hookean", mode="uniaxial")
    assert caught.value.remedy.startswith("a card begins with name")
    given = 'name = "strip"\nfile = "machine.csv"\nstatus = "own measurement"\nmode = "uniaxial"\n[specimen]\n'
    (tmp_path / "card.toml").write_text(given + "\n".join(f'{key} = "{text}"' for key, text in texts.items()))
    assert abs(durometer.Fit.from_csv(table, "neo_hookean", nu=0.45).constants["mu"] / 40e3 - 1) < 1e-9


def test_all_options_of_a_table_are_known_and_named(tmp_path: Path) -> None:
    strain, stress = STRETCH - 1, 40.0 * (STRETCH - STRETCH**-2)
    table = tmp_path / "pull.csv"
    table.write_text("strain [%],stress [kPa]\n" + "\n".join(f"{100 * a},{b}" for a, b in zip(strain.tolist(), stress.tolist())))
    read = lambda **options: durometer.Fit.from_csv(table, "neo_hookean", nu=0.45, **options)  # noqa: E731
    options = {"decimal": "point", "positive": "tension", "strain_from": "extensometer", "cycle": "all", "test": 1, "accuracy": {"stress_scale": "2 %"}}
    fit = read(mode="uniaxial", **options)
    assert abs(fit.constants["mu"] / 40e3 - 1) < 1e-9
    lower, upper = fit.intervals["mu"]
    assert (upper - lower) / fit.constants["mu"] > 0.03, "the load cell is known to 2 %"
    with pytest.raises(durometer.InputError, match="no option colour") as caught:
        read(colour="red")
    named = set(caught.value.remedy.removeprefix("known: ").split(", "))
    assert {"terms", "card", "strain_unit", "gauge_length", "area", "cycle", "strain_column_2", *options} <= named
    for wrong, words in [
        ({"mode": "uniaxial", "modes": "planar"}, "mode and modes are both given"),
        ({"width": "3 kPa"}, "width = .*wrong dimension"),
        ({"width": [3]}, "the option width .* of the type list"),
        ({"decimal": "dot"}, "not a decimal mark"),
        ({"zero": "two"}, "the option zero"),
        ({"accuracy": {"stress": "2 %"}}, "the option accuracy stress"),
    ]:
        with pytest.raises(durometer.InputError, match=words):
            read(**{"mode": "uniaxial", **wrong})
    against = read(mode="uniaxial", strain_unit="1").warnings
    assert any("its name gives: leave the option strain_unit out" in warning for warning in against), against


def test_points_beyond_the_protocol_are_noted(pulled: durometer.Scene) -> None:
    curve = durometer.Curve(pulled, "t_s", [0.5, 1.0, 7.0], "xmin_reaction_x_N", [-1e-3, -2e-3, -3e-3], "long")
    found = durometer.Calibration.from_curves([curve], ["laws.silicone.E"], check=False)
    [note] = found.notes
    assert note == "curve long: of 3 data points 1 beyond the range of the protocol in t_s left out"
    with pytest.raises(durometer.InputError, match="accuracy is -1"):
        durometer.Calibration.from_curves([curve], ["laws.silicone.E"], accuracy=-1)


def test_a_biaxial_test_has_two_stretches() -> None:
    second = 1 + 0.5 * (STRETCH - 1)
    nominal = 40e3 * (STRETCH - STRETCH**-3 * second**-2)
    fit = durometer.Fit.from_arrays(STRETCH, nominal, "neo_hookean", mode="biaxial", second_stretch=second, nu=0.45)
    assert abs(fit.constants["mu"] / 40e3 - 1) < 1e-9
    for options, words in [
        ({"mode": "biaxial"}, "a biaxial test has two stretches"),
        ({"second_stretch": second}, "does not go with the mode uniaxial"),
        ({"mode": "biaxial", "second_stretch": second[1:]}, "12 stretches and 11 second"),
        ({"mode": "biaxial", "second_stretch": -second}, "a stretch is -1"),
    ]:
        with pytest.raises(durometer.InputError, match=words):
            durometer.Fit.from_arrays(STRETCH, nominal, "neo_hookean", nu=0.45, **options)


def test_options_are_numbers_in_si_units_too() -> None:
    stress = 40e3 * (STRETCH - STRETCH**-2)
    tables = [durometer.Fit.from_arrays(STRETCH, stress, "neo_hookean", kappa=kappa, nu=None).table for kappa in ("1 MPa", 1e6)]
    assert tables[0] == tables[1] and "kappa" in tables[0]
    assert durometer.Fit.from_arrays(STRETCH, stress, "yeoh", terms=1).units == {"C10": "Pa"}
    ogden = durometer.Fit.from_arrays(STRETCH, stress, "ogden", terms=1, nu=0.45)
    assert ogden.units["alpha1"] == "1"
    for error, given, number in [("stress_zero", "0.5 kPa", 500.0), ("stress_zero", "500 Pa", numpy.float64(500)), ("stress_scale", "2 %", 0.02)]:
        fits = [durometer.Fit.from_arrays(STRETCH, stress, "neo_hookean", nu=0.45, accuracy={error: width}).intervals for width in (given, number)]
        assert fits[0]["mu"] == pytest.approx(fits[1]["mu"], rel=1e-12), error
    for wrong in (None, True, [1.0]):
        with pytest.raises(durometer.InputError, match="the option accuracy stress_scale is .* of the type"):
            durometer.Fit.from_arrays(STRETCH, stress, "neo_hookean", nu=0.45, accuracy={"stress_scale": wrong})
    assert not [warning for warning in durometer.Fit.from_arrays(STRETCH, stress, "neo_hookean").warnings if "--nu" in warning]


@pytest.mark.parametrize("pair", [(1.0, 1.3), [1.0, 1.3], numpy.array([1.0, 1.3])])
def test_a_range_is_any_pair(pair: object) -> None:
    fit = durometer.Fit.from_arrays(STRETCH, 40e3 * (STRETCH - STRETCH**-2), "neo_hookean", nu=0.45, range=pair)
    assert fit.result == durometer.Fit.from_arrays(STRETCH, 40e3 * (STRETCH - STRETCH**-2), "neo_hookean", nu=0.45, range=(1.0, 1.3)).result


def test_the_progress_of_a_fit_is_told() -> None:
    told: list[tuple[float, float]] = []
    arguments = (STRETCH, 40e3 * (STRETCH - STRETCH**-2), "neo_hookean")
    durometer.Fit.from_arrays(*arguments, nu=0.45, progress=lambda done, end: told.append((done, end)))
    assert told and told == sorted(told) and told[-1] == (1.0, 1.0)
    with pytest.raises(durometer.InputError, match="cannot be called"):
        durometer.Fit.from_arrays(*arguments, nu=0.45, progress=5)


def test_the_progress_of_a_calibration_comes_to_its_end(pulled: durometer.Scene, capsys: pytest.CaptureFixture) -> None:
    told: list[tuple[float, float]] = []
    curve = durometer.Curve(pulled, **BOUNDED)
    for progress in (lambda done, end: told.append((done, end)), True):
        durometer.Calibration.from_curves([curve], ["laws.silicone.E"], check=False, progress=progress)
    assert told[-1] == (1.0, 1.0)
    drawn = capsys.readouterr().err
    assert drawn.count("\n") == 1 and drawn.endswith("s\n") and "100.0 %" in drawn.rsplit("\r", 1)[-1]


def test_a_search_that_is_ended_leaves_its_best_values() -> None:
    truth = durometer.Scene.from_toml(PULLED).set("mesh.grid.divisions", [16, 6, 6]).set("stage.0.dt", "0.25 s")
    run = truth.run()
    start = truth.set("laws.silicone.E", "20 kPa").set("laws.silicone.nu", 0.4)
    curve = durometer.Curve(start, "t_s", run.times[1:], "xmin_reaction_x_N", run["xmin_reaction_x_N"][1:])
    seen: list[float] = []

    def told(t: float, end: float) -> None:
        seen.append(t)
        # The third forward solve comes after a better point than the first
        if sum(after < before for before, after in zip(seen, seen[1:])) >= 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as caught:
        durometer.Calibration.from_curves([curve], ["laws.silicone.E", "laws.silicone.nu"], progress=told)
    best = caught.value.result
    assert list(best) == ["laws.silicone.E", "laws.silicone.nu"] and abs(best["laws.silicone.E"] - 100e3) < 80e3


def test_the_table_of_a_fit_has_numbers_that_are_infinite_and_names_options() -> None:
    stretch = numpy.linspace(1.02, 1.3, 15)
    stress = 40e3 * (stretch - stretch**-2) * (1 + 0.01 * numpy.random.default_rng(1).standard_normal(15))
    fit = durometer.Fit.from_arrays(stretch, stress, "gent", nu=0.45)
    # So small stretches do not determine where the chains end
    assert not fit.is_determined and any(numpy.isinf(fit.intervals["J_m"]))

    def all_of(value: object) -> list:
        inside = value.values() if isinstance(value, dict) else value if isinstance(value, list) else None
        return [value] if inside is None else [one for entry in inside for one in all_of(entry)]

    values = all_of(fit.table)
    assert None not in values and any(value == float("inf") for value in values if isinstance(value, float))
    assert not any("--" in value for value in values if isinstance(value, str)) and "--" not in str(fit)
    scene = durometer.Scene.from_toml(PULLED).set("laws.silicone", fit.table)
    assert scene.get("laws.silicone.J_m") == fit.constants["J_m"]


def test_bounds_of_a_number_whose_unit_is_that_of_its_list() -> None:
    points = '{ kind = "points", of = [[0, 0], [1, 2]], unit = "mm" }'
    scene = durometer.Scene.from_toml(PULLED.replace('{ kind = "ramp", from = "0 mm", to = "2 mm", end = "1 s" }', points))
    key = "constraint.prescribed.displacement.of.1.1"
    run = scene.run()
    curve = durometer.Curve(scene.set_si(key, 1.5e-3), "t_s", run.times[1:], "xmin_reaction_x_N", run["xmin_reaction_x_N"][1:])
    for ends in [(1e-3, 4e-3), ("1 mm", "4 mm")]:
        found = durometer.Calibration.from_curves([curve], {key: ends}, check=False)
        assert found.constants[key] == pytest.approx(2e-3, rel=1e-3)


def test_data_of_the_program_are_found_from_any_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    fit = durometer.Fit.from_csv("data/treloar-1944/treloar-1944.csv", "neo_hookean", mode="uniaxial", range=(1.0, 1.6), nu=0.49)
    assert fit.constants["mu"] > 0.0
