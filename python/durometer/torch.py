"""Runs of a scene as functions of PyTorch, with derivatives: `pip install "durometer[torch]"`."""

from collections.abc import Sequence
from typing import Any

import numpy

from ._end_values import EndFunction, EndValues, no_second_derivatives
from ._extras import extra
from ._native import Scene
from .errors import InputError


def function(
    scene: Scene,
    keys: Sequence[str],
    columns: Sequence[str],
    *,
    method: str = "auto",
    threads: int | None = None,
) -> EndFunction:
    """Returns the function [keys] → [columns] from numbers of the scene, in SI units, to recorded values at the end of its run.

    `function.start` has the numbers of the scene, and `function.method` says how derivatives are computed: "adjoint" (one solution for each
    backward pass, whatever the number of keys; static scenes) or "forward" (one solution for each key, within the run itself). Second derivatives
    raise `InputError`. float32 tensors are computed in float64.

    Derivatives are exact for constants of laws of the library and finite differences of the equations, not of runs, for other keys; a warning
    `DoubtfulDerivative` names those whose relative estimated error is above 1e-6.
    """
    torch: Any = extra("torch", "torch")
    of = EndValues(scene, keys, columns, method, threads)

    class _Ended(torch.autograd.Function):
        @staticmethod
        def forward(ctx: Any, numbers: Any) -> Any:
            ctx.save_for_backward(numbers)
            return numbers.new_tensor(of.values(in_float64(numbers)))

        @staticmethod
        def backward(ctx: Any, weights: Any) -> Any:
            (numbers,) = ctx.saved_tensors
            return _Derivative.apply(numbers, weights)

    class _Derivative(torch.autograd.Function):
        @staticmethod
        def forward(ctx: Any, numbers: Any, weights: Any) -> Any:
            return numbers.new_tensor(of.pullback(in_float64(numbers), in_float64(weights)))

        @staticmethod
        def backward(ctx: Any, weights: Any) -> Any:
            raise no_second_derivatives()

    def at_end(numbers: Any) -> Any:
        if not isinstance(numbers, torch.Tensor) or not numbers.dtype.is_floating_point:
            kind = numbers.dtype if isinstance(numbers, torch.Tensor) else type(numbers).__name__
            raise InputError(f"the numbers are of the type {kind}", "give a torch.Tensor of float64")
        of.checked(tuple(numbers.shape))
        return _Ended.apply(numbers)

    at_end.start = torch.tensor(of.start, dtype=torch.float64)  # type: ignore[attr-defined]
    at_end.method = of.method  # type: ignore[attr-defined]
    return at_end  # type: ignore[return-value]


def in_float64(numbers: Any) -> numpy.ndarray:
    """Returns a copy in float64 on the CPU."""
    return numbers.detach().cpu().double().numpy()
