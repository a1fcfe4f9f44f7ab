"""Ratios of costs that the project sets itself goals for, each the median of several runs, all in one go on an idle machine.

    cargo build --release
    python3 benches/ratios.py [--repeat 5] [--threads 2] [--large] [--studies] [--program target/release/durometer]

Every line names what is measured, the ratio, and the least and largest of its runs. `--large` adds meshes with a million linear and 200 000 quadratic
cells, which take gigabytes; `--studies` adds whole studies, which take minutes. Nothing is asserted: times depend on the machine.
"""

import argparse
import json
import math
import os
import resource
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PULL = "studies/finger-convergence/scene.toml"
WEIGHT = "studies/finger-gravity/scene.toml"
MIXED = {"mesh.element": "tet10", "effect.elastic.formulation": "mixed"}
ONE_STEP = {"stage.0.duration": '"0.1 s"', "stage.0.dt": '"0.1 s"'}


def simulate(program, scene, threads, settings):
    """The record of one run, with the seconds of its process and its largest resident set in GB."""
    with tempfile.TemporaryDirectory() as out:
        run = [program, "simulate", ROOT / scene, "--json", "--no-view", "--out", out, "--threads", str(threads)]
        run += [part for key, value in settings.items() for part in ("--set", f"{key}={value}")]
        start = time.perf_counter()
        process = subprocess.Popen(run, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        record = json.loads(process.stdout.read())
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - start
    if record["status"] != "Converged":
        raise SystemExit(f"{scene} {settings}: {record['status']} (exit {os.waitstatus_to_exitcode(status)})")
    return record | {"process_s": seconds, "memory_gb": usage.ru_maxrss / 1e6}


def line(name, values, unit=""):
    values = sorted(values)
    print(f"{name:72} {statistics.median(values):8.3g} {unit:4} {values[0]:8.3g} to {values[-1]:.3g}", flush=True)
    return statistics.median(values)


def step_in_factorisations(program, repeat):
    """A converged step over one factorisation of its tangent, one thread."""
    for name, settings in [
        ("tet4, 16 158 cells", {"mesh.cells": 16200}),
        ("tet4, 36 393 cells", {"mesh.cells": 36600}),
        ("tet10 mixed, 2 186 cells", MIXED | {"mesh.cells": 2200}),
        ("tet10 mixed, 4 588 cells", MIXED | {"mesh.cells": 4500}),
    ]:
        ratios = []
        for _ in range(repeat):
            record = simulate(program, PULL, 1, settings)
            one = record["phases"]["factorisation_s"] / record["work"]["factorisations"]
            ratios.append(record["wall_s"] / record["steps"] / one)
        line(f"step of the finger in factorisations, one thread: {name}", ratios)


def threads_over_one(program, repeat, threads):
    """One thread over several, seconds of the solution."""
    for name, settings in [
        ("tet4, 36 393 cells", {"mesh.cells": 36600}),
        ("tet10 mixed, 4 588 cells", MIXED | {"mesh.cells": 4500}),
        ("tet10 mixed, 9 227 cells", MIXED | {"mesh.cells": 9300}),
    ]:
        pairs = [[simulate(program, PULL, n, settings)["wall_s"] for n in (1, threads)] for _ in range(repeat)]
        line(f"one thread over {threads}: {name}", [one / several for one, several in pairs])


def contact(program, repeat):
    for cells in (1770, 9300):
        settings = {"mesh.cells": cells}
        records = [simulate(program, "studies/finger-cube/scene.toml", 1, settings) for _ in range(repeat)]
        line(f"finger-cube, iterations a step, {cells} cells", [r["newton_iterations"] / r["steps"] for r in records])
        line(f"finger-cube, CPU time, {cells} cells", [r["cpu_s"] for r in records], "s")
        search = [sum(c["search_s"] + c["detection_s"] for c in r["contacts"]) / r["cpu_s"] for r in records]
        line(f"finger-cube, share of the search for contact, {cells} cells", search)


def large(program, threads):
    """One static step of large meshes: seconds of the process, memory, and the growth of the solution. One run each."""
    nu = {"laws.silicone.nu": 0.49}
    for name, scene, sizes, settings in [
        ("tet4 with a cable", PULL, (150000, 1000000), {}),
        ("tet10 mixed, own weight", WEIGHT, (36600, 200000), nu | {"numerics.linear": '"iterative"'}),
    ]:
        for cells in sizes:
            # A mesh that is not stored yet is made here.
            check = [program, "check", ROOT / scene, "--set", f"mesh.cells={cells}"]
            subprocess.run(check, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
        runs = [simulate(program, scene, threads, ONE_STEP | settings | {"mesh.cells": cells}) for cells in sizes]
        line(f"{name}, {sizes[1]} cells: process", [runs[1]["process_s"]], "s")
        line(f"{name}, {sizes[1]} cells: memory", [runs[1]["memory_gb"]], "GB")
        growth = math.log(runs[1]["wall_s"] / runs[0]["wall_s"]) / math.log(sizes[1] / sizes[0])
        line(f"{name}: exponent of the time over the cells from {sizes[0]} on", [growth])


def studies(program):
    for name in ("finger-convergence", "finger-cost", "hard-cases", "finger-cube"):
        with tempfile.TemporaryDirectory() as out:
            start = time.perf_counter()
            command = [program, "run", name, "--out", out]
            subprocess.run(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            line(f"study {name}", [time.perf_counter() - start], "s")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--large", action="store_true")
    parser.add_argument("--studies", action="store_true")
    parser.add_argument("--program", default=ROOT / "target/release/durometer")
    options = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    step_in_factorisations(options.program, options.repeat)
    threads_over_one(options.program, options.repeat, options.threads)
    contact(options.program, options.repeat)
    if options.large:
        large(options.program, options.threads)
    if options.studies:
        studies(options.program)


if __name__ == "__main__":
    main()
