"""Thermal conductivity of the film under pressure."""

from typing import Annotated, Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel

Array = NDArray[np.float64]
Values = TypeVar("Values", float, Array)
PerPressure = Annotated[float, ValueRange("1/Pa", ge=0.0, le=1e-8)]


class FilmConductivity(InputModel):
    """k/k0 = 1 + c1 p/(1 + c2 p), measured up to 1.1 GPa and extrapolated above; zeros give the ambient value.

    Larsson, R., Larsson, P. O., Eriksson, E., Sjöberg, M. & Höglund, E. (2000), Proc. IMechE J 214; form and constants
    read in public codes that cite the paper, not in the paper itself. Files may name a family of oils instead.

    c1, c2: constants [1/Pa].

    Examples
    --------
    >>> round(PAO(1e9, 0.14) / 0.14, 3)
    2.045
    """

    c1: PerPressure
    c2: PerPressure

    @model_validator(mode="before")
    @classmethod
    def _of_a_family(cls, values: Any) -> Any:
        if not isinstance(values, str):
            return values
        if values not in CONDUCTIVITY_FAMILIES:
            allowed = "one of " + ", ".join(CONDUCTIVITY_FAMILIES) + "; or a table with c1 and c2"
            raise InputError("conductivity_pressure", values, allowed)
        return CONDUCTIVITY_FAMILIES[values].model_dump()

    def __call__(self, pressure: Values, ambient: Any) -> Values:
        """Conductivity [W/(m K)] at pressure [Pa], from its value at ambient pressure."""
        found: Values = ambient * (1.0 + self.c1 * pressure / (1.0 + self.c2 * pressure))
        return found


PAO = FilmConductivity(c1=1.40e-9, c2=0.34e-9)
PARAFFINIC = FilmConductivity(c1=1.72e-9, c2=0.54e-9)
CONDUCTIVITY_FAMILIES = {"pao": PAO, "mineral": PARAFFINIC}
# default by base oil, for oils without their own law; a polyalphaolefin and a paraffinic oil were measured
CONDUCTIVITY_OF_BASE = {"mineral": PARAFFINIC, "hydrocracked": PARAFFINIC, "pao": PAO, "ester": PAO, "polyglycol": PAO}
ASSUMED_CONDUCTIVITY = (
    "the conductivity of the film is assumed to increase with pressure as that of a polyalphaolefin (twofold at 1 GPa);"
    " conductivity_pressure selects another law"
)
