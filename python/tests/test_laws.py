"""Laws in Python: the checks of the library, and the numbers of the same law in Rust."""

import durometer
import numpy
import pytest
from conftest import BEAM, PULLED

IDENTITY = numpy.eye(3)


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
    """The same without the hint that it is linear: its derivatives by constants are differences."""

    name = "python_differenced"
    linear = False


durometer.register_law(Differenced)


class OfParameters(PythonNeoHookean):
    """The same in constants of its own."""

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
    "stress, words",
    [
        (lambda F: numpy.zeros((2, 3)), "stress has 2 rows"),
        (lambda F: numpy.full((3, 3), numpy.nan), "stress has the value NaN"),
        (lambda F: "a text", "stress is no array of numbers"),
        (lambda F: numpy.zeros(9), "stress has the shape"),
    ],
    ids=["shape", "nan", "type", "index"],
)
def test_wrong_answers_of_a_law_are_refused(stress, words: str, request) -> None:
    name = f"python_answers_{request.node.callspec.id}"
    law = type("Answers", (PythonNeoHookean,), {"name": name, "stress": staticmethod(stress)})
    durometer.register_law(law)
    with pytest.raises(durometer.InputError, match=words):
        durometer.Scene.from_toml(BEAM.replace("neo_hookean", name)).run()


def test_a_name_is_taken_once() -> None:
    with pytest.raises(durometer.InputError, match="there is already a law `neo_hookean`"):
        durometer.register_law(type("Taken", (PythonNeoHookean,), {"name": "neo_hookean"}))
    with pytest.raises(durometer.InputError, match="the law has no name"):
        durometer.register_law(type("Nameless", (durometer.Law,), {}))
