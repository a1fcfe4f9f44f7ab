"""A measured curve, and the scene that should reproduce it."""

from dataclasses import dataclass
from typing import Any

from ._native import Scene


@dataclass(frozen=True)
class Curve:
    """A measured curve y(x), in the units of the columns of its scene.

    `over` is the time `t_s` or a signal that the scene prescribes, with the measured values `x`; `column` is a recorded column with the measured
    values `y`. Curves of one `specimen` share its level; a curve without a specimen name belongs to a specimen of its own.
    """

    scene: Scene
    over: str
    x: Any
    column: str
    y: Any
    name: str = "curve"
    specimen: str | None = None
