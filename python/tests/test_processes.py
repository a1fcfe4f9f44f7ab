"""Scenes, runs and exceptions in other processes and folders."""

import ast
import copy
import multiprocessing
import os
import pickle
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import durometer
import numpy
import pytest
from conftest import BEAM
from durometer._end_values import EndValues

#: Nothing holds it across
FREE = BEAM.replace('region = "xmin"\n\n[[stage', 'region = "xmin"\ncomponents = "y"\n\n[[stage')


def ran(scene: durometer.Scene) -> durometer.Run:
    return scene.run(threads=1)


def test_scenes_runs_and_exceptions_cross_processes(beam: durometer.Scene) -> None:
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        run = pool.submit(ran, beam).result(120)
        here = beam.run()
        assert run.values.tobytes() == here.values.tobytes() and run.nodes.tobytes() == here.nodes.tobytes()
        assert (run.cells == here.cells).all() and run.record["status"] == "Converged" and run.units == here.units
        with pytest.raises(durometer.InputError, match="was pickled"):
            run.gradient({"xmax_z_m": 1.0}, ["laws.silicone.E"])
        with pytest.raises(durometer.RunError) as caught:
            pool.submit(ran, durometer.Scene.from_toml(FREE)).result(120)
        assert caught.value.status == "Singular" and caught.value.fact and caught.value.remedy
        assert isinstance(caught.value.result, durometer.Run)


def test_nodes_and_cells_of_every_run_stay(beam: durometer.Scene) -> None:
    run = beam.run()
    for one in (run, copy.copy(run), pickle.loads(pickle.dumps(run))):
        for array in (one.nodes, one.cells):
            with pytest.raises(ValueError, match="read-only"):
                array += 1
        assert numpy.array_equal(one.nodes, run.nodes) and numpy.array_equal(one.cells, run.cells)


def test_a_copy_of_a_scene_is_the_scene(beam: durometer.Scene) -> None:
    assert copy.copy(beam) is beam and copy.deepcopy(beam) is beam
    again = pickle.loads(pickle.dumps(beam.set("laws.silicone.E", "90 kPa")))
    assert again.get("laws.silicone.E") == "90 kPa" and again.run().converged


def test_what_cannot_be_pickled_says_so(beam: durometer.Scene) -> None:
    for item in (beam.sensitivities(["laws.silicone.E"]), durometer.Study.load("finger-convergence")):
        with pytest.raises(TypeError, match=f"cannot pickle '.*{type(item).__name__}'"):
            pickle.dumps(item)
    error = pickle.loads(pickle.dumps(durometer.RunError("a fact", "a remedy", "Stopped", result=object())))
    assert (error.fact, error.remedy, error.status, error.result) == ("a fact", "a remedy", "Stopped", None)


def test_the_warning_of_derivatives_is_pickled() -> None:
    for warning in (pickle.loads(pickle.dumps(w := durometer.DoubtfulDerivative([("laws.rubber.mu", 1.0, 1e-3)]))), copy.copy(w)):
        assert type(warning) is durometer.DoubtfulDerivative and str(warning) == str(w) and warning.doubtful == w.doubtful


def test_a_scene_keeps_its_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "scene.toml").write_text(BEAM.replace("neo_hookean", "linear"))
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path)
    scene = durometer.Scene.from_toml("scene.toml")
    (tmp_path / "law.toml").write_text('law = "neo_hookean"\nE = "100 kPa"\nnu = 0.45\n')
    including = durometer.Scene.from_toml(BEAM)
    monkeypatch.chdir(tmp_path / "other")
    assert scene.run().converged
    assert including.set("laws.soft", {"include": "law.toml"}).get("laws.soft.law") == "neo_hookean"


@pytest.mark.skipif(sys.platform in ("win32", "darwin"), reason="processes are forked on Linux")
def test_a_forked_process_is_refused_where_it_would_wait_for_ever(beam: durometer.Scene) -> None:
    run = beam.run(threads=2)
    unbuilt = {threads: durometer.Scene.from_toml(BEAM) for threads in (1, 2)}
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            said = []
            x, y = run.times[1:], run["xmax_z_m"][1:]
            for threads in (2, 1):
                for work in (
                    lambda: beam.run(threads=threads),
                    lambda: durometer.Fit.from_arrays([1.2, 1.4], [2e4, 4e4], "neo_hookean", nu=0.45, threads=threads),
                    lambda: durometer.Calibration.from_curves([durometer.Curve(beam, "t_s", x, "xmax_z_m", y)], ["laws.silicone.E"], threads=threads, check=False),
                    lambda: EndValues(unbuilt[threads], ["laws.silicone.E"], ["xmax_z_m"], "auto", threads).start,
                ):
                    try:
                        work()
                        said.append("done")
                    except durometer.InputError as error:
                        said.append(error.remedy)
            os.write(writer, "|".join(said).encode())
        finally:
            os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as pipe:
        said = pipe.read().split("|")
    os.waitpid(child, 0)
    assert len(said) == 8 and all("spawn" in remedy and "threads=1" in remedy for remedy in said[:4])
    assert said[4:] == ["done"] * 4


@pytest.mark.skipif(sys.platform in ("win32", "darwin"), reason="processes are forked on Linux")
def test_a_process_that_is_forked_after_the_program_does_not_wait_for_ever(tmp_path: Path) -> None:
    # The program raises the number of threads itself, while it runs
    (tmp_path / "scene.toml").write_text(BEAM)
    code = """
import durometer, multiprocessing
scene = durometer.Scene.from_toml("scene.toml")
simulate = ["simulate", "scene.toml", "--no-view", "--threads", "2", "--out", "out"]
assert durometer.main(simulate) == 0
def run(_):
    try:
        return scene.run(threads=2).status
    except durometer.InputError as error:
        return error.fact
def program(_):
    # A run of one thread before: the number of threads does not tell that there were others
    scene.run(threads=1)
    return durometer.main(simulate)
if __name__ == "__main__":
    with multiprocessing.get_context("fork").Pool(1) as pool:
        said = pool.map_async(run, [0]).get(60) + pool.map_async(program, [0]).get(60)
    open("said", "w").write(repr(said))
"""
    told = subprocess.run([sys.executable, "-P", "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert told.returncode == 0, (told.stdout, told.stderr)
    fact, code_of_program = ast.literal_eval((tmp_path / "said").read_text())
    assert "was forked" in fact and code_of_program == 0
