"""Runs of a scene as functions of JAX, with derivatives: `pip install "durometer[jax]"`."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy

from ._end_values import EndFunction, EndValues, no_second_derivatives
from ._extras import extra
from ._native import Scene
from .errors import InputError, raise_at_user


def function(
    scene: Scene,
    keys: Sequence[str],
    columns: Sequence[str],
    *,
    method: str = "auto",
    threads: int | None = None,
) -> EndFunction:
    """Returns the function [keys] → [columns] from numbers of the scene, in SI units, to recorded values at the end of its run.

    The function supports `jax.grad`, `jax.jacrev`, `jax.jit` and `jax.vmap`, which calls it row by row. Forward mode (`jax.jvp`, and with it
    `jax.hessian`) raises the `TypeError` of JAX, and a second derivative raises `InputError`. `function.start` has the numbers of the scene, and
    `function.method` says how derivatives are computed: "adjoint" (one solution for each backward pass, whatever the number of keys; static scenes)
    or "forward" (one solution for each key, within the run itself). Switch `jax_enable_x64` on, otherwise JAX rounds numbers and results to
    float32. Within `jax.jit` and `jax.vmap`, JAX replaces an exception of a run by its `JaxRuntimeError`, or by a `ValueError` if an earlier call has
    succeeded, with the text of the exception. `KeyboardInterrupt` is propagated.

    Derivatives are exact for constants of laws of the library and finite differences of the equations, not of runs, for other keys; a warning
    `DoubtfulDerivative` names those whose relative estimated error is above 1e-6.
    """
    jax: Any = extra("jax", "jax")
    of = EndValues(scene, keys, columns, method, threads)

    def called(host: Callable[..., numpy.ndarray], size: int, numbers: Any, *others: Any) -> Any:
        """Calls `host` directly if nothing is traced, so that exceptions are those of the run."""
        host_in_type = lambda *given: host(*map(numpy.asarray, given)).astype(numbers.dtype)  # noqa: E731
        if not any(isinstance(given, jax.core.Tracer) for given in (numbers, *others)):
            return jax.numpy.asarray(host_in_type(numbers, *others))

        def called_back(*given: Any) -> numpy.ndarray:
            try:
                return host_in_type(*given)
            except KeyboardInterrupt as interrupt:
                # JAX turns it into an error like that of a design without an answer
                raise_at_user(interrupt)
                raise

        shape = jax.ShapeDtypeStruct((size,), numbers.dtype)
        return jax.pure_callback(called_back, shape, numbers, *others, vmap_method="sequential")

    @jax.custom_vjp
    def ended(numbers: Any) -> Any:
        return called(of.values, len(of.columns), numbers)

    def forward(numbers: Any) -> Any:
        return ended(numbers), numbers

    @jax.custom_jvp
    def derivative(numbers: Any, weights: Any) -> Any:
        return called(of.pullback, len(of.keys), numbers, weights)

    @derivative.defjvp
    def second(primals: Any, tangents: Any) -> Any:
        raise no_second_derivatives()

    def backward(numbers: Any, weights: Any) -> Any:
        return (derivative(numbers, weights),)

    ended.defvjp(forward, backward)

    def at_end(numbers: Any) -> Any:
        numbers = jax.numpy.asarray(numbers)
        if not jax.numpy.issubdtype(numbers.dtype, jax.numpy.floating):
            raise InputError(f"the numbers are of the type {numbers.dtype}", "give an array of floating-point numbers")
        of.checked(numbers.shape)
        return ended(numbers)

    at_end.start = of.start  # type: ignore[attr-defined]
    at_end.method = of.method  # type: ignore[attr-defined]
    return at_end  # type: ignore[return-value]
