"""The program in the package: exit codes, pipes, signals, processes of cases, and where its files come from."""

import os
import shutil
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import durometer
import pytest
from conftest import BEAM, program
from test_studies import STUDY

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")


def test_exit_codes_are_those_of_the_program(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(BEAM)
    (tmp_path / "free.toml").write_text(BEAM.replace('region = "xmin"\n\n[[stage', 'region = "xmin"\ncomponents = "y"\n\n[[stage'))
    out = ["--no-view", "--out", tmp_path / "out"]
    for arguments, code in [
        (["--version"], 0),
        (["simulate", "--help"], 0),
        (["simulate", tmp_path / "scene.toml", *out], 0),
        ([], 2),
        (["no-such-command"], 2),
        (["simulate", "no-such-scene.toml"], 2),
        (["simulate", tmp_path / "free.toml", *out], 3),
    ]:
        told = program(*arguments)
        assert told.returncode == code, (arguments, told.stdout, told.stderr)
    assert program("--version").stdout.strip() == f"durometer {durometer.__version__}"


def test_main_is_a_function_too(tmp_path: Path, capfd: pytest.CaptureFixture) -> None:
    assert durometer.main(["simulate", "no-such-scene.toml"]) == 2
    assert "no such file" in capfd.readouterr().err
    scene = tmp_path / "scene.toml"
    scene.write_text(BEAM)
    assert durometer.main(["check", scene]) == 0
    capfd.readouterr()
    assert durometer.main(["--version"]) == 0
    assert durometer.__version__ in capfd.readouterr().out


@pytest.mark.parametrize("in_a_thread", [False, True])
def test_an_exception_of_a_law_in_python_comes_through_the_program(tmp_path: Path, in_a_thread: bool) -> None:
    from test_laws import PythonNeoHookean

    class InProgram(PythonNeoHookean):
        name = "python_in_program"

        def stress(self, F):
            if abs(F[0, 0] - 1.0) > 1e-9 and abs(F[1, 2]) > 1e-9:
                raise ZeroDivisionError("in the program")
            return super().stress(F)

    durometer.register_law(InProgram)
    (tmp_path / "scene.toml").write_text(BEAM.replace("neo_hookean", "python_in_program"))
    arguments = ["simulate", str(tmp_path / "scene.toml"), "--no-view", "--out", str(tmp_path / "out")]
    with pytest.raises(ZeroDivisionError, match="in the program"):
        if in_a_thread:
            with ThreadPoolExecutor(1) as pool:
                pool.submit(durometer.main, arguments).result(120)
        else:
            durometer.main(arguments)


def test_the_script_is_installed_next_to_python() -> None:
    script = shutil.which("durometer", path=str(Path(sys.executable).parent))
    assert script, "the wheel brings the script"
    told = subprocess.run([script, "--version"], capture_output=True, text=True, timeout=60)
    assert told.stdout.strip() == f"durometer {durometer.__version__}"


@POSIX
def test_a_reader_that_closes_the_pipe_ends_the_program_quietly() -> None:
    command = f"{sys.executable} -P -m durometer studies --json | head -c 1"
    told = subprocess.run(command, shell=True, capture_output=True, text=True, timeout=120)
    assert told.stdout == "["
    assert "Traceback" not in told.stderr and "roken pipe" not in told.stderr and "panicked" not in told.stderr


@POSIX
def test_a_closed_pipe_is_an_exception_of_python_after_and_during_a_command(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(BEAM.replace('dt = "0.5 s"', 'dt = "0.002 s"'))
    code = """
import durometer, os, threading, time

def write():
    reader, writer = os.pipe()
    os.close(reader)
    try:
        os.write(writer, b"x")
    except BrokenPipeError:
        print("told", flush=True)

thread = threading.Thread(target=lambda: durometer.main(["check", "scene.toml"]))
thread.start()
thread.join()
write()
thread = threading.Thread(target=lambda: durometer.main(["simulate", "scene.toml", "--no-view", "--out", "out"]))
thread.start()
time.sleep(0.5)
write()
thread.join()
write()
"""
    told = subprocess.run([sys.executable, "-P", "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert told.returncode == 0 and told.stdout.split("\n").count("told") == 3, (told.returncode, told.stdout, told.stderr)


@POSIX
def test_ctrl_c_keeps_what_is_finished_of_a_study(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(BEAM)
    # The largest cases come first, so that this one is the last
    long = STUDY.replace("[2, 1, 1]", '[2, 1, 1], "stage.0.dt" = "0.0001 s"')
    (tmp_path / "study.toml").write_text(long)
    command = [sys.executable, "-P", "-m", "durometer", "run", str(tmp_path), "--jobs", "1", "--out", str(tmp_path / "out")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    while "done" not in process.stderr.readline():
        pass
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=120)
    assert process.returncode == 3 and "stopped:" in told


@POSIX
def test_ctrl_c_stops_a_command_in_a_session_that_goes_on(tmp_path: Path) -> None:
    (tmp_path / "long.toml").write_text(BEAM.replace('dt = "0.5 s"', 'dt = "0.00001 s"'))
    (tmp_path / "short.toml").write_text(BEAM)
    code = """
import durometer, os, signal, threading, time
options = ["--no-view", "--out", "out"]
threading.Timer(3, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    durometer.main(["simulate", "long.toml", *options])
except KeyboardInterrupt:
    print("stopped")
assert durometer.main(["simulate", "short.toml", *options]) == 0, "the next command is not stopped"
"""
    told = subprocess.run([sys.executable, "-P", "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert told.returncode == 0 and "stopped" in told.stdout, (told.stdout, told.stderr)


@POSIX
def test_ctrl_c_ends_a_command_that_does_not_take_it() -> None:
    # The process of a case waits for its order
    command = [sys.executable, "-P", "-m", "durometer", "worker"]
    process = subprocess.Popen(command, stdin=subprocess.PIPE)
    try:
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(timeout=3)
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=20) == -signal.SIGINT
    finally:
        process.kill()
        process.wait()


def test_another_durometer_in_the_current_folder_is_not_run(tmp_path: Path) -> None:
    (tmp_path / "durometer").mkdir()
    (tmp_path / "durometer" / "__init__.py").write_text("raise SystemExit(77)")
    (tmp_path / "scene.toml").write_text(BEAM)
    (tmp_path / "study.toml").write_text(STUDY)
    told = program("run", tmp_path, "--only", "c2", "--out", tmp_path / "out", cwd=tmp_path)
    assert told.returncode == 0, told.stderr


def test_studies_come_with_the_program_into_its_cache(tmp_path: Path) -> None:
    cache = tmp_path / "a cache"
    environment = {**os.environ, "DUROMETER_CACHE": str(cache)}
    environment.pop("DUROMETER_HOME", None)
    told = program("studies", env=environment, cwd=tmp_path)
    assert told.returncode == 0 and "finger-convergence" in told.stdout
    assert any(folder.name.startswith("files-") for folder in cache.iterdir())
    # Files of another version do not matter: each version has a folder of its own
    (cache / "files-0000000000000000").mkdir()
    told = program("doctor", env=environment, cwd=tmp_path)
    assert "is of another version of the program" in told.stdout


def test_the_mesher_is_run_by_the_python_of_the_package(tmp_path: Path) -> None:
    environment = {**os.environ, "DUROMETER_CACHE": str(tmp_path)}
    environment.pop("DUROMETER_PYTHON", None)
    told = program("doctor", env=environment)
    [python] = [line for line in told.stdout.splitlines() if line.split()[1:2] == ["python"]]
    assert os.path.normpath(sys.executable) in python
    try:
        import gmsh  # noqa: F401
    except (ImportError, OSError):
        assert told.returncode == 2 and 'pip install "durometer[mesh]"' in told.stdout


def test_a_cache_that_cannot_be_written_is_refused_with_a_remedy(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    environment = {**os.environ, "DUROMETER_CACHE": str(tmp_path / "file" / "cache")}
    environment.pop("DUROMETER_HOME", None)
    code = """
import durometer
try:
    durometer.Scene.from_toml("finger-convergence").run()
except durometer.InputError as error:
    assert error.fact and "cannot be unpacked" in str(error) and "set DUROMETER_CACHE" in error.remedy, str(error)
else:
    raise SystemExit(1)
"""
    told = subprocess.run([sys.executable, "-P", "-c", code], env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert told.returncode == 0, told.stderr


def test_a_missing_mesher_names_the_extra(tmp_path: Path) -> None:
    environment = {**os.environ, "DUROMETER_CACHE": str(tmp_path), "DUROMETER_PYTHON": ""}
    code = """
import durometer
try:
    durometer.Scene.from_toml("finger-convergence").set("mesh.cells", 1234).run()
except durometer.InputError as error:
    assert error.remedy == 'run: pip install "durometer[mesh]"', error.remedy
else:
    raise SystemExit(1)
"""
    told = subprocess.run([sys.executable, "-P", "-c", code], env=environment, capture_output=True, text=True, timeout=120)
    assert told.returncode == 0, told.stderr


def test_a_live_view_is_gone_after_its_run(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(BEAM)
    code = """
import durometer, psutil
for _ in range(2):
    assert durometer.main(["simulate", "scene.toml", "--live", "--no-view", "--out", "out"]) == 0
open_ports = [c for c in psutil.Process().net_connections() if c.status == psutil.CONN_LISTEN]
assert not open_ports, open_ports
"""
    told = subprocess.run([sys.executable, "-P", "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert told.returncode == 0, told.stderr
