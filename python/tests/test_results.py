"""Shapes, units and types of results."""

import pickle
import sys
import time
import warnings
from pathlib import Path

import durometer
import numpy
import pytest
from conftest import BEAM, LOCKED, PULLED, REFINED, program


def test_arrays_have_the_shapes_that_are_documented(beam: durometer.Scene) -> None:
    run = beam.run(fields=["displacement", "von_mises"])
    nodes, cells = len(run.nodes), len(run.cells)
    assert run.values.shape == (3, len(run.columns)) and len(run) == 3
    assert run.nodes.shape == (45, 3) and run.cells.shape[1] == 4 and run.cells.max() == nodes - 1
    assert run.displacements.shape == (3, nodes, 3)
    assert run.fields["von_mises_Pa"].shape == (3, nodes, 1)
    assert run.cell_fields["von_mises_Pa"].shape == (3, cells, 1)
    assert list(run.field_times) == list(run.times) == [0.0, 0.5, 1.0]
    assert run.signals.shape == (3, len(run.signal_names))


def test_columns_are_views_and_have_units(beam: durometer.Scene) -> None:
    run = beam.run()
    assert numpy.shares_memory(run["xmax_z_m"], run.values)
    assert run.units["xmax_z_m"] == "m" and run.units["t_s"] == "s" and run.units["xmin_reaction_z_N"] == "N"
    assert "xmax_z_m" in run and "xmax" not in run


def test_what_was_recorded_cannot_be_written_into(beam: durometer.Scene) -> None:
    run = beam.run(fields=["displacement", "von_mises"])
    found = beam.sensitivities(["laws.silicone.E"])
    before, derivatives = run.values.copy(), found.values.copy()
    with pytest.raises(ValueError, match="read-only"):
        run["xmax_z_m"] *= 1e3
    times = run.times
    with pytest.raises(ValueError, match="read-only"):
        times *= 1e3
    assert numpy.array_equal(run.values, before)
    for one in (run, pickle.loads(pickle.dumps(run))):
        arrays = [one.values, one["xmax_z_m"], one.times, one.signals, one.nodes, one.cells, one.field_times, one.displacements]
        arrays += [*one.fields.values(), *one.cell_fields.values()]
        assert not any(array.flags.writeable for array in arrays)
    assert not any(array.flags.writeable for array in (found.values, found.errors, found.times, found["xmax_z_m", "laws.silicone.E"]))
    # What is made of them is the user's
    frame = run.frame
    frame["xmax_z_m"] *= 1e3
    frame.iloc[0, 0] = 77.0
    of_keys = found.frame
    of_keys.iloc[0, 0] = 77.0
    gradient = run.gradient({"xmax_z_m": 1.0}, ["laws.silicone.E"])
    gradient *= 2.0
    assert numpy.array_equal(run.values, before) and numpy.array_equal(found.values, derivatives)


def test_displacements_move_the_nodes_of_the_probe(beam: durometer.Scene) -> None:
    run = beam.run(fields=["displacement"])
    tip = run.nodes[:, 0] > 19.9e-3
    # The probe is a mean over the area, this one over the nodes: both sink by about the same
    sunk = run.displacements[-1][tip, 2].mean()
    recorded = run["xmax_z_m"][-1] - run["xmax_z_m"][0]
    assert sunk < 0 and abs(sunk / recorded - 1) < 0.05


def test_a_frame_has_the_numbers_and_carries_units(beam: durometer.Scene) -> None:
    run = beam.run()
    frame = run.to_pandas()
    assert list(frame.index) == list(run.times) and frame.index.name == "t_s"
    assert frame.attrs["units"]["xmax_z_m"] == "m"
    assert frame["xmax_z_m"].to_numpy().tobytes() == run["xmax_z_m"].copy().tobytes()


def test_the_record_is_that_of_the_program(beam: durometer.Scene) -> None:
    record = beam.run().record
    assert record["status"] == "Converged" and record["mesh"]["cells"] > 0


def test_sensitivities_agree_with_differences_of_runs(pulled: durometer.Scene) -> None:
    scene = pulled.set("numerics.tolerance", 1e-12)
    found = scene.sensitivities(["laws.silicone.E", "effect.gravity.density"])
    assert found.values.shape == (3, len(found.columns), 2)
    assert found.times[-1] == 1.0 and found.run["xmax_z_m"].shape == (3,)
    for key, step, unit in [("laws.silicone.E", 100.0, "Pa"), ("effect.gravity.density", 1.0, "kg/m^3")]:
        value = {"laws.silicone.E": 100e3, "effect.gravity.density": 1070.0}[key]
        column = "xmin_reaction_x_N" if "laws" in key else "xmax_z_m"
        plus, minus = (scene.set(key, f"{value + sign * step} {unit}").run()[column][-1] for sign in (1, -1))
        difference = (plus - minus) / (2 * step)
        # Central differences of a step of a thousandth are off by 1e-6 of the derivative, and by rounding less
        assert abs(found[column, key][-1] / difference - 1) < 1e-5
    frame = found.frame
    assert frame["xmax_z_m", "effect.gravity.density"].iloc[-1] == found["xmax_z_m", "effect.gravity.density"][-1]


def test_meshes_go_to_meshio(beam: durometer.Scene, tmp_path: Path) -> None:
    pytest.importorskip("meshio")
    mesh = beam.run(fields=["displacement", "von_mises"]).to_meshio()
    assert mesh.cells[0].type == "tetra" and mesh.point_data["displacement_m"].shape == (45, 3)
    mesh.point_data["displacement_m"] *= 2.0
    mesh.points += 1.0
    mesh.write(tmp_path / "beam.msh")
    assert (tmp_path / "beam.msh").stat().st_size > 1000


def test_a_field_that_is_named_twice_is_recorded_once(beam: durometer.Scene) -> None:
    expected = beam.run(fields=["displacement", "von_mises"])
    run = beam.run(fields=["displacement", "von_mises", "displacement"])
    assert list(run.fields) == list(expected.fields) and run.displacements.tobytes() == expected.displacements.tobytes()
    of_scene = beam.set("output", {"fields": {"what": ["displacement", "displacement"]}}).run()
    assert of_scene.displacements.tobytes() == expected.displacements.tobytes()


def test_a_body_is_displaced_where_its_displacements_are_recorded(beam: durometer.Scene) -> None:
    pytest.importorskip("pyvista")
    for fields, moves in [(["stress"], False), (["stress", "displacement"], True)]:
        run = beam.run(fields=fields)
        assert (numpy.abs(run.to_pyvista().points - run.nodes).max() > 1e-6) == moves


@pytest.mark.parametrize("call, extra", [("to_pyvista", "view"), ("to_meshio", "mesh"), ("to_pandas", "pandas")])
def test_a_missing_extra_names_its_install(beam: durometer.Scene, monkeypatch, call: str, extra: str) -> None:
    for module in ["pyvista", "meshio", "pandas"]:
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(durometer.MissingExtra) as caught:
        getattr(beam.run(), call)()
    assert caught.value.remedy == f'pip install "durometer[{extra}]"'
    assert isinstance(caught.value, ImportError)


def test_limits_of_a_run_are_warnings_and_notes(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(LOCKED)
    told = program("simulate", tmp_path / "scene.toml", "--out", tmp_path / "out", "--no-view", "--threads", 1)
    with pytest.warns(UserWarning, match="locking alarm: the pressures scatter by .*; take formulation") as caught:
        run = durometer.Scene.from_toml(LOCKED).run()
    for warning in caught:
        assert str(warning.message) in told.stdout + told.stderr
    assert {warning.filename for warning in caught} == {__file__}
    assert run.warnings == [str(warning.message) for warning in caught] == pickle.loads(pickle.dumps(run)).warnings
    # A column that buckles under its own weight
    ramp = 'acceleration = { kind = "ramp", from = "0 m/s^2", to = "9.81 m/s^2", end = "1 s" }'
    tall = BEAM.replace('"20 mm", "10 mm", "10 mm"', '"80 mm", "4 mm", "4 mm"').replace("divisions = [4, 2, 2]", "divisions = [20, 1, 1]")
    tall = tall.replace("[0, 0, -1]", "[-1, 0, 0]").replace('acceleration = "9.81 m/s^2"', ramp).replace('E = "100 kPa"', 'E = "60 kPa"')
    scene = durometer.Scene.from_toml(tall)
    run = scene.run()
    assert any("the equilibrium is unstable" in note for note in run.notes)
    assert run.notes == run.record["notes"] == pickle.loads(pickle.dumps(run)).notes
    assert any("cells across the thinnest wall" in note for note in scene.notes)


def test_a_warning_that_is_an_exception_loses_nothing() -> None:
    scene = durometer.Scene.from_toml(LOCKED)

    class Own(Exception):
        """Of the user."""

    def failing(t: float, end: float) -> None:
        raise Own

    def interrupted(t: float, end: float) -> None:
        raise KeyboardInterrupt

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UserWarning, match="locking alarm") as warned:
            scene.run()
        assert warned.value.result.converged and str(warned.value) in warned.value.result.warnings
        with pytest.raises(UserWarning, match="locking alarm") as warned:
            scene.sensitivities(["laws.silicone.E"])
        assert isinstance(warned.value.result, durometer.Sensitivities)
        for kind, progress in ((Own, failing), (KeyboardInterrupt, interrupted)):
            for check in (True, False):
                with pytest.raises(kind) as raised:
                    scene.set("stage.0.dt", "0.01 s").run(progress=progress, check=check)
                assert isinstance(raised.value.result, durometer.Run)
        with pytest.raises(durometer.RunError):
            scene.set("constraint.0.components", "y").run()


def test_derivatives_that_end_early_have_the_times_of_their_rows() -> None:
    text = BEAM.replace('E = "100 kPa"', 'E = "5 kPa"').replace('integrator = "static"\nduration = "1 s"\ndt = "0.5 s"', MOVING)
    scene = durometer.Scene.from_toml(text.replace('[[probe]]\nkind = "energy"\n', "") + FALLING)
    with pytest.raises(durometer.RunError) as caught:
        scene.sensitivities(["laws.silicone.E"])
    assert caught.value.status == "NoDerivative"
    found = scene.sensitivities(["laws.silicone.E"], check=False)
    assert 1 < len(found.times) < len(found.run) and len(found.times) == len(found.values) == len(found["xmax_z_m", "laws.silicone.E"])
    assert list(found.times) == list(found.frame.index) == list(found.run.times[: len(found.times)])


MOVING = 'integrator = { kind = "generalised_alpha", rho = 0.5 }\nduration = "0.1 s"\ndt = "0.002 s"'
#: The beam swings onto a floor
FALLING = """
[[effect]]
kind = "inertia"
region = "body"
density = "1070 kg/m^3"
mass = "consistent"

[[contact]]
name = "floor"
region = "zmin"
obstacle = { kind = "floor", point = ["0 mm", "0 mm", "-1 mm"], normal = [0, 0, 1] }
response = "penalty"
friction = 0
"""


def test_a_refinement_that_misses_its_tolerance_is_no_success() -> None:
    scene = durometer.Scene.from_toml(REFINED)
    with pytest.raises(durometer.RunError, match="the error bar is above the tolerance on every mesh") as missed:
        scene.run()
    run = missed.value.result
    assert missed.value.status == "ToleranceMissed" and "more `meshes`" in missed.value.remedy and run.converged
    with pytest.warns(UserWarning, match="the error bar is above the tolerance on every mesh"):
        assert scene.run(check=False).warnings == run.warnings


def test_the_cost_of_a_run_is_without_what_is_done_for_python() -> None:
    scene = durometer.Scene.from_toml(
        PULLED.replace('{ kind = "ramp", from = "0 mm", to = "2 mm", end = "1 s" }', '{ kind = "controlled", initial = "0 mm" }')
    )
    # The scene is assembled before the clocks are read
    assert scene.columns
    clocks = [time.perf_counter, time.process_time]
    answers = numpy.zeros(2)

    def read() -> numpy.ndarray:
        return numpy.array([clock() for clock in clocks])

    def control(now: durometer.Observation) -> None:
        began = read()
        while time.process_time() < began[1] + 0.1:
            pass
        answers[:] += read() - began

    began = read()
    record = scene.run(threads=1, controller=control).record
    whole = read() - began
    # The answers lie within the run, and the run within the whole, by the same clocks: so it is on a machine of any speed and load
    assert record["wall_s"] + answers[0] <= whole[0] and record["cpu_s"] + answers[1] <= whole[1]
    assert record["phases"]["build_s"] > 0.0
