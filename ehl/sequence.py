"""Solution of many similar contacts, each with the most similar solved one as initial guess."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ehl.common.arrays import FloatArray, IntArray
from ehl.common.errors import InputError, MixedEhlError
from ehl.common.pages import TableResult, Tabular
from ehl.common.table import Table
from ehl.common.validation import validate
from ehl.contact import Contact
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.inputs import EACH_RMS, ContactProblem, ModelInput, SurfaceInput
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.result import ContactResult, results_frame
from ehl.solve import solve_contact
from ehl.state import ContactState

if TYPE_CHECKING:
    from pandas import DataFrame

START_DROPPED = "neighbour_too_far"  # fallback of the smooth solver for an unsuitable initial guess
REFUSED = "refused"
MOTION = (
    *("radius_equivalent", "effective_modulus", "pressure_hertz", "speed_entrainment"),
    *("slide_to_roll", "speed_sliding_lengthwise"),
)


@dataclass(frozen=True, eq=False, repr=False)
class PathResult(TableResult, Tabular):
    """Solutions of similar contacts, in the order of the input.

    Parameters
    ----------
    results : tuple of ContactResult
        One per contact; a contact without a solution has the status "failed".
    messages : tuple of str
        Error message of an invalid input (its `reason` is "refused"); empty otherwise.
    order : ndarray of int, shape (n,)
        Order of the solutions.
    origin : ndarray of int, shape (n,)
        Contact that was the initial guess; -1 for a cold start.
    fallbacks : int
        Failed warm starts, followed by a cold start.
    seconds : float
        Wall time [s].

    Examples
    --------
    >>> state = ContactState.of(
    ...     pressure_hertz=[0.8e9, 0.9e9], radius_equivalent=0.015, effective_modulus=226e9, speed_entrainment=5.0)
    >>> solve_path(state, Oil.load("75w90")).status
    ('converged', 'converged')
    """

    results: tuple[ContactResult, ...]
    messages: tuple[str, ...]
    order: IntArray
    origin: IntArray
    fallbacks: int
    seconds: float

    @property
    def status(self) -> tuple[str, ...]:
        """Status of each contact."""
        return tuple(result.status for result in self.results)

    @property
    def warm(self) -> int:
        """Number of contacts solved by a warm start."""
        return int(np.count_nonzero(self.origin >= 0))

    def values(self, name: str) -> FloatArray:
        """A field of `ContactResult` of all contacts, shape (n,); nan for failed contacts."""
        return np.array([getattr(result, name) for result in self.results], dtype=np.float64)

    def to_dict(self) -> dict[str, Any]:
        """Results of all contacts for JSON."""
        return {"results": [result.to_dict() for result in self.results], "messages": list(self.messages)}

    def to_frame(self) -> DataFrame:
        """One row per contact: operating point and results in SI units."""
        return results_frame(self.results)

    def table(self) -> Table:
        """As `to_frame`."""
        return Table.from_columns(self.to_frame().to_dict("list"), title=repr(self))

    def __repr__(self) -> str:
        solved = len(self.results) - self.status.count("failed")
        return f"PathResult({solved} of {len(self.results)} contacts solved, {self.warm} warm, {self.seconds:.3g} s)"


def solve_path(
    contacts: ContactState | Sequence[Contact] | Sequence[LineContact],
    lubricant: Oil | Lubricant | Sequence[Lubricant] | None = None,
    *,
    surface: SurfaceInput | None = None,
    model: ModelInput | None = None,
    bodies: tuple[Material, Material] | None = None,
    warm: bool = True,
) -> PathResult:
    """Solve similar contacts, each with the most similar solved one as initial guess.

    Similarity is the distance in the logarithms of the Hertz pressure and the two Moes groups, on which the smooth film
    depends. The next contact is the one closest to any solved one. If a warm start fails, the contact is solved by a
    cold start. An invalid or failed contact does not affect the others.

    Parameters
    ----------
    contacts : sequence of Contact, ContactState, or sequence of LineContact
        `Contact` objects have all inputs; the other arguments are then not used. A state has its oil temperatures and
        Rq.
    lubricant : Oil, Lubricant or sequence of Lubricant, optional
        For a state or line contacts: an oil at the temperatures of the state, one lubricant for all, or one for each.
    surface : SurfaceInput, optional
        Roughness and boundary friction; the Rq of a state replace those given here. Default: smooth.
    model : ModelInput, optional
        Models and accuracy.
    bodies : tuple of Material, optional
        Both bodies, at the oil temperature; default: steel.
    warm : bool
        False: cold start of every contact.

    Returns
    -------
    PathResult

    Raises
    ------
    InputError
        Numbers of contacts and lubricants differ, or an oil is given without temperatures.

    Examples
    --------
    >>> import ehl
    >>> contact = ehl.Contact(
    ...     viscosity_inlet=0.04, pressure_viscosity="18 1/GPa", pressure_hertz="1 GPa", radius_equivalent="10 mm",
    ...     speed_entrainment="5 m/s", slide_to_roll=0.2, thermal="off", accuracy="fast",
    ... )
    >>> path = ehl.solve_path([contact.replace(speed_entrainment=speed) for speed in (4.0, 5.0)])
    >>> path.status
    ('converged', 'converged')
    """
    clock = time.perf_counter()
    problem_of, count = _problems(
        contacts, lubricant, surface or SurfaceInput(), model or ModelInput(), bodies or (Material.load("steel"),) * 2
    )
    results: list[ContactResult] = [ContactResult("failed", REFUSED)] * count
    messages = [""] * count
    problems: dict[int, ContactProblem] = {}
    for at in range(count):
        try:
            problems[at] = problem_of(at)
        except MixedEhlError as error:
            messages[at] = str(error)

    here = np.array(list(problems), dtype=int)
    # logarithms of the Hertz pressure and of both Moes groups, shape (n, 3)
    groups = [(p.line.pressure_hertz, *p.line.moes_groups(p.lubricant)) for p in problems.values()]
    place = np.log(np.array(groups, dtype=np.float64).reshape(-1, 3))
    distance = np.sum((place - np.median(place, axis=0)) ** 2, axis=1) if here.size else np.zeros(0)
    nearest = np.full(here.size, -1)
    left = np.ones(here.size, dtype=bool)
    order: list[int] = []
    origin = np.full(count, -1)
    dropped = 0
    for _ in range(here.size):
        k = int(np.argmin(np.where(left, distance, np.inf)))
        at = int(here[k])
        left[k] = False
        order.append(at)
        neighbour = int(here[nearest[k]]) if warm and nearest[k] >= 0 else -1
        try:
            result, used = _solve(problems[at], results[neighbour] if neighbour >= 0 else None)
        except MixedEhlError as error:
            messages[at] = str(error)
            continue
        results[at] = result
        if used:
            origin[at] = neighbour
        elif neighbour >= 0:
            dropped += 1
        if result.isothermal is not None:
            apart = np.sum((place - place[k]) ** 2, axis=1)
            closer = (apart < distance) | (nearest < 0)
            distance[closer], nearest[closer] = apart[closer], k
    seconds = time.perf_counter() - clock
    return PathResult(tuple(results), tuple(messages), np.array(order, dtype=int), origin, dropped, seconds)


def _solve(p: ContactProblem, start: ContactResult | None) -> tuple[ContactResult, bool]:
    """Solution, and whether the warm start was successful."""
    result = solve_contact(p, start)
    if start is None:
        return result, False
    if result.isothermal is not None:
        return result, START_DROPPED not in result.isothermal.fallbacks
    return solve_contact(p), False


def _problems(
    contacts: ContactState | Sequence[Contact] | Sequence[LineContact],
    lubricant: Oil | Lubricant | Sequence[Lubricant] | None,
    surface: SurfaceInput,
    model: ModelInput,
    bodies: tuple[Material, Material],
) -> tuple[Callable[[int], ContactProblem], int]:
    """Function that returns the problem of one contact or raises InputError, and the number of contacts."""
    state = contacts if isinstance(contacts, ContactState) else None
    given: tuple[Any, ...] = tuple(_lines(contacts) if isinstance(contacts, ContactState) else contacts)
    if not all(isinstance(contact, (Contact, LineContact)) for contact in given):
        raise InputError("contacts", type(given[0]).__name__, "a sequence of Contact or LineContact, or a ContactState")
    if isinstance(lubricant, Sequence) and len(lubricant) != len(given):
        raise InputError("lubricant", f"{len(lubricant)} lubricants", f"one for each of the {len(given)} contacts")
    if isinstance(lubricant, Oil) and state is None:
        hint = "An Oil requires a ContactState with temperatures."
        raise InputError("lubricant", lubricant.name, "a Lubricant", hint)

    def problem_of(at: int) -> ContactProblem:
        contact, rough = given[at], surface
        if isinstance(contact, Contact):
            return contact.problem()
        if lubricant is None:
            raise InputError("lubricant", None, "an Oil or a Lubricant with a state or line contacts")
        oil: Any = lubricant[at] if isinstance(lubricant, Sequence) else lubricant
        if state is not None and isinstance(oil, Oil):
            oil = oil.at(float(state.temperature_oil.flat[at]))
        if state is not None and not surface.measured:
            rms = {name: float(getattr(state, name).flat[at]) for name in EACH_RMS}
            rough = validate(SurfaceInput, surface.model_dump(exclude_unset=True) | rms)
        return ContactProblem(_checked(contact), oil, rough, model, bodies, (oil.temperature, oil.temperature))

    return problem_of, len(given)


def _lines(state: ContactState) -> Iterator[LineContact]:
    """Line contact of each point."""
    for point in zip(*(getattr(state, name).ravel().tolist() for name in MOTION), strict=True):
        yield LineContact.from_pressure(**dict(zip(MOTION, point, strict=True)))


def _checked(line: LineContact) -> LineContact:
    for name in ("radius_equivalent", "effective_modulus", "load_per_length", "speed_entrainment"):
        value = getattr(line, name)
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(name, value, "> 0")
    if not math.isfinite(line.speed_sliding):
        raise InputError("slide_to_roll", line.slide_to_roll, "finite sliding speeds")
    return line
