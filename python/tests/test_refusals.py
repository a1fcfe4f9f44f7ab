"""Bad input: typed exceptions with fact and remedy, and partial results where a run does not complete."""

import types
from collections import UserList
from pathlib import Path

import durometer
import numpy
import pytest
from conftest import BEAM


@pytest.mark.parametrize(
    "source, words",
    [
        ("no-such-scene.toml", "no such file"),
        (BEAM.replace("divisions", "division"), "unknown key `division`"),
        (BEAM.replace('E = "100 kPa"', 'E = "100 mm"'), "wrong dimension"),
        ("[mesh\n", "line 1"),
    ],
    ids=["file", "key", "unit", "syntax"],
)
def test_a_wrong_scene_is_refused(source: str, words: str) -> None:
    with pytest.raises(durometer.InputError, match=words) as caught:
        durometer.Scene.from_toml(source).run()
    assert caught.value.status == "Refused" and caught.value.fact and isinstance(caught.value, ValueError)


def test_a_text_is_told_from_the_files_of_its_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("scene.toml", "study.toml"):
        (tmp_path / name).write_text(BEAM)
    with pytest.raises(durometer.InputError, match="<text>, line 2: unknown key `foo`"):
        durometer.Scene.from_toml("[mesh]\nfoo = 1\n")
    with pytest.raises(durometer.InputError, match="<text>, line 1: unknown key `foo`"):
        durometer.Scene.from_toml("mesh = { foo = 1 }")
    with pytest.raises(durometer.InputError, match="<text>: laws.silicone: ") as caught:
        durometer.Scene.from_toml(BEAM.replace("nu = 0.45", "nu = 0.6")).run()
    assert "scene.toml" not in str(caught.value)
    assert durometer.Scene.from_toml(".").columns
    for load in (durometer.Scene.from_toml, durometer.Study.load):
        with pytest.raises(durometer.InputError, match="is empty; give its path"):
            load("")


@pytest.mark.parametrize("source", [3, None, ["a"]])
def test_a_scene_is_a_text_or_a_path(source: object) -> None:
    with pytest.raises(TypeError):
        durometer.Scene.from_toml(source)


@pytest.mark.parametrize(
    "key, value, words",
    [
        ("laws.silicon.E", "1 kPa", "there is no \"silicon\""),
        ("laws.silicone.E", object(), "of the type object"),
        ("stage.0.max_steps", 10**30, "too large for a whole number"),
        ("mesh.grid", {1: 2}, "the key 1 is no text"),
        ("mesh.grid.divisions", b"abc", "of the type bytes"),
        ("laws.silicone.E", float("nan"), "nan is not a finite number"),
        ("laws.silicone.nu", numpy.float64("nan"), "nan is not a finite number"),
        ("laws.silicone.nu", 0.5, "0.5"),
        ("stage.0.dt", 1, "dt|time|unit"),
    ],
)
def test_a_wrong_change_is_refused(beam: durometer.Scene, key: str, value: object, words: str) -> None:
    with pytest.raises(durometer.InputError, match=words):
        beam.set(key, value).run()


def test_numbers_of_numpy_are_values(beam: durometer.Scene) -> None:
    changed = beam.set("laws.silicone.nu", numpy.float64(0.4)).set("mesh.grid.divisions", numpy.array([2, 1, 1]))
    assert changed.get("laws.silicone.nu") == 0.4 and changed.get("mesh.grid.divisions") == [2, 1, 1]
    assert changed.run().converged


def test_a_path_is_a_value(beam: durometer.Scene) -> None:
    path = Path("laws") / "soft.toml"
    assert beam.set("title", path).get("title") == str(path)


def test_a_fact_and_a_remedy_are_told_apart(beam: durometer.Scene) -> None:
    with pytest.raises(durometer.InputError) as caught:
        beam.set("probe.0.region", "xmaks").run()
    assert 'there is no region "xmaks"' in caught.value.fact
    assert "did you mean `xmax`?" in caught.value.remedy


def test_a_run_that_does_not_complete_keeps_its_rows(beam: durometer.Scene) -> None:
    free = beam.set("constraint.0.components", "y").set("stage.0.dt", "0.5 s")
    with pytest.raises(durometer.RunError) as caught:
        free.run()
    assert caught.value.status == "Singular" and caught.value.remedy and isinstance(caught.value, RuntimeError)
    partial = caught.value.result
    assert isinstance(partial, durometer.Run) and len(partial) == 1 and not partial.converged
    unchecked = free.run(check=False)
    assert unchecked.status == "Singular" and unchecked.fact and unchecked.remedy == caught.value.remedy


def test_columns_and_options_that_are_not_there_are_named(beam: durometer.Scene) -> None:
    run = beam.run()
    with pytest.raises(KeyError, match="did you mean `xmax_z_m`"):
        run["xmax_zm"]
    with pytest.raises(durometer.InputError, match="has recorded no displacements"):
        run.displacements
    with pytest.raises(durometer.InputError, match="unknown variant"):
        beam.run(fields=["displacements"])
    with pytest.raises(durometer.InputError, match="no key is given"):
        beam.sensitivities([])
    with pytest.raises(durometer.InputError, match="no path to a key"):
        beam.sensitivities(["E"])
    with pytest.raises(durometer.InputError, match="cannot be called"):
        beam.run(progress=3)


@pytest.mark.parametrize(
    "stretch, stress, words",
    [
        ([1.1, 1.2], [1.0], "2 stretches and 1 stresses"),
        ([[1.1], [1.2]], [1.0, 2.0], "shape"),
        ([1.1, float("nan")], [1.0, 2.0], "stretch has the value NaN at index 1"),
        ([1.1, -1.0], [1.0, 2.0], "a stretch is -1"),
        (["a", "b"], [1.0, 2.0], "no array of numbers"),
    ],
    ids=["length", "shape", "nan", "sign", "type"],
)
def test_wrong_arrays_of_a_fit_are_refused(stretch: object, stress: object, words: str) -> None:
    with pytest.raises(durometer.InputError, match=words):
        durometer.Fit.from_arrays(stretch, stress, "neo_hookean")


def test_wrong_options_of_a_fit_are_all_named() -> None:
    with pytest.raises(durometer.InputError, match="no option colour, size") as caught:
        durometer.Fit.from_arrays([1.1, 1.2, 1.3], [1e3, 2e3, 3e3], "neo_hookean", colour="red", size=3)
    assert caught.value.remedy.startswith("known: terms")


def test_a_wrong_study_or_report_is_refused(tmp_path: Path) -> None:
    with pytest.raises(durometer.InputError, match="no such file"):
        durometer.Study.load("no-such-study")
    with pytest.raises(durometer.InputError, match="there is no report"):
        durometer.Report(tmp_path)
    (tmp_path / "summary.json").write_text("{")
    with pytest.raises(durometer.InputError, match="is damaged"):
        durometer.Report(tmp_path)


def test_a_value_that_contains_itself_is_refused(beam: durometer.Scene) -> None:
    endless: list[object] = []
    endless.append(endless)
    around: dict[str, object] = {}
    around["a"] = [around]
    for value in (endless, around):
        with pytest.raises(durometer.InputError, match="more than 32 deep in each other"):
            beam.set("mesh.grid.divisions", value)


def test_sequences_and_mappings_are_values(beam: durometer.Scene) -> None:
    for divisions in (range(2, 5), UserList([2, 3, 4]), (2, 3, 4)):
        assert beam.set("mesh.grid.divisions", divisions).get("mesh.grid.divisions") == [2, 3, 4]
    grid = types.MappingProxyType({"kind": "box", "size": ["20 mm", "10 mm", "10 mm"], "divisions": (1, 1, 1)})
    assert beam.set("mesh.grid", grid).run().converged


def test_key_and_unit_of_a_constant_of_a_law_are_checked_when_it_is_set(beam: durometer.Scene) -> None:
    with pytest.raises(durometer.InputError, match='"100 mm" has the wrong dimension'):
        beam.set("laws.silicone.E", "100 mm")
    for key, value in [("laws.silicone.foo", 3), ("laws.silicone", {"law": "neo_hookean", "E": "1 kPa", "foo": 3})]:
        with pytest.raises(durometer.InputError, match="law `neo_hookean` has no parameter `foo`"):
            beam.set(key, value)
    with pytest.raises(durometer.InputError, match='"foo" leads nowhere: there is no "foo"'):
        beam.get("foo")
    # What other keys decide is not
    assert beam.set("laws.silicone.law", "gent").get("laws.silicone.law") == "gent"


def test_masked_values_are_refused(pulled: durometer.Scene) -> None:
    masked = numpy.ma.masked_array([1e3, 2e3, 1e9], mask=[0, 0, 1])
    with pytest.raises(durometer.InputError, match="stress has masked values"):
        durometer.Fit.from_arrays([1.1, 1.2, 1.3], masked, "neo_hookean", nu=0.45)
    curve = durometer.Curve(pulled, "t_s", [0.2, 0.5, 1.0], "xmin_reaction_x_N", masked)
    with pytest.raises(durometer.InputError, match="y has masked values"):
        durometer.Calibration.from_curves([curve], ["laws.silicone.E"])
    assert durometer.Fit.from_arrays([1.1, 1.2, 1.3], numpy.ma.masked_array([1e3, 2e3, 3e3]), "neo_hookean", nu=0.45).constants


@pytest.mark.parametrize("threads, words", [(0, "whole number of 1 or more"), (-1, "whole number of 1 or more"), (10**30, "give"), (100_000, "only wait"), (1.5, "no whole number")])
def test_threads_have_the_limits_of_the_program(beam: durometer.Scene, threads: object, words: str) -> None:
    with pytest.raises(durometer.InputError, match=words):
        beam.run(threads=threads)
    assert beam.run(threads=numpy.int64(1)).converged


def test_a_text_is_no_list_of_names(beam: durometer.Scene) -> None:
    run = beam.run()
    for call in (
        lambda: beam.sensitivities("laws.silicone.E"),
        lambda: beam.run(fields="displacement"),
        lambda: run.gradient({"xmax_z_m": 1.0}, "laws.silicone.E"),
        lambda: durometer.Calibration.from_curves([durometer.Curve(beam, "t_s", [1.0], "xmax_z_m", [1.0])], "laws.silicone.E"),
    ):
        with pytest.raises(durometer.InputError, match="no list of names"):
            call()
    with pytest.raises(durometer.InputError, match="one text"):
        durometer.main("simulate --help")


def test_what_is_no_curve_and_no_weight_is_named(beam: durometer.Scene) -> None:
    run = beam.run()
    curve = lambda **other: durometer.Curve(**{"scene": beam, "over": "t_s", "x": [1.0], "column": "xmax_z_m", "y": [1.0], **other})  # noqa: E731
    for call, words in [
        (lambda: durometer.Calibration.from_curves([(1, 2)], ["laws.silicone.E"]), "a curve is of the type tuple, and no durometer.Curve; give a list"),
        (lambda: durometer.Calibration.from_curves([curve(), 3], ["laws.silicone.E"]), "a curve is of the type int"),
        (lambda: durometer.Calibration.from_curves([curve(scene="x")], ["laws.silicone.E"]), "the scene of a curve is of the type str"),
        (lambda: durometer.Calibration.from_curves([curve(over=3)], ["laws.silicone.E"]), "over of a curve is of the type int, and no text"),
        (lambda: run.gradient({"xmax_z_m": "a"}, ["laws.silicone.E"]), "the weight of xmax_z_m is of the type str, and no number; give a number"),
    ]:
        with pytest.raises(durometer.InputError, match=words):
            call()


def test_one_curve_is_no_list(beam: durometer.Scene) -> None:
    curve = durometer.Curve(beam, "t_s", [1.0], "xmax_z_m", [1.0])
    with pytest.raises(durometer.InputError, match="curves is of the type Curve, and no list; give a list of durometer.Curve"):
        durometer.Calibration.from_curves(curve, ["laws.silicone.E"])


def test_a_whole_number_in_si_units_stays_one(beam: durometer.Scene) -> None:
    key = "mesh.grid.divisions.0"
    again = beam.set_si(key, beam.get_si(key))
    assert again.get(key) == 4 and isinstance(again.get(key), int) and again.run().converged
    assert beam.set_si(key, 2).get("mesh.grid.divisions") == [2, 2, 2]
    assert beam.set_si("effect.gravity.direction.0", 0.5).get("effect.gravity.direction") == [0.5, 0, -1]


def test_output_is_set_where_the_scene_has_none(beam: durometer.Scene) -> None:
    run = beam.set("output.fields", {"what": ["displacement"]}).run()
    assert list(run.fields) == ["displacement_m"]


def test_a_run_has_columns_by_name(beam: durometer.Scene) -> None:
    run = beam.run()
    assert 3 not in run and "t_s" in run
    for call in (lambda: run[0], lambda: list(run)):
        with pytest.raises(TypeError, match="columns by name"):
            call()


@pytest.mark.parametrize(
    "options, words",
    [
        ({"kappa": []}, "the option kappa is .* of the type list"),
        ({"kappa": "1 mm"}, "kappa: .*wrong dimension"),
        ({"nu": "x"}, "the option nu is x of the type str"),
        ({"terms": "x"}, "the option terms"),
        ({"range": "1:1.2"}, "the option range"),
        ({"nu": 0.45, "range": (1.0, 1.01)}, "widen the option range"),
        ({"range": (1.6, 1.0)}, r"the option range is 1.6 to 1: the first stretch must be the smaller one; give two stretches such as \(1.0, 1.6\)"),
        ({"range": [1.1]}, "the option range"),
    ],
)
def test_a_wrong_option_of_a_fit_is_named(options: dict, words: str) -> None:
    with pytest.raises(durometer.InputError, match=words):
        durometer.Fit.from_arrays([1.1, 1.2, 1.3], [1e3, 2e3, 3e3], "neo_hookean", **options)


def test_remedies_name_what_there_is_in_python(beam: durometer.Scene) -> None:
    with pytest.raises(durometer.InputError, match="Scene.sensitivities"):
        beam.set("stage.0.integrator", "implicit_euler").check_gradient()
    with pytest.raises(durometer.InputError, match='no isolation "x"') as caught:
        durometer.Study.load("finger-convergence").run(isolation="x")
    assert "threads" in caught.value.remedy
