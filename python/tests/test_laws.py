"""Laws in Python: the checks of the library, and the numbers of the same law in Rust."""

import re
import threading

import durometer
import numpy
import pytest
from conftest import BEAM, PULLED

IDENTITY = numpy.eye(3)
#: One cell
SMALL = BEAM.replace("divisions = [4, 2, 2]", "divisions = [1, 1, 1]")


class PythonNeoHookean(durometer.Law):
    """ψ = ½μ(I₁ − 3) − μ ln J + ½λ(ln J)², as `neo_hookean` of the library (Bonet & Wood 2008, eq. 6.27)."""

    name = "python_neo_hookean"
    formula = "ψ = ½μ(I₁ − 3) − μ ln J + ½λ(ln J)²"
    source = "Bonet & Wood 2008, eq. 6.27"
    linear = True

    def energy(self, F):
        k = durometer.Invariants(F)
        return 0.5 * self.mu * k.I1_minus_3_minus_2_ln_J + 0.5 * self.lambda_ * k.ln_J**2

    def stress(self, F):
        k = durometer.Invariants(F)
        G = k.cofactor / k.J
        return self.mu * (F - G) + self.lambda_ * k.ln_J * G

    def tangent(self, F):
        k = durometer.Invariants(F)
        G = k.cofactor / k.J
        direct = numpy.einsum("ik,JL->iJkL", IDENTITY, IDENTITY)
        crossed = numpy.einsum("iL,kJ->iJkL", G, G)
        return self.mu * direct + self.lambda_ * numpy.einsum("iJ,kL->iJkL", G, G) + (self.mu - self.lambda_ * k.ln_J) * crossed


durometer.register_law(PythonNeoHookean)


class Differenced(PythonNeoHookean):
    """The Neo-Hookean law without the hint that it is linear: its derivatives with respect to constants are differences."""

    name = "python_differenced"
    linear = False


durometer.register_law(Differenced)


class OfParameters(PythonNeoHookean):
    """The Neo-Hookean law with constants of its own."""

    name = "python_parameters"
    linear = False
    parameters = [
        durometer.Parameter("shear", "μ", "Pa", (0.0, float("inf")), "shear modulus"),
        durometer.Parameter("ratio", "r", "1", (0.1, 100.0), "bulk modulus over shear modulus"),
    ]
    sample = [40e3, 5.0]

    def __init__(self, **constants):
        super().__init__(**constants)
        self.mu = self.shear
        self.lambda_ = (self.ratio - 2 / 3) * self.shear

    def moduli(self):
        return self.shear, self.ratio * self.shear


durometer.register_law(OfParameters)


@pytest.mark.parametrize("name", ["python_neo_hookean", "python_differenced", "python_parameters"])
def test_the_law_passes_the_checks_of_the_library(name: str) -> None:
    durometer.check_law(name)


@pytest.mark.parametrize("bounds, shear", [((0.0, 1e3), 400.0), ((1e6, 1e9), 1e7)], ids=["gel", "composite"])
def test_a_law_is_checked_within_the_bounds_of_its_constants(bounds: tuple[float, float], shear: float) -> None:
    class Bounded(OfParameters):
        name = f"python_bounded_{shear:.0f}"
        parameters = [durometer.Parameter("shear", "μ", "Pa", bounds, "shear modulus"), OfParameters.parameters[1]]
        sample = [shear, 5.0]

    durometer.register_law(Bounded)
    durometer.check_law(Bounded.name)


@pytest.mark.parametrize("unit, remedy", [("kPa", "write Pa"), ("mm", "write m")])
def test_a_parameter_has_an_si_unit(unit: str, remedy: str) -> None:
    class InOtherUnits(OfParameters):
        name = "python_in_other_units"
        parameters = [OfParameters.parameters[0]._replace(unit=unit), OfParameters.parameters[1]]

    with pytest.raises(durometer.InputError, match=f"the unit of the parameter shear is {unit}.*; {remedy},"):
        durometer.register_law(InOtherUnits)


def test_a_wrong_tangent_is_found() -> None:
    class Wrong(PythonNeoHookean):
        name = "python_wrong"

        def tangent(self, F):
            return 1.001 * super().tangent(F)

    durometer.register_law(Wrong)
    with pytest.raises(durometer.InputError, match="fails the check Tangent"):
        durometer.check_law("python_wrong")


def test_a_scene_has_the_numbers_of_the_law_in_rust() -> None:
    text = PULLED.replace('dt = "0.5 s"', 'dt = "1 s"').replace("divisions = [4, 2, 2]", "divisions = [2, 1, 1]")
    here = durometer.Scene.from_toml(text.replace("neo_hookean", "python_neo_hookean"))
    there = durometer.Scene.from_toml(text)
    ours, theirs = here.run().values, there.run().values
    # The same formulae in another order of additions: Newton's method stops at 1e-8 of the forces
    scale = numpy.abs(theirs).max(axis=0)
    assert (numpy.abs(ours - theirs) <= 1e-9 * scale + 1e-15).all()


def test_derivatives_by_its_constants_are_those_of_the_law_in_rust() -> None:
    text = PULLED.replace('dt = "0.5 s"', 'dt = "1 s"').replace("divisions = [4, 2, 2]", "divisions = [1, 1, 1]")
    expected = durometer.Scene.from_toml(text).sensitivities(["laws.silicone.E", "laws.silicone.nu"])
    for name in ["python_neo_hookean", "python_differenced"]:
        found = durometer.Scene.from_toml(text.replace("neo_hookean", name)).sensitivities(expected.keys)
        assert found.columns == expected.columns
        # Components that are zero by symmetry are compared on the scale of the others of their unit
        unit = [expected.run.units[column] for column in expected.columns]
        largest = numpy.abs(expected.values).max(axis=0)
        scale = numpy.array([largest[[other == one for other in unit]].max(axis=0) for one in unit])
        assert (numpy.abs(found.values - expected.values) <= 1e-6 * scale).all(), name


@pytest.mark.parametrize(
    "constants",
    ['E = "100 kPa"\nnu = 0.495', 'E = "100 kPa"\nnu = 0.4975', 'E = "100 kPa"\nnu = 0.499', 'mu = "34 kPa"\nkappa = "33 MPa"'],
)
def test_derivatives_next_to_incompressibility(constants: str) -> None:
    text = BEAM.replace('dt = "0.5 s"', 'dt = "1 s"').replace("divisions = [4, 2, 2]", "divisions = [2, 1, 1]")
    text = text.replace('E = "100 kPa"\nnu = 0.45', constants)
    keys = [f"laws.silicone.{line.split()[0]}" for line in constants.splitlines()]
    there = durometer.Scene.from_toml(text)
    here = durometer.Scene.from_toml(text.replace("neo_hookean", "python_differenced"))
    expected, found = there.sensitivities(keys), here.sensitivities(keys)
    assert not found.doubtful and (expected.errors == 0.0).all()
    weights = {"xmax_z_m": 1.0}
    exact, adjoint = there.run().gradient(weights, keys), here.run().gradient(weights, keys)
    for k, key in enumerate(keys):
        # Where hardly anything depends on the constant, rounding of the differences is 1e-8 of what does not
        assert found["xmax_z_m", key][-1] == pytest.approx(expected["xmax_z_m", key][-1], rel=1e-6)
        assert adjoint[k] == pytest.approx(exact[k], rel=1e-6)
        assert found.errors[found.columns.index("xmax_z_m"), k] > 0.0


def test_a_law_that_raises_ends_the_run_by_its_exception() -> None:
    class Raises(PythonNeoHookean):
        name = "python_raises"

        def energy(self, F):
            raise ZeroDivisionError("in the law")

    durometer.register_law(Raises)
    scene = durometer.Scene.from_toml(BEAM.replace("neo_hookean", "python_raises"))
    with pytest.raises(ZeroDivisionError, match="in the law"):
        scene.run()


@pytest.mark.parametrize(
    "method, answer, words",
    [
        ("stress", numpy.zeros((2, 3)), r"the stress of the law LAW has the shape \(2, 3\); give one of shape \(3, 3\)"),
        ("stress", numpy.full((3, 3), numpy.nan), "is not defined at rest, F = I: the stress of the law LAW is NaN"),
        ("stress", "a text", "the stress of the law LAW is no array of numbers"),
        ("stress", numpy.zeros(9), "the stress of the law LAW has the shape"),
        ("stress", None, "the stress of the law LAW is None; give a list of real numbers"),
        ("stress", numpy.zeros((3, 3), complex), "the stress of the law LAW is an array of complex numbers"),
        ("tangent", numpy.zeros((3, 3, 3)), "the tangent of the law LAW has the shape"),
        ("energy", None, "the energy of the law LAW is of the type NoneType, and no number; return a float"),
        ("energy", 1j, "the energy of the law LAW is of the type complex, and no number"),
        ("energy", [1.0], "the energy of the law LAW is of the type list, and no number"),
    ],
)
def test_wrong_answers_of_a_law_are_refused(method: str, answer, words: str, request) -> None:
    name = f"python_answers_{abs(hash(request.node.callspec.id))}"
    durometer.register_law(type("Answers", (PythonNeoHookean,), {"name": name, method: lambda self, F: answer}))
    with pytest.raises(durometer.InputError, match=words.replace("LAW", name)):
        durometer.Scene.from_toml(BEAM.replace("neo_hookean", name)).run()


def test_moduli_are_any_pair() -> None:
    text = BEAM.replace('E = "100 kPa"\nnu = 0.45', 'shear = "40 kPa"\nratio = 5.0').replace("divisions = [4, 2, 2]", "divisions = [1, 1, 1]")
    for k, pair in enumerate([list, tuple, numpy.array]):
        law = type("Pair", (OfParameters,), {"name": f"python_pair_{k}", "moduli": lambda self, pair=pair: pair([self.shear, self.ratio * self.shear])})
        durometer.register_law(law)
        assert durometer.Scene.from_toml(text.replace("neo_hookean", law.name)).run().converged
    for answer in (None, 40e3, [40e3]):
        law = type("Wrong", (OfParameters,), {"name": "python_no_pair", "moduli": lambda self, answer=answer: answer})
        durometer.register_law(law)
        with pytest.raises(durometer.InputError, match="the answer of `moduli` of the law python_no_pair"):
            durometer.Scene.from_toml(text.replace("neo_hookean", law.name)).run()


def test_shapes_are_named_as_the_reference_names_them() -> None:
    for answer, shape in [(numpy.zeros((3, 3)), r"\(3, 3\)"), (numpy.zeros(80), r"\(80,\)")]:
        law = type("Flat", (PythonNeoHookean,), {"name": "python_flat", "tangent": lambda self, F, answer=answer: answer})
        durometer.register_law(law)
        with pytest.raises(durometer.InputError, match=rf"the tangent of the law python_flat has the shape {shape}; give one of shape \(3, 3, 3, 3\)"):
            durometer.check_law("python_flat")
    matrix = {"tangent": lambda self, F: PythonNeoHookean.tangent(self, F).reshape(9, 9)}
    durometer.register_law(type("Matrix", (PythonNeoHookean,), {"name": "python_matrix", **matrix}))
    durometer.check_law("python_matrix")
    for given in (numpy.eye(2), numpy.zeros((4, 3)), numpy.zeros(9)):
        with pytest.raises(durometer.InputError, match=r"F has the shape .*; give one of shape \(3, 3\)"):
            durometer.Invariants(given)


def test_a_name_is_taken_once() -> None:
    with pytest.raises(durometer.InputError, match="there is already a law `neo_hookean`"):
        durometer.register_law(type("Taken", (PythonNeoHookean,), {"name": "neo_hookean"}))
    with pytest.raises(durometer.InputError, match="the law has no name"):
        durometer.register_law(type("Nameless", (durometer.Law,), {}))


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (PythonNeoHookean(), "an object of the class PythonNeoHookean is given, and no class; give the class of the law itself"),
        (int, "the class int does not extend durometer.Law; give the class of the law itself"),
        ("python_neo_hookean", "an object of the class str is given"),
    ],
    ids=["object", "class", "name"],
)
def test_only_a_class_of_a_law_is_registered(law, words: str) -> None:
    with pytest.raises(durometer.InputError, match=words):
        durometer.register_law(law)
    durometer.check_law("python_neo_hookean")


class Chains(PythonNeoHookean):
    """Gent's law (1996) with a volumetric part, which is defined for I1 - 3 < J_m."""

    name = "python_chains"
    linear = False
    parameters = [
        durometer.Parameter("shear", "μ", "Pa", (0.0, float("inf")), "shear modulus"),
        durometer.Parameter("J_m", "J_m", "1", (0.5, float("inf")), "I1 - 3 of fully stretched chains"),
    ]
    sample = [40e3, 2.0]

    def __init__(self, **constants):
        super().__init__(**constants)
        self.lambda_ = 4 * self.shear

    def moduli(self):
        return self.shear, self.lambda_ + 2 * self.shear / self.J_m + 2 / 3 * self.shear

    def left(self, k):
        share = 1 - k.I1_minus_3 / self.J_m
        return share if share > 0 else float("nan")

    def energy(self, F):
        k = durometer.Invariants(F)
        chains = numpy.log1p(-k.I1_minus_3 / self.J_m) if self.left(k) > 0 else float("nan")
        return -0.5 * self.shear * self.J_m * chains - self.shear * k.ln_J + 0.5 * self.lambda_ * k.J_minus_1**2

    def stress(self, F):
        k = durometer.Invariants(F)
        G = k.cofactor / k.J
        return self.shear * (F / self.left(k) - G) + self.lambda_ * k.J_minus_1 * k.J * G

    def tangent(self, F):
        k = durometer.Invariants(F)
        G, left = k.cofactor / k.J, self.left(k)
        direct = self.lambda_ * (2 * k.J - 1) * k.J
        crossed = self.shear - self.lambda_ * k.J_minus_1 * k.J
        return (
            self.shear / left * numpy.einsum("ik,JL->iJkL", IDENTITY, IDENTITY)
            + 2 * self.shear / (self.J_m * left**2) * numpy.einsum("iJ,kL->iJkL", F, F)
            + direct * numpy.einsum("iJ,kL->iJkL", G, G)
            + crossed * numpy.einsum("iL,kJ->iJkL", G, G)
        )


class Raising(Chains):
    """Gent's law, raising an exception where it is not defined."""

    name = "python_raising_chains"

    def energy(self, F):
        if durometer.Invariants(F).I1_minus_3 >= self.J_m:
            raise durometer.OutOfDomain
        return super().energy(F)


#: A block of one cell and one step with such a law
LIMITED = (
    PULLED.replace("divisions = [4, 2, 2]", "divisions = [1, 1, 1]")
    .replace('dt = "0.5 s"', 'dt = "1 s"')
    .replace('E = "100 kPa"\nnu = 0.45', 'shear = "10 Pa"\nJ_m = 0.6')
)
#: It hangs from its face, and a full first step of Newton's method leaves the domain
HANGING = LIMITED[: LIMITED.rindex("[[constraint]]")].replace("[0, 0, -1]", "[1, 0, 0]")


@pytest.mark.parametrize("law", [Chains, Raising], ids=["nan", "raises"])
def test_a_law_with_a_limited_domain_takes_shorter_steps(law: type[durometer.Law]) -> None:
    beyond = []

    class Seen(law):
        def energy(self, F):
            beyond.append(durometer.Invariants(F).I1_minus_3 >= self.J_m)
            return super().energy(F)

    durometer.register_law(Seen)
    scene = durometer.Scene.from_toml(HANGING.replace("neo_hookean", law.name))
    assert scene.columns
    # Only trial states of the run from here on
    beyond.clear()
    assert scene.run(threads=1).converged and any(beyond)
    torn = durometer.Scene.from_toml(LIMITED.replace("neo_hookean", law.name).replace('"2 mm"', '"40 mm"'))
    with pytest.raises(durometer.RunError) as caught:
        torn.run(threads=1)
    assert "domain of its law" in caught.value.fact and len(caught.value.result) >= 1


@pytest.mark.parametrize("law", [Chains, Raising], ids=["nan", "raises"])
def test_a_law_with_a_limited_domain_is_checked_within_it(law: type[durometer.Law]) -> None:
    durometer.register_law(law)
    durometer.check_law(law.name)


def test_a_law_that_is_not_defined_at_rest_is_refused() -> None:
    class Nowhere(PythonNeoHookean):
        name = "python_nowhere"

        def energy(self, F):
            raise durometer.OutOfDomain("it is a joke")

    durometer.register_law(Nowhere)
    with pytest.raises(durometer.InputError, match="not defined at rest, F = I: it is a joke"):
        durometer.Scene.from_toml(BEAM.replace("neo_hookean", "python_nowhere")).run()
    with pytest.raises(durometer.InputError, match="not defined at rest"):
        durometer.check_law("python_nowhere")


def test_the_checks_write_gradients_by_rows() -> None:
    class Leaning(PythonNeoHookean):
        name = "python_leaning"

        def stress(self, F):
            return super().stress(F).T

    durometer.register_law(Leaning)
    with pytest.raises(durometer.InputError, match=r"at F = \[\[.*\], \[.*\], \[.*\]\]: P\[0\]\[1\]"):
        durometer.check_law("python_leaning")


def test_a_check_names_constants_and_the_state_at_which_it_fails() -> None:
    class Stressed(PythonNeoHookean):
        """P = μF, which is not zero at rest."""

        name = "python_stressed"

        def energy(self, F):
            return 0.5 * self.mu * ((F * F).sum() - 3)

        def stress(self, F):
            return self.mu * F

        def tangent(self, F):
            return self.mu * numpy.einsum("ik,JL->iJkL", IDENTITY, IDENTITY)

    durometer.register_law(Stressed)
    at_rest = r"fails the check Reference: with E = \S+ Pa, nu = \S+ at F = I: P = \[\[.*\], \[.*\], \[.*\]\]$"
    with pytest.raises(durometer.InputError) as caught:
        durometer.check_law("python_stressed")
    assert re.search(at_rest, caught.value.fact), caught.value.fact
    assert caught.value.remedy.startswith("let energy and stress vanish at F = I")


def test_an_exception_belongs_to_the_run_in_which_it_was_raised() -> None:
    class Late(PythonNeoHookean):
        name = "python_late"
        calls = 0
        armed = False

        def energy(self, F):
            Late.calls += 1
            if Late.armed and Late.calls > 200:
                raise ZeroDivisionError("late")
            return super().energy(F)

    durometer.register_law(Late)
    text = BEAM.replace("neo_hookean", "python_late").replace("divisions = [4, 2, 2]", "divisions = [1, 1, 1]")
    scene = durometer.Scene.from_toml(text)
    assert scene.columns
    Late.armed, Late.calls = True, -1000
    ends: list[str] = []

    def work() -> None:
        for _ in range(4):
            try:
                ends.append(scene.run(threads=1).status)
            except BaseException as error:
                ends.append(type(error).__name__)

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert set(ends) <= {"Converged", "ZeroDivisionError"} and "ZeroDivisionError" in ends, ends


@pytest.mark.parametrize("linear", [True, False])
def test_a_law_is_registered_again(linear: bool) -> None:
    name = f"python_again_{linear}"
    law = {"name": name, "linear": linear}
    durometer.register_law(type("Again", (PythonNeoHookean,), law))
    text = BEAM.replace("neo_hookean", name).replace("divisions = [4, 2, 2]", "divisions = [1, 1, 1]").replace('dt = "0.5 s"', 'dt = "1 s"')
    before, unbuilt = durometer.Scene.from_toml(text), durometer.Scene.from_toml(text)
    keys, weights = ["laws.silicone.E", "effect.gravity.density", "mesh.grid.size.2"], {"xmax_z_m": 1.0}
    run = before.run(threads=1)
    sunk, gradient, derivatives = run["xmax_z_m"], run.gradient(weights, keys), before.sensitivities(keys, threads=1).values
    double = {method: lambda self, F, method=method: 2 * getattr(PythonNeoHookean, method)(self, F) for method in ("energy", "stress", "tangent")}
    durometer.register_law(type("Again", (PythonNeoHookean,), {**law, **double}))
    # Scenes that exist keep their law, also where they are assembled and differentiated later, and where another value makes another scene
    for scene in (before, unbuilt, before.set("laws.silicone.E", "100 kPa")):
        again = scene.run(threads=1)
        assert numpy.array_equal(again["xmax_z_m"], sunk)
        assert numpy.array_equal(again.gradient(weights, keys), gradient)
        assert numpy.array_equal(scene.sensitivities(keys, threads=1).values, derivatives)
    assert numpy.array_equal(run.gradient(weights, keys), gradient)
    after = durometer.Scene.from_toml(text).run()["xmax_z_m"]
    assert abs(after[-1] - after[0]) < 0.7 * abs(sunk[-1] - sunk[0])


def test_a_scene_keeps_the_constants_of_its_law() -> None:
    name = "python_renamed"

    def registered(**changes: object) -> None:
        durometer.register_law(type("Renamed", (OfParameters,), {"name": name, **changes}))

    def other_bounds(least: float, most: float) -> list[durometer.Parameter]:
        return [durometer.Parameter("shear", "μ", "Pa", (least, most), "shear modulus"), OfParameters.parameters[1]]

    registered()
    text = SMALL.replace("neo_hookean", name).replace('E = "100 kPa"\nnu = 0.45', 'shear = "40 kPa"\nratio = 5.0')
    scene = durometer.Scene.from_toml(text)
    run = scene.run(threads=1)
    start = scene.set("laws.silicone.shear", "30 kPa")
    curve = durometer.Curve(start, "t_s", run.times[1:], "xmax_z_m", run["xmax_z_m"][1:])
    renamed = durometer.Parameter("stiffness", "μ", "Pa", (0.0, float("inf")), "shear modulus")
    for changes in ({"parameters": [renamed, OfParameters.parameters[1]]}, {"parameters": other_bounds(0.0, 20e3)}):
        registered(**changes)
        again = start.set("laws.silicone.shear", "40 kPa").run(threads=1)
        assert numpy.array_equal(again["xmax_z_m"], run["xmax_z_m"])
        found = durometer.Calibration.from_curves([curve], ["laws.silicone.shear"], threads=1, check=False)
        assert found.constants["laws.silicone.shear"] == pytest.approx(40e3, rel=1e-3)


class Graded(PythonNeoHookean):
    """The same with a shear modulus that falls with a length."""

    name = "python_graded"
    linear = False
    parameters = [
        durometer.Parameter("shear", "μ", "Pa", (0.0, float("inf")), "shear modulus of a thin wall"),
        durometer.Parameter("depth", "d", "m", (0.0, float("inf")), "wall at which it is half of that"),
    ]
    sample = [40e3, 1e-3]

    def __init__(self, **constants):
        super().__init__(**constants)
        self.mu = self.shear / (1 + 1e-3 / self.depth)
        self.lambda_ = 5 * self.mu

    def moduli(self):
        return self.mu, self.lambda_ + 2 / 3 * self.mu


@pytest.mark.parametrize("bounds", [["laws.silicone.depth"], {"laws.silicone.depth": ("0.1 mm", "5 mm")}], ids=["free", "bounded"])
def test_a_constant_of_any_unit_is_calibrated(bounds: object) -> None:
    durometer.register_law(Graded)
    text = SMALL.replace("neo_hookean", Graded.name).replace('E = "100 kPa"\nnu = 0.45', 'shear = "60 kPa"\ndepth = "1 mm"')
    truth = durometer.Scene.from_toml(text)
    run = truth.run(threads=1)
    curve = durometer.Curve(truth.set("laws.silicone.depth", "0.7 mm"), "t_s", run.times[1:], "xmax_z_m", run["xmax_z_m"][1:])
    found = durometer.Calibration.from_curves([curve], bounds, threads=1, check=False)
    assert found.constants["laws.silicone.depth"] == pytest.approx(1e-3, rel=1e-3) and found.units == {"laws.silicone.depth": "m"}
    assert found.scene.get_si("laws.silicone.depth") == pytest.approx(1e-3, rel=1e-3)
