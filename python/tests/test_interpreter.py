"""Python continues while a scene runs, can end the run, and gets its memory back."""

import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import durometer
import psutil
import pytest
from conftest import BEAM, PULLED

#: Steps that take several seconds in total
LONG = BEAM.replace('dt = "0.5 s"', 'dt = "0.0002 s"')


def test_other_threads_go_on_while_a_scene_runs() -> None:
    scene = durometer.Scene.from_toml(BEAM.replace('dt = "0.5 s"', 'dt = "0.004 s"'))
    scene.columns  # the scene is assembled before the count
    state = {"count": 0, "runs": True}

    def count() -> None:
        while state["runs"]:
            state["count"] += 1
            time.sleep(0)

    thread = threading.Thread(target=count)
    thread.start()
    try:
        before, start = state["count"], time.monotonic()
        run = scene.run(threads=1)
        counted, seconds = state["count"] - before, time.monotonic() - start
    finally:
        state["runs"] = False
        thread.join()
    assert run.converged
    # A thread that is locked out counts nothing, or at most once in each pause of 50 ms
    assert counted > 20 * (1 + seconds / 0.05), f"{counted} in {seconds} s"


def test_progress_is_told_and_an_exception_in_it_ends_the_run() -> None:
    told = []
    scene = durometer.Scene.from_toml(BEAM.replace('dt = "0.5 s"', 'dt = "0.002 s"'))
    scene.run(progress=lambda t, end: told.append((t, end)))
    assert told and told == sorted(told) and all(end == 1.0 and 0 <= t <= 1 for t, end in told)

    def fails(t: float, end: float) -> None:
        raise ZeroDivisionError("of the user")

    with pytest.raises(ZeroDivisionError, match="of the user"):
        durometer.Scene.from_toml(LONG).run(progress=fails)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_interrupts_a_run(tmp_path: Path) -> None:
    # A parent that runs in the background of a shell ignores SIGINT, which Python inherits
    code = f"""
import durometer, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
scene = durometer.Scene.from_toml({LONG!r})
scene.columns
def told(t, end):
    print("runs", flush=True)
try:
    scene.run(progress=told)
except KeyboardInterrupt:
    print("interrupted", flush=True)
    # The scene can run again
    again = scene.set("stage.0.dt", "0.5 s").run()
    sys.exit(0 if again.converged else 1)
sys.exit(1)
"""
    process = subprocess.Popen([sys.executable, "-P", "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline().strip() == "runs"
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate(timeout=120)
    assert "interrupted" in said and process.returncode == 0


def test_a_thousand_runs_leave_no_memory_behind() -> None:
    text = BEAM.replace("divisions = [4, 2, 2]", "divisions = [1, 1, 1]").replace('dt = "0.5 s"', 'dt = "1 s"')
    scene = durometer.Scene.from_toml(text)
    process = psutil.Process()

    def runs(count: int) -> int:
        for _ in range(count):
            # A new scene each time, which is assembled anew
            scene.set("laws.silicone.E", "90 kPa").run(threads=1, fields=["displacement"])
        return process.memory_info().rss

    after_warming_up = runs(200)
    grown = runs(1000) - after_warming_up
    # One run keeps some 100 kB of system, factor and arrays; a hundredth of it each would be 1 MB. Allocators and the pools of threads may
    # keep some pages: 8 kB a run
    assert grown < 8 << 20, f"{grown / 1e6} MB"


def test_runs_of_several_threads_of_python_are_the_same(beam: durometer.Scene) -> None:
    expected = beam.run().values.tobytes()
    results: list[bytes] = []
    threads = [threading.Thread(target=lambda: results.append(beam.run().values.tobytes())) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [expected] * 4


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_ends_a_fit_and_a_gradient(tmp_path: Path) -> None:
    # Each takes several seconds in total, and ends within a second
    code = f"""
import durometer, numpy, os, signal, sys, threading, time
signal.signal(signal.SIGINT, signal.default_int_handler)
stretch = numpy.linspace(1.01, 6, 400)
stress = 4e4 * (stretch - stretch**-2) * (1 + 0.01 * stretch**2) * (1 + 0.01 * numpy.random.default_rng(0).standard_normal(400))
run = durometer.Scene.from_toml({BEAM.replace("[4, 2, 2]", "[40, 8, 8]").replace('dt = "0.5 s"', 'dt = "1 s"')!r}).run(threads=1)
keys = [f"mesh.grid.size.{{k}}" for k in range(3)] + ["effect.gravity.density"] + [f"effect.gravity.direction.{{k}}" for k in range(3)]
for work in (
    lambda: durometer.Fit.from_arrays(stretch, stress, "ogden", nu=0.499, terms=4),
    lambda: run.gradient({{"xmax_z_m": 1.0}}, keys),
):
    start = time.monotonic()
    threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
    try:
        work()
        time.sleep(1)
        sys.exit("it was done before")
    except KeyboardInterrupt:
        print(time.monotonic() - start, flush=True)
"""
    told = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, timeout=120)
    seconds = [float(line) for line in told.stdout.split()]
    assert told.returncode == 0 and len(seconds) == 2 and max(seconds) < 1.5, (told.stdout, told.stderr)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_ends_the_assembly_and_the_check_of_a_law() -> None:
    # Each asks the law thousands of times, a millisecond each
    code = f"""
import durometer, os, signal, threading, time
import test_laws
signal.signal(signal.SIGINT, signal.default_int_handler)
state = {{"pause": 0.0, "begun": False, "after": 0, "hit": False}}

class Slow(test_laws.PythonNeoHookean):
    name = "python_slow"

    def energy(self, F):
        state["begun"] |= state["pause"] > 0
        state["after"] += state["hit"]
        time.sleep(state["pause"])
        return super().energy(F)

durometer.register_law(Slow)
scene = durometer.Scene.from_toml({BEAM!r}.replace("neo_hookean", Slow.name))

def interrupt():
    while not state["begun"]:
        time.sleep(0.01)
    state["hit"] = True
    os.kill(os.getpid(), signal.SIGINT)

state["pause"] = 0.001
for work in (lambda: scene.columns, lambda: durometer.check_law(Slow.name)):
    state.update(begun=False, after=0, hit=False)
    thread = threading.Thread(target=interrupt)
    thread.start()
    try:
        work()
    except KeyboardInterrupt:
        print(state["after"], flush=True)
    thread.join()
# Nothing is left of what was ended
state["pause"] = 0.0
assert scene.run().converged
"""
    folder = Path(__file__).parent
    told = subprocess.run([sys.executable, "-P", "-c", f"import sys; sys.path.insert(0, {str(folder)!r})\n{code}"], capture_output=True, text=True, timeout=200)
    asked = [int(line) for line in told.stdout.split()]
    assert told.returncode == 0 and len(asked) == 2 and max(asked) < 500, (told.stdout, told.stderr)


def test_laws_and_controllers_can_run_scenes() -> None:
    # All threads may be in the law at once, so that the runs in it find no free thread
    code = f"""
import durometer
import test_laws

TEXT = {BEAM.replace('dt = "0.5 s"', 'dt = "1 s"')!r}
inner = durometer.Scene.from_toml(TEXT)
expected = inner.run()["xmax_z_m"][-1]
heights, state = [], {{"calls": 0, "runs": False}}

class OfAScene(test_laws.PythonNeoHookean):
    name = "python_of_a_scene"

    def stress(self, F):
        state["calls"] += 1
        if state["runs"] and state["calls"] % 100 == 0:
            heights.append(inner.run(threads=2)["xmax_z_m"][-1])
        return super().stress(F)

durometer.register_law(OfAScene)
outer = durometer.Scene.from_toml(TEXT.replace("neo_hookean", OfAScene.name).replace("[4, 2, 2]", "[8, 6, 5]"))
outer.columns
state["runs"] = True
assert outer.run(threads=2).converged and len(heights) > 10 and set(heights) == {{expected}}

heights.clear()
pulled = durometer.Scene.from_toml({PULLED!r}.replace('displacement = {{ kind = "ramp", from = "0 mm", to = "2 mm", end = "1 s" }}', 'displacement = {{ kind = "controlled", initial = "0 mm" }}'))
def control(now):
    heights.append(inner.run()["xmax_z_m"][-1])
    return 1e-3 * now.next
assert pulled.run(threads=2, controller=control).converged and heights and set(heights) == {{expected}}
print("done", flush=True)
"""
    folder = Path(__file__).parent
    told = subprocess.run([sys.executable, "-P", "-c", f"import sys; sys.path.insert(0, {str(folder)!r})\n{code}"], capture_output=True, text=True, timeout=200)
    assert told.stdout.strip() == "done", told.stderr


def test_the_record_of_a_run_does_not_wait_for_a_law_in_another_thread() -> None:
    # The record measures more than 1024 cells on the threads that evaluate the law, which wait for the interpreter
    code = f"""
import threading
import durometer
import test_laws

text = {BEAM.replace("[4, 2, 2]", "[8, 6, 5]").replace('dt = "0.5 s"', 'dt = "1 s"')!r}
slow = durometer.Scene.from_toml(text.replace("neo_hookean", test_laws.PythonNeoHookean.name))
other = durometer.Scene.from_toml(text)
assert slow.columns == other.columns and len(other.run(threads=2).cells) > 1024
thread = threading.Thread(target=slow.run, kwargs={{"threads": 2}})
thread.start()
while thread.is_alive():
    other.run(threads=2)
print("done", flush=True)
"""
    folder = Path(__file__).parent
    told = subprocess.run([sys.executable, "-P", "-c", f"import sys; sys.path.insert(0, {str(folder)!r})\n{code}"], capture_output=True, text=True, timeout=200)
    assert told.stdout.strip() == "done", told.stderr


def test_questions_to_a_scene_do_not_wait_for_a_law() -> None:
    # The equations are evaluated on several threads to answer them: a twisted start, with cells of a law in Python next to mixed ones
    code = f"""
import durometer
import test_laws
from durometer import _native

text = {BEAM.replace("[4, 2, 2]", "[9, 6, 5]")!r}
regions = '''[mesh.regions]
left = {{ kind = "box", min = ["-1 mm", "-1 mm", "-1 mm"], max = ["2.2222 mm", "11 mm", "11 mm"], pick = "cells", rule = "centroid" }}
right = {{ kind = "difference", of = ["body", "left"] }}

[laws.own]
law = "python_neo_hookean"
E = "100 kPa"
nu = 0.45

[start]
kind = "twisted"
angle = "10 deg"

[laws.silicone]'''
parts = '''region = "left"
law = "silicone"
formulation = "mixed"

[[effect]]
kind = "elastic"
region = "right"
law = "own"'''
text = text.replace("[laws.silicone]", regions).replace('region = "body"\\nlaw = "silicone"', parts)
scene = durometer.Scene.from_toml(text)
_native.set_threads(2)
scene.columns
scene.check_gradient()
print("done", flush=True)
"""
    folder = Path(__file__).parent
    told = subprocess.run([sys.executable, "-P", "-c", f"import sys; sys.path.insert(0, {str(folder)!r})\n{code}"], capture_output=True, text=True, timeout=200)
    assert told.stdout.strip() == "done", told.stderr
