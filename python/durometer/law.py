"""The base of laws in Python."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

if TYPE_CHECKING:
    import numpy


class Parameter(NamedTuple):
    """A constant of a law: its key in files, its symbol, its SI unit ("Pa", or "1" for none), its open interval [SI] and its meaning."""

    name: str
    symbol: str
    unit: str
    bounds: tuple[float, float]
    meaning: str


class Law:
    """A hyperelastic law in Python. This path is slow: each evaluation at each quadrature point waits for the interpreter.

    A subclass defines `name` and the methods `energy`, `stress` and `tangent`; `register_law` makes it known to scenes, and
    `check_law` compares the three methods with each other. With `parameters = "elastic"` an object has the attributes `nu` [–] and `E`, `mu`, `lambda_`
    and `kappa` [Pa]; otherwise it has an attribute for each of its parameters, and the class must define `sample` and the method `moduli`.

    Where the law is not defined, such as beyond the largest stretch of its chains, a method must return a number that is not finite or raise
    `OutOfDomain`: the run then takes a shorter step. The law must be defined at rest.
    """

    #: Name in scenes
    name: ClassVar[str] = ""
    #: Name as written in papers, formula of the energy, its source, and the limits of its use
    title: ClassVar[str] = ""
    formula: ClassVar[str] = "in Python"
    source: ClassVar[str] = "in Python"
    limits: ClassVar[str] = "J > 0"
    #: "elastic", or a list of `Parameter`
    parameters: ClassVar[Any] = "elastic"
    #: Values of the parameters for checks [SI]; for an elastic law E = 100 kPa and nu = 0.4
    sample: ClassVar[list[float]] = []
    #: Whether the law is defined for J ≤ 0
    survives_inversion: ClassVar[bool] = False
    #: Whether rotations leave the energy unchanged
    objective: ClassVar[bool] = True
    #: Whether the energy of an elastic law is linear in `mu` and `lambda_`: derivatives with respect to its constants are then exact, otherwise
    #: differences
    linear: ClassVar[bool] = False

    def __init__(self, **constants: float) -> None:
        for name, value in constants.items():
            setattr(self, name, value)

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        cls.title = cls.title or cls.name

    def moduli(self) -> tuple[float, float]:
        """Returns shear modulus and bulk modulus at small strain [Pa]."""
        raise NotImplementedError(f"the law {self.name} needs a method `moduli`, its shear and bulk modulus")

    def energy(self, F: numpy.ndarray) -> float:
        """Returns the energy density ψ at the deformation gradient F [3 × 3], in J/m³."""
        raise NotImplementedError(f"the law {self.name} needs a method `energy`")

    def stress(self, F: numpy.ndarray) -> numpy.ndarray:
        """Returns the first Piola–Kirchhoff stress P = ∂ψ/∂F [3 × 3], in Pa."""
        raise NotImplementedError(f"the law {self.name} needs a method `stress`")

    def tangent(self, F: numpy.ndarray) -> numpy.ndarray:
        """Returns the tangent A = ∂P/∂F [3 × 3 × 3 × 3], A[i, J, k, L] = ∂P_iJ/∂F_kL, in Pa."""
        raise NotImplementedError(f"the law {self.name} needs a method `tangent`")
