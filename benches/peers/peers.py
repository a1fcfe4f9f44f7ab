"""Tip force and time of the same finger in Durometer, CalculiX, FElupe and scikit-fem.

The finger is held at its root, its tip moves by 20 mm along z in ten increments. psi = mu/2 (J^(-2/3) I1 - 3) + kappa/2 (J - 1)^2, one
integration point for tet4, four for tet10. With nu = 0.499 pressures join the displacements where a program has them: Durometer and FElupe with quadratic
displacements and linear continuous pressures, the same discrete problem; CalculiX has no such tetrahedron and takes its C3D10. Every increment is solved until the residual is 1e-8 of the forces (CalculiX: 1e-7 of the mean
force, with all corrections). Two times: CPU seconds of the solution, without reading the mesh (CalculiX: of its whole process), and seconds by the clock
of the whole process, which the user waits for. THREADS of the environment is the number of threads of every program.
"""

import gzip
import json
import os
import platform
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import felupe
import meshio
import numpy as np
import skfem
import skfem.io
from pypardiso import spsolve
from skfem.element import DiscreteField
from skfem.helpers import grad

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "benches/peers/scene.toml"
MU = 0.357e6
MOVE, INCREMENTS = 0.02, 10
THREADS = os.environ.get("THREADS", "1")


class Case(NamedTuple):
    element: str
    cells: int
    nu: float

    @property
    def mixed(self):
        return self.nu > 0.49

    @property
    def kappa(self):
        return 2 * MU * (1 + self.nu) / (3 * (1 - 2 * self.nu))

    def settings(self):
        values = {"mesh.element": self.element, "mesh.cells": self.cells, "laws.rubber.nu": self.nu}
        values |= {"effect.elastic.formulation": "mixed"} if self.mixed else {}
        return [part for key, value in values.items() for part in ("--set", f"{key}={value}")]


CASES = [Case("tet4", 16200, 0.45), Case("tet10", 4500, 0.45), Case("tet10", 4500, 0.499)]


class Finger:
    """Points [m], cells (node order of VTK), nodes of root and tip."""

    def __init__(self, file, case):
        self.file, self.case = file, case
        with tempfile.NamedTemporaryFile(suffix=".msh") as plain:
            plain.write(gzip.decompress(file.read_bytes()))
            plain.flush()
            mesh = meshio.read(plain.name)
        solid = [b for b in mesh.cells if b.type.startswith("tetra")]
        self.kind = solid[0].type
        cells = np.vstack([b.data for b in solid])
        # Corners first: they alone have pressures
        corners = np.unique(cells[:, :4])
        used = np.concatenate([corners, np.setdiff1d(cells, corners)])
        new = {old: k for k, old in enumerate(used)}
        self.cells = np.vectorize(new.get)(cells)
        self.points = mesh.points[used]

        def nodes(name):
            found = {n for block, own in zip(mesh.cells, mesh.cell_sets[name]) for n in block.data[own].ravel()}
            return np.array(sorted(new[n] for n in found))

        self.root, self.tip = nodes("root"), nodes("tip")


def children():
    """CPU seconds of the processes that were waited for."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def process(command, folder):
    """What a process prints, and its seconds by the clock."""
    start = time.perf_counter()
    said = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout
    return said, time.perf_counter() - start


def durometer(program, finger):
    with tempfile.TemporaryDirectory() as out:
        run = [program, "simulate", SCENE, "--json", "--no-view", "--threads", THREADS, "--out", out]
        said, clock = process(run + finger.case.settings(), ROOT)
    record = json.loads(said)
    return record["probes"]["tip_reaction_z_N"]["final"], record["cpu_s"], record["newton_iterations"], clock


def calculix(program, finger):
    kind = {"tetra": "C3D4", "tetra10": "C3D10"}[finger.kind]
    text = ["*NODE, NSET=ALL"]
    text += [f"{k + 1}, {p[0]:.11e}, {p[1]:.11e}, {p[2]:.11e}" for k, p in enumerate(finger.points)]
    text += [f"*ELEMENT, TYPE={kind}, ELSET=BODY"]
    text += [f"{k + 1}, " + ", ".join(str(n + 1) for n in c) for k, c in enumerate(finger.cells)]
    for name, nodes in (("ROOT", finger.root), ("TIP", finger.tip)):
        text += [f"*NSET, NSET={name}"] + [f"{n + 1}," for n in nodes]
    text += ["*MATERIAL, NAME=RUBBER", "*HYPERELASTIC, NEO HOOKE", f"{MU / 2:.11e}, {2 / finger.case.kappa:.11e}"]
    text += ["*SOLID SECTION, ELSET=BODY, MATERIAL=RUBBER", "*BOUNDARY", "ROOT, 1, 3"]
    text += ["*STEP, NLGEOM, INC=100", "*STATIC, DIRECT", f"{1 / INCREMENTS}, 1.0"]
    text += ["*CONTROLS, PARAMETERS=FIELD", "1e-7, 1e-7, , , 1e-7, 1e-7", "*BOUNDARY", f"TIP, 3, 3, {MOVE}"]
    text += ["*NODE PRINT, NSET=TIP, FREQUENCY=100, TOTALS=ONLY", "RF", "*END STEP"]
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "finger.inp").write_text("\n".join(text) + "\n")
        start = children()
        log, clock = process(["ccx", "finger"], folder)
        seconds = children() - start
        if "Job finished" not in log:
            raise RuntimeError(log[-2000:])
        result = Path(folder, "finger.dat").read_text()
    numbers = [float(x) for x in result.split("\n\n")[-1].split()]
    return numbers[-1], seconds, len(re.findall(r"iteration +\d+", log)), clock


def in_python(solve):
    """A solution in a process of its own, with the import of its libraries."""

    def run(program, finger):
        said, clock = process([sys.executable, __file__, "--one", solve.__name__, str(finger.file), json.dumps(finger.case)], ROOT)
        return *json.loads(said.splitlines()[-1]), clock

    return run


def with_felupe(finger):
    mesh = felupe.Mesh(finger.points, finger.cells, finger.kind)
    region = (felupe.RegionTetra if finger.kind == "tetra" else felupe.RegionQuadraticTetra)(mesh)
    start = time.process_time()
    if finger.case.mixed:
        # Displacement, pressure and volume ratio; the latter two on the corners
        field = felupe.FieldsMixed(region, n=3)
        solid = felupe.SolidBody(felupe.NearlyIncompressible(felupe.NeoHooke(mu=MU), bulk=finger.case.kappa), field)
    else:
        field = felupe.FieldContainer([felupe.Field(region, dim=3)])
        solid = felupe.SolidBody(felupe.NeoHooke(mu=MU, bulk=finger.case.kappa), field)

    def mask(nodes):
        out = np.zeros(len(finger.points), dtype=bool)
        out[nodes] = True
        return out

    boundaries = {
        "root": felupe.Boundary(field[0], mask=mask(finger.root)),
        "tip": felupe.Boundary(field[0], mask=mask(finger.tip), skip=(True, True, False)),
    }
    moves = np.linspace(0, MOVE, INCREMENTS + 1)[1:]
    step = felupe.Step(items=[solid], ramp={boundaries["tip"]: moves}, boundaries=boundaries)
    iterations = []
    job = felupe.Job([step], plugins=[lambda context, state: iterations.append(context.substep.iterations)])
    job.evaluate(solver=spsolve, tol=1e-8, verbose=0)
    seconds = time.process_time() - start
    force = solid.assemble.vector(field).toarray()[: finger.points.size].reshape(-1, 3)
    return force[finger.tip, 2].sum(), seconds, sum(iterations)


def with_skfem(finger):
    mesh = skfem.io.from_meshio(meshio.Mesh(finger.points, [(finger.kind, finger.cells)]))
    quadratic = finger.kind == "tetra10"
    unknown = skfem.ElementVector(skfem.ElementTetP2() if quadratic else skfem.ElementTetP1())
    basis = skfem.Basis(mesh, unknown, intorder=2 if quadratic else 1)
    start, kappa = time.process_time(), finger.case.kappa

    def state(u):
        """What residual and tangent share, once an iteration: F, J, F^-T, J^(-2/3), I1."""
        F = np.asarray(basis.interpolate(u).grad) + np.eye(3)[:, :, None, None]
        last = np.moveaxis(F, (0, 1), (-2, -1))
        J, G = np.linalg.det(last), np.moveaxis(np.linalg.inv(last), (-2, -1), (1, 0))
        fields = {"F": F, "J": J, "G": G, "a": J ** (-2 / 3), "I1": np.einsum("ij...,ij...", F, F)}
        return {name: DiscreteField(np.ascontiguousarray(value)) for name, value in fields.items()}

    @skfem.LinearForm
    def residual(v, w):
        P = MU * w["a"] * (w["F"] - w["I1"] / 3 * w["G"]) + kappa * (w["J"] - 1) * w["J"] * w["G"]
        return np.einsum("ij...,ij...", P, grad(v))

    @skfem.BilinearForm
    def tangent(u, v, w):
        F, J, G, a, I1 = (np.asarray(w[name]) for name in ("F", "J", "G", "a", "I1"))
        d, e = grad(u), grad(v)
        A, B = np.einsum("ij...,il...->jl...", G, d), np.einsum("ij...,il...->jl...", G, e)
        Gd, Ge = np.einsum("ii...", A), np.einsum("ii...", B)
        Fd, Fe = np.einsum("ij...,ij...", F, d), np.einsum("ij...,ij...", F, e)
        turned = np.einsum("ij...,ji...", A, B)
        dev = MU * a * (np.einsum("ij...,ij...", d, e) - 2 / 3 * (Gd * Fe + Fd * Ge) + 2 / 9 * I1 * Gd * Ge + I1 / 3 * turned)
        return dev + kappa * J * ((2 * J - 1) * Gd * Ge - (J - 1) * turned)

    # Nodes are numbered anew by the basis: found by their places
    places = {tuple(np.round(p, 9)): k for k, p in enumerate(finger.points)}
    order = np.array([places.get(tuple(np.round(x, 9)), -1) for x in basis.doflocs.T])
    component = np.empty(basis.N, dtype=int)
    for block in (basis.nodal_dofs, basis.edge_dofs):
        for i in range(block.shape[0]):
            component[block[i]] = i
    root = np.flatnonzero(np.isin(order, finger.root))
    tip = np.flatnonzero(np.isin(order, finger.tip) & (component == 2))
    held = np.union1d(root, tip)
    free = np.setdiff1d(np.arange(basis.N), held)
    u, iterations = basis.zeros(), 0
    for k in range(1, INCREMENTS + 1):
        du = basis.zeros()
        du[tip] = MOVE * k / INCREMENTS - u[tip]
        while True:
            at = state(u)
            r = residual.assemble(basis, **at)
            if not du.any() and np.linalg.norm(r[free]) <= 1e-8 * np.linalg.norm(r[held]):
                break
            K = tangent.assemble(basis, **at).tocsr()
            du[free] = spsolve(K[free][:, free], -r[free] - K[free] @ du)
            u += du
            du[:] = 0
            iterations += 1
    return r[tip].sum(), time.process_time() - start, iterations


PROGRAMS = [
    ("Durometer", durometer),
    ("CalculiX", calculix),
    ("FElupe, pypardiso", in_python(with_felupe)),
    ("scikit-fem, pypardiso", in_python(with_skfem)),
]
# Programs that have no element with pressures in this comparison
WITHOUT_PRESSURES = {"scikit-fem, pypardiso"}


def main():
    if sys.argv[1] == "--one":
        case = Case(*json.loads(sys.argv[4]))
        force, seconds, iterations = globals()[sys.argv[2]](Finger(Path(sys.argv[3]), case))
        print(json.dumps([float(force), seconds, int(iterations)]))
        return
    program, repeats = sys.argv[1], int(sys.argv[2])
    wanted = sys.argv[3:] or [name for name, _ in PROGRAMS]
    processor = next((l.split(":")[1].strip() for l in Path("/proc/cpuinfo").read_text().splitlines() if "model name" in l), "")
    print(f"{time.strftime('%Y-%m-%d')}, {processor or platform.processor()}, {THREADS} thread(s), median of {repeats} run(s)\n")
    print("| mesh | program | tip force [N] | off by | iterations | CPU [s] | over Durometer | process [s] | over Durometer | spread |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for case in CASES:
        find = [program, "check", SCENE, *case.settings()]
        said = subprocess.run(find, cwd=ROOT, check=True, capture_output=True, text=True).stdout
        finger = Finger(ROOT / "meshes/finger" / re.search(r"\S+\.msh\.gz", said)[0], case)
        own = None
        for name, solve in PROGRAMS:
            if not any(name.startswith(one) for one in wanted) or case.mixed and name in WITHOUT_PRESSURES:
                continue
            runs = [solve(program, finger) for _ in range(repeats)]
            force, iterations = runs[0][0], runs[0][2]
            cpu, clock = (statistics.median(r[i] for r in runs) for i in (1, 3))
            own = own or (force, cpu, clock)
            off = abs(abs(force / own[0]) - 1)
            clocks = [r[3] for r in runs]
            print(
                f"| {case.element}, {len(finger.cells)}, ν = {case.nu} | {name} | {abs(force):.9f} | {off:.1e} | {iterations} | {cpu:.2f} | {cpu / own[1]:.1f} "
                f"| {clock:.2f} | {clock / own[2]:.1f} | {max(clocks) / min(clocks) - 1:.0%} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
