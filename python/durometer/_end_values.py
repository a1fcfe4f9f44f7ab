"""Recorded values at the end of a run as a function of numbers of its scene, with derivatives: the common part of `durometer.torch` and
`durometer.jax`."""

from collections import OrderedDict
from collections.abc import Sequence
from threading import Lock
from typing import Any, Protocol

import numpy

from ._native import Run, Scene, set_threads
from .errors import InputError, RunError, warn_of_doubtful

#: Number of runs that are kept for their derivatives
KEPT = 2


class EndFunction(Protocol):
    """A function [keys] → [columns]."""

    #: The numbers of the scene
    start: Any
    #: "adjoint" or "forward"
    method: str

    def __call__(self, numbers: Any) -> Any: ...


def no_second_derivatives() -> InputError:
    """Returns the refusal of a second derivative."""
    fact = "a run has no second derivatives, which a Hessian, a penalty of a gradient or Newton's method takes"
    return InputError(fact, "take differences of gradients, or a method that needs first derivatives only, such as L-BFGS")


def names(what: str, given: Any, example: str) -> list[str]:
    """Returns a list of names, which must be distinct."""
    if isinstance(given, str) or not isinstance(given, Sequence) or not all(isinstance(name, str) for name in given):
        raise InputError(f"{what} is no list of names", f"write for example {example}")
    if not given or len(set(given)) < len(given):
        raise InputError(f"{what} is empty or names one twice", f"write for example {example}")
    return list(given)


class EndValues:
    """[keys] numbers of a scene in SI units → [columns] values at the end of its run."""

    def __init__(self, scene: Scene, keys: Sequence[str], columns: Sequence[str], method: str, threads: int | None):
        if not isinstance(scene, Scene):
            raise InputError(f"scene is of the type {type(scene).__name__}", "give a durometer.Scene")
        if "refine" in scene.get("mesh"):
            fact = "the scene has mesh.refine, which makes another mesh for each design: the values jump between them"
            raise InputError(fact, "take refine out of [mesh], and give cells that are as small as those of its last mesh")
        # The scene is assembled and asked for its columns with the same number of threads as it is run
        set_threads(threads)
        self.scene = scene
        self.keys = names("keys", keys, '["laws.rubber.mu"]')
        self.columns = names("columns", columns, '["xmax_z_m"]')
        self.threads = threads
        #: The values of the keys in the scene
        self.start = numpy.array([scene.get_si(key) for key in self.keys])
        missing = [name for name in self.columns if name not in scene.columns]
        if missing:
            raise InputError(f"no column {', '.join(missing)}", f"known: {', '.join(scene.columns)}")
        self.method = chosen(scene, method)
        known = scene._differentiable(self.keys)
        without = [name for name in self.columns if name not in known]
        if without:
            remedy = f"take columns that have one: {', '.join(known)}" if known else "add a [[probe]] whose columns have one, such as position"
            raise InputError(f"{', '.join(without)} has no derivative", remedy)
        self._runs: OrderedDict[bytes, Any] = OrderedDict()
        #: Held while `_runs` is read or changed, but not during a run
        self._lock = Lock()

    def values(self, numbers: numpy.ndarray) -> numpy.ndarray:
        """Returns the values [columns]; raises `RunError` if the run does not complete, or if the scene refuses these numbers."""
        found = self._solved(numbers)
        run = found if isinstance(found, Run) else found.run
        return numpy.array([run[name][-1] for name in self.columns])

    def pullback(self, numbers: numpy.ndarray, weights: numpy.ndarray) -> numpy.ndarray:
        """Returns the derivatives [keys] of Σ weights · values; raises `RunError` if there are none. A warning names doubtful ones."""
        if not numpy.isfinite(weights).all():
            fact = f"the derivative by {', '.join(self.columns)} is {numpy.asarray(weights).tolist()}"
            raise InputError(fact, "let what is computed from the values be finite")
        found = self._solved(numbers)
        # A column of weight zero need not have a derivative
        weighted = {name: float(weight) for name, weight in zip(self.columns, weights) if weight}
        if isinstance(found, Run):
            try:
                return found.gradient(weighted, self.keys)
            except InputError as refused:
                raise RunError(refused.fact, refused.remedy, "NoDerivative", result=found) from refused
        jacobian = {name: numpy.array([found[name, key][-1] for key in self.keys]) for name in weighted}
        undefined = [name for name, row in jacobian.items() if numpy.isnan(row).any()]
        if undefined:
            fact = f"{', '.join(undefined)} has no derivative at the end of the run"
            raise RunError(fact, "take another column, or end the run before", "NoDerivative", result=found.run)
        doubtful = [(column, key, error) for column, key, error in found.doubtful if column in weighted]
        sizes = {(column, key): float(abs(found[column, key]).max()) for column, key, _ in doubtful}
        warn_of_doubtful(
            [(f"{key} of {column}", float(found[column, key][-1]), error * sizes[column, key]) for column, key, error in doubtful]
        )
        return sum((weighted[name] * row for name, row in jacobian.items()), numpy.zeros(len(self.keys)))

    def checked(self, shape: tuple[int, ...]) -> None:
        """Refuses numbers of the wrong shape."""
        if tuple(shape) != (len(self.keys),):
            fact = f"the numbers have the shape {tuple(shape)}, and there are {len(self.keys)} keys"
            raise InputError(fact, f"give one number for each of {', '.join(self.keys)}, in SI units")

    def _solved(self, numbers: numpy.ndarray) -> Any:
        """Returns the run with these numbers or, if the adjoint cannot be used, its sensitivities; kept for the next call."""
        numbers = numpy.asarray(numbers, dtype=float)
        self.checked(numbers.shape)
        place = numbers.tobytes()
        with self._lock:
            found = self._runs.get(place)
        if found is None:
            set_threads(self.threads)
            found = self._computed(numbers)
            with self._lock:
                self._runs[place] = found
                while len(self._runs) > KEPT:
                    self._runs.popitem(last=False)
        return found

    def _computed(self, numbers: numpy.ndarray) -> Any:
        """Runs the scene again. The keys are known to exist, so that a refusal is due to the numbers: they are a design without an answer."""
        scene = self.scene
        try:
            if not numpy.isfinite(numbers).all():
                raise InputError(f"the numbers are {numbers.tolist()}", "give finite numbers")
            for key, number in zip(self.keys, numbers):
                scene = scene.set_si(key, float(number))
            if self.method == "adjoint":
                return scene.run(threads=self.threads)
            return scene.sensitivities(self.keys, threads=self.threads)
        except InputError as refused:
            raise RunError(refused.fact, refused.remedy, refused.status, result=refused.result) from refused


def chosen(scene: Scene, method: str) -> str:
    """Returns the method, "adjoint" or "forward"."""
    if method == "auto":
        try:
            scene.check_gradient()
        except InputError:
            return "forward"
        return "adjoint"
    if method == "adjoint":
        scene.check_gradient()
    elif method != "forward":
        raise InputError(f"there is no method {method!r}", "take auto, adjoint or forward")
    return method
