"""Functions of PyTorch and JAX: values of the run, and derivatives compared with differences of runs and with forward derivatives."""

import importlib
import random
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import durometer
import numpy
import pytest
from conftest import BEAM, LOCKED, REFINED

KEYS = ["laws.silicone.E", "effect.gravity.density", "mesh.grid.size.0", "effect.gravity.direction.1"]
COLUMNS = ["xmax_z_m", "xmin_reaction_z_N"]
#: Solved to rounding, so that differences of runs are smooth
TIGHT = BEAM.replace("direction = [0, 0, -1]", "direction = [0, 0.1, -1]") + "\n[numerics]\ntolerance = 1e-12\n"


@pytest.fixture
def scene() -> durometer.Scene:
    return durometer.Scene.from_toml(TIGHT)


def ended(scene: durometer.Scene, numbers: Any) -> numpy.ndarray:
    for key, number in zip(KEYS, numbers):
        scene = scene.set_si(key, float(number))
    run = scene.run()
    return numpy.array([run[name][-1] for name in COLUMNS])


def test_a_number_in_si_units_is_the_one_of_the_text(scene: durometer.Scene) -> None:
    assert scene.get_si("laws.silicone.E") == 100e3
    assert scene.set_si("mesh.grid.size.0", 0.02).run().values.tobytes() == scene.run().values.tobytes()
    with pytest.raises(durometer.InputError):
        scene.get_si("mesh.element")


@pytest.mark.parametrize("extra", ["", """
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = { kind = "ramp", from = "0 mm", to = "1 mm", end = "1 s" }

[[constraint]]
kind = "cable"
guides = [["5 mm", "5 mm", "7 mm"], ["15 mm", "5 mm", "7 mm"]]
pull_point = ["-10 mm", "5 mm", "7 mm"]
guide_radius = "point"
drive = { kind = "length", signal = { kind = "ramp", from = "0 mm", to = "1 mm", end = "1 s" } }
"""], ids=["weight", "pulled"])
def test_the_adjoint_derivatives_are_the_forward_ones(extra: str) -> None:
    # Both solve with the tangent of one state, so that they agree to the rounding of its solutions
    scene = durometer.Scene.from_toml(TIGHT + extra)
    keys = [*KEYS, *(["constraint.cable.drive.signal.to", "constraint.prescribed.displacement.to", "constraint.cable.guides.1.2"] if extra else [])]
    found = scene.sensitivities(keys)
    run = scene.run()
    columns = [name for name in found.columns if name.startswith(("xmax", "xmin"))]
    assert len(columns) == 6
    forward = numpy.array([[found[name, key][-1] for key in keys] for name in columns])
    adjoint = numpy.array([run.gradient({name: 2.0}, keys) for name in columns]) / 2.0
    sizes = numpy.array([abs(scene.get_si(key)) for key in keys])
    for unit in ("_m", "_N"):
        # Changes by a change of a key by its own size, against the largest value of the unit: what does not depend on a key has rounding only
        own = [name.endswith(unit) for name in columns]
        largest = max(abs(run[name]).max() for name in columns if name.endswith(unit))
        assert (abs(adjoint - forward)[own] * sizes <= 1e-9 * largest).all(), (unit, adjoint[own], forward[own])


def test_the_gradient_of_a_sum_is_the_sum_of_the_gradients(scene: durometer.Scene) -> None:
    run = scene.run()
    both = run.gradient({COLUMNS[0]: 3.0, COLUMNS[1]: -0.5}, KEYS)
    one_by_one = 3.0 * run.gradient({COLUMNS[0]: 1.0}, KEYS) - 0.5 * run.gradient({COLUMNS[1]: 1.0}, KEYS)
    assert numpy.allclose(both, one_by_one, rtol=1e-10)


def test_wrong_gradients_are_refused(scene: durometer.Scene) -> None:
    run = scene.run()
    for weights, keys, words in [
        ({"xmax_zm": 1.0}, KEYS, "no column xmax_zm"),
        ({"xmax_z_m": float("nan")}, KEYS, "a weight is NaN"),
        ({"xmax_z_m": 1.0}, [], "no key is given"),
        ({"t_s": 1.0}, KEYS, "t_s has no derivative"),
        ({"newton_iterations": 1.0}, KEYS, "newton_iterations has no derivative"),
        ({"elastic_energy_J": 1.0}, KEYS, "no derivative|no column"),
    ]:
        with pytest.raises(durometer.InputError, match=words):
            run.gradient(weights, keys)
    dynamic = scene.set("stage.0.integrator", "implicit_euler")
    with pytest.raises(durometer.InputError, match="no adjoint derivatives"):
        dynamic.check_gradient()


def backend(name: str) -> Any:
    try:
        importlib.import_module(name)
    except ImportError:
        pytest.skip(f"{name} is not installed")
    return importlib.import_module(f"durometer.{name}")


@pytest.mark.parametrize("method", ["adjoint", "forward"])
def test_torch_takes_values_and_gradients(scene: durometer.Scene, method: str) -> None:
    library = backend("torch")
    import torch

    at_end = library.function(scene, KEYS, COLUMNS, method=method)
    numbers = at_end.start.clone().requires_grad_()
    assert numpy.array_equal(at_end(numbers).detach().numpy(), ended(scene, at_end.start))
    # In units of the numbers; the differences of gradcheck have a step of 1e-4 and an error of 1e-8 of the values
    size = at_end.start.clone()
    scaled = lambda x: at_end(x * size) * torch.tensor([1e3, 1e3], dtype=torch.float64)  # noqa: E731
    assert torch.autograd.gradcheck(scaled, (torch.ones(4, dtype=torch.float64, requires_grad=True),), eps=1e-4, atol=1e-5, rtol=1e-5)


@pytest.mark.parametrize("method", ["adjoint", "forward"])
def test_jax_takes_values_and_gradients(scene: durometer.Scene, method: str) -> None:
    library = backend("jax")
    import jax

    jax.config.update("jax_enable_x64", True)
    at_end = library.function(scene, KEYS, COLUMNS, method=method)
    assert numpy.array_equal(at_end(at_end.start), ended(scene, at_end.start))
    exact = jax.jacrev(at_end)(at_end.start)
    in_jit = jax.jit(jax.jacrev(at_end))(at_end.start)
    assert numpy.allclose(in_jit, exact, rtol=1e-12)
    for k, size in enumerate(at_end.start):
        # Central differences of the fourth order with steps of 1e-3: an error of 1e-11 of the value, and of rounding 1e-9
        step = numpy.zeros(4)
        step[k] = 1e-3 * size
        near, far = [ended(scene, at_end.start + m * step) - ended(scene, at_end.start - m * step) for m in (1, 2)]
        difference = (8 * near - far) / (12 * step[k])
        assert numpy.allclose(exact[:, k], difference, rtol=1e-6, atol=1e-7 * abs(ended(scene, at_end.start)).max() / abs(size)), KEYS[k]


def test_torch_refuses_second_derivatives(scene: durometer.Scene) -> None:
    library = backend("torch")
    import torch

    at_end = library.function(scene, KEYS[:2], COLUMNS[:1])
    height = lambda numbers: at_end(numbers)[0]  # noqa: E731
    for of in (height, lambda numbers: height(numbers) ** 2):
        with pytest.raises(durometer.InputError, match="no second derivatives") as caught:
            torch.autograd.functional.hessian(of, at_end.start)
        assert "L-BFGS" in caught.value.remedy
    numbers = at_end.start.clone().requires_grad_()
    [first] = torch.autograd.grad(height(numbers), numbers)
    [kept] = torch.autograd.grad(height(numbers), numbers, create_graph=True)
    assert torch.equal(kept.detach(), first)
    with pytest.raises(durometer.InputError, match="no second derivatives"):
        (kept**2).sum().backward()


def test_jax_refuses_second_derivatives(scene: durometer.Scene) -> None:
    library = backend("jax")
    import jax

    jax.config.update("jax_enable_x64", True)
    at_end = library.function(scene, KEYS[:2], COLUMNS[:1])
    gradient = jax.grad(lambda numbers: at_end(numbers)[0])
    penalty = jax.grad(lambda numbers: (gradient(numbers) ** 2).sum())
    for of in (penalty, jax.jit(penalty), jax.jacrev(gradient)):
        with pytest.raises(durometer.InputError, match="no second derivatives") as caught:
            of(at_end.start)
        assert "L-BFGS" in caught.value.remedy
    # Forward mode, by which JAX makes a Hessian, is refused by JAX itself
    numbers = jax.numpy.asarray(at_end.start)
    for call in (
        lambda: jax.hessian(lambda numbers: at_end(numbers)[0] ** 2)(numbers),
        lambda: jax.jvp(gradient, (numbers,), (numbers,)),
        lambda: jax.jvp(at_end, (numbers,), (numbers,)),
    ):
        with pytest.raises(TypeError, match="forward-mode"):
            call()


@pytest.mark.parametrize("name", ["torch", "jax"])
def test_wrong_functions_and_numbers_are_refused(scene: durometer.Scene, name: str) -> None:
    library = backend(name)
    for arguments, words in [
        ((scene, "laws.silicone.E", COLUMNS), "keys is no list"),
        ((scene, [], COLUMNS), "keys is empty"),
        ((scene, KEYS, ["xmax_zm"]), "no column xmax_zm"),
        ((scene, ["laws.silicon.E"], COLUMNS), "silicon"),
        ((TIGHT, KEYS, COLUMNS), "of the type str"),
    ]:
        with pytest.raises(durometer.InputError, match=words):
            library.function(*arguments)
    with pytest.raises(durometer.InputError, match="no method"):
        library.function(scene, KEYS, COLUMNS, method="backward")
    at_end = library.function(scene, KEYS, COLUMNS)
    assert at_end.method == "adjoint"
    with pytest.raises(durometer.InputError, match="shape"):
        at_end(at_end.start[:2])
    with pytest.raises(durometer.InputError, match="of the type"):
        at_end(at_end.start.astype(int) if name == "jax" else at_end.start.to(int))
    # A search may get there: it is a design without an answer
    for number in ("nan", "inf"):
        with pytest.raises(durometer.RunError, match="finite") as caught:
            at_end(at_end.start * float(number))
        assert caught.value.status == "Refused"
    dynamic = scene.set("stage.0.integrator", "implicit_euler")
    assert library.function(dynamic, KEYS[:1], COLUMNS[:1]).method == "forward"


@pytest.mark.parametrize("method", ["adjoint", "forward"])
def test_columns_and_keys_without_derivatives_are_refused_before_the_first_run(scene: durometer.Scene, method: str) -> None:
    from durometer._end_values import EndValues

    for column in ("t_s", "newton_iterations", "elastic_J"):
        with pytest.raises(durometer.InputError, match=f"{column} has no derivative") as caught:
            EndValues(scene, KEYS[:1], ["xmax_z_m", column], method, None)
        assert caught.value.remedy.startswith("take columns that have one: xmax_x_m, xmax_y_m, xmax_z_m, xmin_reaction_x_N")
    with pytest.raises(durometer.InputError, match="mesh.grid.divisions.0 takes whole numbers"):
        EndValues(scene, ["mesh.grid.divisions.0"], COLUMNS, method, None)


#: A cable of which 25 mm are between its guides and its pull point
TENDON = """
[[constraint]]
kind = "cable"
guides = [["5 mm", "5 mm", "7 mm"], ["15 mm", "5 mm", "7 mm"]]
pull_point = ["-10 mm", "5 mm", "7 mm"]
guide_radius = "point"
drive = { kind = "length", signal = { kind = "ramp", from = "0 mm", to = "1 mm", end = "1 s" } }
"""


@pytest.mark.parametrize("method", ["adjoint", "forward"])
def test_a_design_without_an_answer_is_one_kind_of_exception(method: str) -> None:
    from durometer._end_values import EndValues

    scene = durometer.Scene.from_toml(BEAM + TENDON)
    pull = "constraint.cable.drive.signal.to"
    of = EndValues(scene, [pull, "laws.silicone.nu"], COLUMNS, method, None)
    assert numpy.isfinite(of.values(of.start)).all()
    # A cable shorter than its path allows, and a law that has no bulk modulus
    for numbers, words in [([0.1, 0.45], "the cable is shortened by 100"), ([1e-3, 0.6], "nu = 0.6")]:
        for computed in (of.values, lambda numbers: of.pullback(numbers, numpy.ones(2))):
            with pytest.raises(durometer.RunError, match=words) as caught:
                computed(numpy.array(numbers))
            assert caught.value.status == "Refused" and caught.value.fact and caught.value.remedy
            assert isinstance(caught.value.__cause__, durometer.InputError)
    loose = durometer.Scene.from_toml(TIGHT).set("constraint.0.components", "y")
    with pytest.raises(durometer.RunError) as caught:
        EndValues(loose, KEYS[:1], COLUMNS[:1], method, None).values(numpy.array([100e3]))
    assert caught.value.status == "Singular"
    # An error of the caller is not a failure of the design
    with pytest.raises(durometer.InputError, match="derivative by .* is .*nan"):
        of.pullback(of.start, numpy.array([1.0, float("nan")]))
    with pytest.raises(durometer.InputError, match="whole number of 1 or more"):
        EndValues(scene, [pull], COLUMNS, method, 0).values(of.start[:1])


#: A compiled function of JAX, and calls of it after a good one: of a design without an answer, and of one that is interrupted
COMPILED = """
import sys
import durometer
import durometer.jax
import jax
from durometer._end_values import EndValues

jax.config.update("jax_enable_x64", True)
at_end = durometer.jax.function(durometer.Scene.from_toml(TEXT), ["laws.silicone.E"], ["xmax_z_m"])
numbers = jax.numpy.asarray(at_end.start)
compiled = {"jit": jax.jit(at_end), "grad": jax.jit(jax.value_and_grad(lambda numbers: at_end(numbers)[0])), "vmap": jax.vmap(at_end)}[KIND]
row = (lambda numbers: numbers[None]) if KIND == "vmap" else (lambda numbers: numbers)
if GOOD_FIRST:
    jax.block_until_ready(compiled(row(numbers)))
for _ in range(2):
    try:
        jax.block_until_ready(compiled(row(-numbers)))
    except (durometer.RunError, jax.errors.JaxRuntimeError, ValueError) as error:
        assert "E (Young's modulus) = -100000" in str(error), error

def interrupted(self, numbers):
    raise interrupt

interrupt = KeyboardInterrupt()
EndValues._solved = interrupted
try:
    jax.block_until_ready(compiled(row(2.0 * numbers)))
except KeyboardInterrupt as raised:
    assert raised is interrupt and sys.gettrace() is None
    print("interrupted")
"""


@pytest.mark.parametrize("good_first", [True, False])
@pytest.mark.parametrize("kind", ["jit", "grad", "vmap"])
def test_exceptions_of_compiled_functions_are_those_of_the_reference(kind: str, good_first: bool) -> None:
    backend("jax")
    code = f"TEXT, KIND, GOOD_FIRST = {TIGHT!r}, {kind!r}, {good_first}\n{COMPILED}"
    told = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, timeout=120)
    assert told.stdout == "interrupted\n", told.stderr


def test_a_mesh_that_depends_on_the_design_is_refused() -> None:
    from durometer._end_values import EndValues

    with pytest.raises(durometer.InputError, match="the scene has mesh.refine.*; take refine out of"):
        EndValues(durometer.Scene.from_toml(REFINED), ["laws.silicone.E"], ["tip_z_m"], "auto", None)


@pytest.mark.parametrize("name", ["torch", "jax"])
def test_a_missing_library_names_the_extra(name: str) -> None:
    code = f"""
import sys
sys.modules["{name}"] = None
import durometer.{name}
scene = durometer.Scene.from_toml({TIGHT!r})
try:
    durometer.{name}.function(scene, ["laws.silicone.E"], ["xmax_z_m"])
except durometer.MissingExtra as error:
    assert error.remedy == 'pip install "durometer[{name}]"', error.remedy
else:
    raise SystemExit(1)
"""
    told = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, timeout=60)
    assert told.returncode == 0, told.stderr


def test_doubtful_derivatives_are_named_in_a_warning() -> None:
    half = 0.5 * (numpy.einsum("ik,JL->iJkL", numpy.eye(3), numpy.eye(3)) + numpy.einsum("iL,kJ->iJkL", numpy.eye(3), numpy.eye(3)))

    class Rough(durometer.Law):
        """ψ = ½ s ε:ε, whose modulus jumps with its constant, so that no difference resolves it."""

        name = "python_rough"
        parameters = [durometer.Parameter("s", "s", "Pa", (0.0, float("inf")), "stiffness")]
        sample = [40e3]
        objective = False
        survives_inversion = True

        def __init__(self, **constants):
            super().__init__(**constants)
            self.real = self.s * (1 + 1e-4 * random.Random(self.s).random())

        def moduli(self):
            return 0.5 * self.real, self.real / 3

        def energy(self, F):
            return 0.5 * (self.stress(F) * F).sum() - 0.5 * self.stress(F).trace()

        def stress(self, F):
            return self.real * (0.5 * (F + F.T) - numpy.eye(3))

        def tangent(self, F):
            return self.real * half

    durometer.register_law(Rough)
    text = BEAM.replace("divisions = [4, 2, 2]", "divisions = [1, 1, 1]").replace("neo_hookean", "python_rough")
    scene = durometer.Scene.from_toml(text.replace('E = "100 kPa"\nnu = 0.45', 's = "40 kPa"'))
    run = scene.run(threads=1)
    with pytest.warns(durometer.DoubtfulDerivative, match="by laws.silicone.s ") as told:
        gradient = run.gradient({"xmax_z_m": 1.0}, ["laws.silicone.s"])
    [warning] = told
    [(key, value, error)] = warning.message.doubtful
    assert key == "laws.silicone.s" and value == gradient[0] and error > 1e-6 * abs(value)
    assert warning.filename == __file__


@pytest.mark.parametrize("name", ["torch", "jax"])
def test_a_warning_names_the_line_that_asked_for_derivatives(scene: durometer.Scene, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    from durometer._end_values import EndValues

    class Found:
        run = scene.run()
        columns = COLUMNS
        doubtful = [(COLUMNS[0], KEYS[0], 1e-3)]

        def __getitem__(self, place: tuple[str, str]) -> numpy.ndarray:
            return numpy.array([0.0, 2.0])

    monkeypatch.setattr(EndValues, "_solved", lambda of, numbers: Found())
    at_end = backend(name).function(scene, KEYS[:1], COLUMNS[:1], method="forward")
    with pytest.warns(durometer.DoubtfulDerivative) as told:
        if name == "torch":
            at_end(at_end.start.clone().requires_grad_())[0].backward()
        else:
            importlib.import_module("jax").grad(lambda numbers: at_end(numbers)[0])(at_end.start)
    assert [warning.filename for warning in told] == [__file__]


@pytest.mark.parametrize("name", ["torch", "jax"])
def test_a_warning_names_the_line_that_asked_for_a_run(name: str) -> None:
    at_end = backend(name).function(durometer.Scene.from_toml(LOCKED), KEYS[:1], COLUMNS[:1])
    with pytest.warns(UserWarning, match="locking alarm") as told:
        at_end(at_end.start)
    assert {warning.filename for warning in told} == {__file__}


@pytest.mark.filterwarnings("error::durometer.DoubtfulDerivative")
def test_derivatives_that_are_known_are_not_warned_of(scene: durometer.Scene) -> None:
    assert numpy.isfinite(scene.run().gradient({"xmax_z_m": 1.0}, KEYS[:2])).all()


def test_forward_derivatives_are_warned_of_too(scene: durometer.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    from durometer._end_values import EndValues

    class Found:
        run = scene.run()
        columns = COLUMNS
        doubtful = [(COLUMNS[0], KEYS[0], 1e-3), (COLUMNS[1], KEYS[0], 1e-3)]

        def __getitem__(self, place: tuple[str, str]) -> numpy.ndarray:
            return numpy.array([0.0, 2.0])

    of = EndValues(scene, KEYS[:1], COLUMNS, "forward", None)
    monkeypatch.setattr(of, "_solved", lambda numbers: Found())
    with pytest.warns(durometer.DoubtfulDerivative) as told:
        of.pullback(of.start, numpy.array([1.0, 0.0]))
    assert told[0].message.doubtful == [(f"{KEYS[0]} of {COLUMNS[0]}", 2.0, 2e-3)]


def test_a_column_that_does_not_count_may_have_no_derivative(scene: durometer.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    from durometer._end_values import EndValues

    class Found:
        run = scene.run()
        columns = COLUMNS
        doubtful: list[tuple[str, str, float]] = []

        def __getitem__(self, place: tuple[str, str]) -> numpy.ndarray:
            return numpy.array([0.0, 2.0 if place[0] == COLUMNS[0] else float("nan")])

    of = EndValues(scene, KEYS[:1], COLUMNS, "forward", None)
    monkeypatch.setattr(of, "_solved", lambda numbers: Found())
    assert of.pullback(of.start, numpy.array([3.0, 0.0])).tolist() == [6.0]
    with pytest.raises(durometer.RunError, match=f"{COLUMNS[1]} has no derivative at the end of the run") as caught:
        of.pullback(of.start, numpy.array([3.0, 1.0]))
    assert caught.value.status == "NoDerivative" and caught.value.result is Found.run
    assert of.pullback(of.start, numpy.zeros(2)).tolist() == [0.0]


def test_threads_take_values_of_one_function(scene: durometer.Scene) -> None:
    from durometer._end_values import EndValues

    class Quick:
        """A scene whose run is just its number."""

        def __init__(self, number: float = 0.0) -> None:
            self.number = number

        def set_si(self, key: str, number: float) -> "Quick":
            return Quick(number)

        def run(self, threads: int | None) -> float:
            return self.number

    of = EndValues(scene, KEYS[:1], COLUMNS[:1], "adjoint", None)
    of.scene = Quick()  # type: ignore[assignment]
    numbers = range(20000)
    usual = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(8) as threads:
            found = list(threads.map(lambda number: of._solved(numpy.array([float(number)])), numbers))
    finally:
        sys.setswitchinterval(usual)
    assert found == list(numbers)
