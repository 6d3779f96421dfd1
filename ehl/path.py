"""Many neighbouring contacts, each solved from the nearest one that is already solved."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.inputs import ModelInput, SurfaceInput
from ehl.io.errors import InputError, MixedEhlError
from ehl.io.validation import validate
from ehl.line_contact import LineContact
from ehl.material import Material, load_material
from ehl.result import ContactResult
from ehl.solve import solve_contact
from ehl.state import ContactState

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# a name the smooth solver gives to a start it had to drop
START_DROPPED = "neighbour_too_far"
REFUSED = "refused"
MOTION = (
    "radius_equivalent",
    "effective_modulus",
    "pressure_hertz",
    "speed_entrainment",
    "slide_to_roll",
    "speed_sliding_lengthwise",
)

Scene = tuple[LineContact, Lubricant, SurfaceInput]


@dataclass(frozen=True, eq=False)
class PathResult:
    """Solutions along a path, in the order of the input.

    Parameters
    ----------
    results : tuple of ContactResult
        One per contact; a contact that could not be solved has the status "failed".
    messages : tuple of str
        Why an input was refused (its `reason` is then "refused"); empty otherwise.
    order : ndarray of int, shape (n,)
        The order they were solved in.
    origin : ndarray of int, shape (n,)
        The contact each one was started from; -1 for a cold start.
    fallbacks : int
        Warm starts that failed, so that the contact was solved cold.
    seconds : float
        Wall time.
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
        """Contacts solved from a neighbour."""
        return int(np.count_nonzero(self.origin >= 0))

    def values(self, name: str) -> FloatArray:
        """A figure of all contacts by its name in `ContactResult`, nan where a contact failed; shape (n,)."""
        return np.array([getattr(result, name) for result in self.results], dtype=np.float64)


def solve_path(
    contacts: ContactState | Sequence[LineContact],
    lubricant: Oil | Lubricant | Sequence[Lubricant],
    *,
    surface: SurfaceInput | None = None,
    model: ModelInput | None = None,
    bodies: tuple[Material, Material] | None = None,
    warm: bool = True,
) -> PathResult:
    """Solve many contacts, each started from the nearest one solved before it.

    The smooth film depends on the Hertz pressure and the two Moes groups, so nearness is measured in their logarithms;
    the next contact is always the one nearest to any solved one. Where a start does not lead to a solution the
    contact is solved without it. One contact that fails or is refused leaves the others alone.

    Parameters
    ----------
    contacts : ContactState or sequence of LineContact
        A state carries its own oil temperatures and Rq.
    lubricant : Oil, Lubricant or sequence of Lubricant
        An oil card is read at the temperatures of a state; one lubricant holds for all contacts.
    surface : SurfaceInput, optional
        Roughness and boundary friction; the Rq of a state take the place of its own. Smooth when not given.
    model : ModelInput, optional
        Physics and accuracy.
    bodies : tuple of Material, optional
        Steel when not given; each at the oil temperature.
    warm : bool
        False starts every contact cold.

    Returns
    -------
    PathResult

    Raises
    ------
    InputError
        Numbers of contacts and lubricants differ, or an oil card comes without temperatures.
    """
    clock = time.perf_counter()
    count = contacts.size if isinstance(contacts, ContactState) else len(contacts)
    scene_of = _scenes(contacts, lubricant, surface or SurfaceInput(), count)
    physics = model or ModelInput()
    pair = bodies or (load_material("steel"), load_material("steel"))

    results: list[ContactResult] = [ContactResult("failed", REFUSED)] * count
    messages = [""] * count
    scenes: dict[int, Scene] = {}
    for at in range(count):
        try:
            scenes[at] = scene_of(at)
        except MixedEhlError as error:
            messages[at] = str(error)

    here = np.array(list(scenes), dtype=int)
    place = _places([scenes[at] for at in scenes])
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
            result, used = _solve(scenes[at], physics, pair, results[neighbour] if neighbour >= 0 else None)
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


def _solve(
    scene: Scene, model: ModelInput, bodies: tuple[Material, Material], start: ContactResult | None
) -> tuple[ContactResult, bool]:
    """The solution, and whether it came from the start."""
    line, oil, surface = scene
    bulk = (oil.temperature, oil.temperature)
    result = solve_contact(line, oil, surface, model, bodies, bulk, start)
    if start is None:
        return result, False
    film = result.isothermal
    if film is not None:
        return result, START_DROPPED not in film.fallbacks
    return solve_contact(line, oil, surface, model, bodies, bulk, None), False


def _scenes(
    contacts: ContactState | Sequence[LineContact],
    lubricant: Oil | Lubricant | Sequence[Lubricant],
    surface: SurfaceInput,
    count: int,
) -> Callable[[int], Scene]:
    """What makes the scene of one contact; a value out of range is an InputError there."""
    if isinstance(lubricant, Sequence) and len(lubricant) != count:
        raise InputError("lubricant", f"{len(lubricant)} of them", f"one for each of the {count} contacts")
    if isinstance(lubricant, Oil) and not isinstance(contacts, ContactState):
        raise InputError("lubricant", lubricant.name, "a Lubricant", "Only a ContactState carries temperatures.")

    def scene_of(at: int) -> Scene:
        if isinstance(lubricant, Oil):
            assert isinstance(contacts, ContactState)
            oil = lubricant.at(float(contacts.temperature_oil.flat[at]))
        else:
            oil = lubricant if isinstance(lubricant, Lubricant) else lubricant[at]
        if not isinstance(contacts, ContactState):
            return _checked(contacts[at], oil, surface)
        line = LineContact.from_pressure(**{name: float(getattr(contacts, name).flat[at]) for name in MOTION})
        return _checked(line, oil, surface if surface.measured else _with_rms(surface, contacts, at))

    return scene_of


def _checked(line: LineContact, oil: Lubricant, surface: SurfaceInput) -> Scene:
    for name in ("radius_equivalent", "effective_modulus", "load_per_length", "speed_entrainment"):
        value = getattr(line, name)
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(name, value, "> 0")
    if not math.isfinite(line.speed_sliding):
        raise InputError("slide_to_roll", line.slide_to_roll, "finite sliding speeds")
    return line, oil, surface


def _with_rms(surface: SurfaceInput, state: ContactState, at: int) -> SurfaceInput:
    rms = {name: float(getattr(state, name).flat[at]) for name in ("roughness_rms_1", "roughness_rms_2")}
    return validate(SurfaceInput, surface.model_dump(exclude_unset=True) | rms)


def _places(scenes: Sequence[Scene]) -> FloatArray:
    """Where the contacts lie: logarithms of the Hertz pressure and of both Moes groups, shape (n, 3)."""
    groups = [(line.pressure_hertz, *line.moes_groups(oil)) for line, oil, _ in scenes]
    return np.asarray(np.log(np.array(groups, dtype=np.float64).reshape(-1, 3)))
