"""Friction of all rows by the contact solver and by a local surrogate.

The result of a row has two parts: friction of the film, and load share of the asperities. A change of the boundary
friction needs no further solution. The surrogate uses the parts at a fixed film shape (`FrozenFilm`) and a correction
that is linear in the logarithms of the parameters.

Rows of a measured table as contacts of the solver, in groups for warm starts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import compress

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import approx_fprime, brentq
from scipy.special import ellipe, ellipk

from ehl.common.arrays import BoolArray, FloatArray
from ehl.common.errors import InputError
from ehl.common.runner import run_tasks
from ehl.fluid.lubricant import Lubricant
from ehl.fluid.oil import Oil
from ehl.inputs import MAX_PRESSURE_OVER_MODULUS, MAX_SLIDING, ContactProblem, ModelInput, SurfaceInput
from ehl.line_contact import LineContact
from ehl.material import Material, effective_modulus
from ehl.result import ContactResult
from ehl.sequence import solve_path
from ehl.solve import solve_contact
from regression.calibration.measurement import CONDITIONS, Measurement
from regression.calibration.setup import SURFACE, CalibrationSetup, card_with, lubricant_of

# mean over maximum pressure: 2/3 of an ellipsoid, pi/4 of a half cylinder
MEAN_POINT, MEAN_LINE = 2.0 / 3.0, math.pi / 4.0
GROUP = 8  # contacts of a group, solved by one worker with warm starts


@dataclass(frozen=True)
class ContactGroup:
    """Neighbouring contacts of one surface."""

    rows: tuple[int, ...]  # rows of the measurement
    contacts: tuple[LineContact, ...]
    temperatures: tuple[float, ...]  # of the oil [K]
    surface: SurfaceInput

    def only(self, wanted: NDArray[np.bool_]) -> ContactGroup:
        """The contacts of selected rows; `wanted` is a mask over all rows of the measurement."""
        kept = wanted[list(self.rows)].tolist()
        temperatures = tuple(compress(self.temperatures, kept))
        return ContactGroup(
            tuple(compress(self.rows, kept)), tuple(compress(self.contacts, kept)), temperatures, self.surface
        )


def line_pressure(measurement: Measurement, setup: CalibrationSetup) -> FloatArray:
    """Hertz pressure of the line contact of each row, shape (n,) [Pa]."""
    modulus = effective_modulus(setup.solid_1.body(), setup.solid_2.body())
    specimens, radius = setup.specimens, measurement.columns["radius_equivalent"]
    load = measurement.columns[measurement.load]
    point = specimens.geometry == "point"
    if measurement.load == "pressure_hertz":
        pressure = load
    elif measurement.load == "load" and point:
        across = specimens.radius_transverse
        pressure = np.array(
            [hertz_point_pressure(w, r, across or r, modulus) for w, r in zip(load, radius, strict=True)]
        )
    elif point:
        hint = "Use the column load [N] or pressure_hertz for a point contact."
        raise InputError("specimens.geometry", "point", "line, for a load per length", hint)
    else:
        if measurement.load == "load":
            if specimens.length is None:
                hint = "It is the length of the contact line, the width of the disc or roller."
                raise InputError("specimens.length", None, "a length such as '10 mm'", hint)
            load = load / specimens.length
        pressure = np.sqrt(load * modulus / (2.0 * np.pi * radius))
    if point and specimens.match == "mean_pressure":
        pressure = pressure * (MEAN_POINT / MEAN_LINE)
    allowed = CONDITIONS["pressure_hertz"]
    most = min(allowed.le or np.inf, MAX_PRESSURE_OVER_MODULUS * modulus)
    least = allowed.ge or 0.0
    for row, value in enumerate(pressure):
        if not least <= value <= most:
            where = f"{measurement.name}, row {measurement.row_numbers[row]}, {measurement.load}"
            span = f"a Hertz pressure of {least:.3g} to {most:.3g} Pa; it is {value:.4g} Pa"
            raise InputError(where, float(load[row]), span, "Check load, radius and solids.")
    return np.asarray(pressure)


def contact_groups(measurement: Measurement, setup: CalibrationSetup) -> tuple[ContactGroup, ...]:
    """The contacts of all rows, grouped by curve and roughness."""
    modulus = effective_modulus(setup.solid_1.body(), setup.solid_2.body())
    pressure = line_pressure(measurement, setup)
    c = measurement.columns
    names = ("radius_equivalent", "speed_entrainment", "slide_to_roll")
    contacts = [
        LineContact.from_pressure(
            effective_modulus=modulus, pressure_hertz=float(pressure[i]), **{name: float(c[name][i]) for name in names}
        )
        for i in range(measurement.size)
    ]
    for row, contact in enumerate(contacts):
        if contact.speed_sliding > MAX_SLIDING:
            where = f"{measurement.name}, row {measurement.row_numbers[row]}, slide_to_roll"
            allowed = f"a sliding speed of at most {MAX_SLIDING:g} m/s; it is {contact.speed_sliding:.4g} m/s"
            raise InputError(where, contact.slide_to_roll, allowed)
    together: dict[tuple[str, float], list[int]] = {}
    for row, label in enumerate(measurement.curve):
        together.setdefault((label, float(c["roughness_rms"][row])), []).append(row)
    groups = []
    for (_, roughness), rows in together.items():
        each = roughness / 2.0**0.5
        surface = setup.surface.model_copy(update={"roughness_rms_1": each, "roughness_rms_2": each})
        pieces = -(-len(rows) // GROUP)
        for part in np.array_split(np.array(rows), pieces):
            temperatures = tuple(float(c["temperature_oil"][i]) for i in part)
            groups.append(ContactGroup(tuple(map(int, part)), tuple(contacts[i] for i in part), temperatures, surface))
    return tuple(groups)


def hertz_point_pressure(load: float, radius_1: float, radius_2: float, effective_modulus: float) -> float:
    """Maximum pressure of an elliptical Hertz contact [Pa] (Johnson 1985, Contact Mechanics, section 4.2).

    1/(2 R') = (p0/E*) b/(e^2 a^2) (K - E), 1/(2 R'') = (p0/E*) b/(e^2 a^2) ((a/b)^2 E - K), W = 2 pi a b p0/3, with
    E* = E'/2, R' the larger radius, a the longer half axis, e^2 = 1 - (b/a)^2, K and E complete elliptic integrals.

    load: W [N].
    radius_1, radius_2: equivalent radii in both directions [m].
    effective_modulus: E' [Pa].
    """
    stiff = 0.5 * effective_modulus
    larger, smaller = max(radius_1, radius_2), min(radius_1, radius_2)
    if larger / smaller < 1.0 + 1e-4:
        mean = math.sqrt(larger * smaller)
        return float((6.0 * load * stiff**2 / (math.pi**3 * mean**2)) ** (1.0 / 3.0))

    def ratio(log_axes: float) -> float:
        axes = math.exp(log_axes)
        m = 1.0 - axes**-2
        return float(math.log((axes**2 * ellipe(m) - ellipk(m)) / (ellipk(m) - ellipe(m))) - math.log(larger / smaller))

    axes = math.exp(brentq(ratio, 1e-5, math.log(larger / smaller) + 1.0, xtol=1e-12))
    m = 1.0 - axes**-2
    short = (3.0 * load * larger * float(ellipk(m) - ellipe(m)) / (math.pi * axes**3 * m * stiff)) ** (1.0 / 3.0)
    return float(1.5 * load / (math.pi * axes * short**2))


Values = Mapping[str, float]

# lower bounds for the transformed parts, ln(s/(1 - s)) of shares and ln mu of friction
MIN_SHARE, MIN_FRICTION = 1e-5, 1e-9
UNSOLVED = "boundary_friction"  # the parameter whose change needs no new solution
PARTS = 3  # film friction; asperity share; relative error of the friction


@dataclass(frozen=True, eq=False)
class FrozenFilm:
    """A solved film for the change of its friction with oil properties without another solution.

    Pressure, temperature and shape of the film are those of the solution. Its thickness follows the formula of Moes
    (1992), its shear stress the shear law with the new properties.
    """

    pressure: FloatArray  # [Pa]; shape (m,)
    log_shear_rate: FloatArray  # ln of v_s/h times the change of viscosity with temperature [1/s]; shape (m,)
    # length of each node over the load per length [m^2/N]: friction is the sum of weight times stress; shape (m,)
    weight: FloatArray
    log_film: float  # ln of the film of the solution by the formula of Moes

    def log_friction(self, contact: LineContact, lubricant: Lubricant) -> float:
        """ln of the friction coefficient with another lubricant."""
        film = math.log(contact.film_moes(lubricant))
        log_viscosity = math.log(lubricant.viscosity_inlet) + lubricant.log_viscosity_ratio(self.pressure)
        law = lubricant.shear_law
        stress = np.exp(law.log_stress(log_viscosity + self.log_shear_rate - (film - self.log_film), self.pressure)[0])
        friction = float(self.weight @ np.minimum(stress, law.limiting_stress(self.pressure)))
        return math.log(max(friction, 1e-300))


def frozen_film(result: ContactResult, contact: LineContact, lubricant: Lubricant) -> FrozenFilm | None:
    """The film of a smooth, steady solution with sliding, else None."""
    if result.status == "failed" or result.transient is not None or result.film is None or contact.speed_sliding == 0.0:
        return None
    film = result.film
    x, pressure = film.x, np.maximum(film.pressure, 0.0)
    inside = pressure > 1e-3 * pressure.max()
    hotter = np.zeros_like(x) if result.heat is None else np.interp(x, result.heat.x, result.heat.log_viscosity_offset)
    rest = np.log(contact.speed_sliding / film.film) + hotter
    weight = np.gradient(x) / contact.load_per_length
    return FrozenFilm(pressure[inside], rest[inside], weight[inside], math.log(contact.film_moes(lubricant)))


def _parts(result: ContactResult) -> tuple[float, float, float]:
    if result.status == "failed":
        return np.nan, np.nan, np.nan
    return result.friction_fluid, result.asperity_load_share, result.friction_error


def solve_group(
    group: ContactGroup,
    sets: Sequence[tuple[Sequence[Lubricant], Mapping[str, float]]],
    model: ModelInput,
    bodies: tuple[Material, Material],
    windows: Sequence[float | None] = (),
) -> tuple[FloatArray, tuple[FrozenFilm | None, ...], tuple[float | None, ...]]:
    """Parts of the friction of one group for several sets of parameters, and films and windows of the first set.

    Contacts of the first set are solved with warm starts from each other, those of the other sets from the same contact
    of the first. The parts have the shape (sets, contacts, 3), nan for failed solutions.

    The averaging window of a rough contact is the same for all sets. A window that ends with the interval of mu differs
    between sets, which changes mu by some per cent: more than the small changes in a search.

    sets: one lubricant per contact of the group, and changes of the surface.
    model, bodies: as in `ehl.inputs.ContactProblem`.
    windows: averaging window of each contact [b], None if unknown; empty if all are.
    """
    out = np.full((len(sets), len(group.contacts), PARTS), np.nan)
    first: list[ContactResult] = []
    for k, (lubricants, changes) in enumerate(sets):
        surface = group.surface.model_copy(update=dict(changes))
        if k == 0 and not windows:
            first = list(solve_path(group.contacts, lubricants, surface=surface, model=model, bodies=bodies).results)
            out[0] = [_parts(result) for result in first]
            windows = [_window(result) for result in first]
            continue
        for i, (contact, oil) in enumerate(zip(group.contacts, lubricants, strict=True)):
            problem = ContactProblem(contact, oil, surface, model, bodies, (oil.temperature, oil.temperature))
            near = first[i] if k else first[-1] if first else None
            start = near if near is not None and near.isothermal is not None else None
            result = solve_contact(problem, start, window=windows[i])
            if result.status == "failed" and start is not None:
                result = solve_contact(problem, window=windows[i])
            out[k, i] = _parts(result)
            if k == 0:
                first.append(result)
    films = [frozen_film(*entry) for entry in zip(first, group.contacts, sets[0][0], strict=True)]
    return out, tuple(films), tuple(known or _window(result) for known, result in zip(windows, first, strict=True))


def _window(result: ContactResult) -> float | None:
    return None if result.transient is None else result.transient.travel


@dataclass
class FrictionSolver:
    """The solver for all rows, with a cache of its results."""

    setup: CalibrationSetup
    groups: tuple[ContactGroup, ...]
    roughness: FloatArray  # composite Rq of each row [m]; shape (n,)
    temperature: float  # reference temperature of `pressure_viscosity` [K]
    jobs: int | None = None  # worker processes
    calls: int = 0  # contacts solved so far
    _known: dict[tuple[float, ...], FloatArray] = field(default_factory=dict, repr=False)
    films: dict[int, FrozenFilm] = field(default_factory=dict, repr=False)  # last solved film of each row
    windows: dict[int, float] = field(default_factory=dict, repr=False)  # averaging window of each rough row [b]

    def parts(self, sets: Sequence[Values], rows: BoolArray | None = None) -> FloatArray:
        """Parts of the friction for each set of values, shape (sets, n, 3); nan if failed or not requested.

        sets: values of all parameters in SI units; warm starts are from the solutions of the first set.
        rows: rows to be solved; default: all.
        """
        wanted = np.ones(self.roughness.size, dtype=bool) if rows is None else rows
        keys = [tuple(values[name] for name in sorted(values)) for values in sets]
        fresh: dict[tuple[float, ...], Values] = {}
        for key, values in zip(keys, sets, strict=True):
            known = self._known.setdefault(key, np.full((self.roughness.size, PARTS + 1), np.nan))
            if np.isnan(known[wanted, PARTS]).any():
                fresh[key] = values
        if fresh:
            self._solve(list(fresh.values()), list(fresh), wanted)
        return np.array([self._known[key][:, :PARTS] for key in keys])

    def _solve(self, sets: Sequence[Values], keys: Sequence[tuple[float, ...]], wanted: BoolArray) -> None:
        bodies = (self.setup.solid_1.body(), self.setup.solid_2.body())
        cards = [card_with(Oil.load(self.setup.oil), values, self.temperature) for values in sets]
        groups = [part for part in (group.only(wanted) for group in self.groups) if part.rows]
        tasks = []
        for group in groups:
            lubricants = [
                [lubricant_of(card, t, rising=self.setup.rising) for t in group.temperatures] for card in cards
            ]
            surfaces = [{name: values[name] for name in SURFACE if name in values} for values in sets]
            inputs = list(zip(lubricants, surfaces, strict=True))
            windows = tuple(self.windows.get(row) for row in group.rows) if self.windows else ()
            tasks.append((group, inputs, self.setup.model, bodies, windows))
        found = list(run_tasks(tasks, lambda task: solve_group(*task), jobs=self.jobs))
        for group, (parts, films, windows) in zip(groups, found, strict=True):
            new = {row: window for row, window in zip(group.rows, windows, strict=True) if window is not None}
            self.windows = new | self.windows
            self.calls += len(group.rows) * len(sets)
            # the surrogate uses the films for changes of friction only, so that those of the last first set suffice
            self.films = self.films | {row: film for row, film in zip(group.rows, films, strict=True) if film}
            for key, of_set in zip(keys, parts, strict=True):
                self._known[key][list(group.rows)] = np.column_stack([of_set, np.ones(len(group.rows))])

    def held(self, values: Values, films: Mapping[int, FrozenFilm]) -> FloatArray:
        """Transformed parts at fixed films, shape (n, 2), up to a constant for each row; 0 without films."""
        out = np.zeros((self.roughness.size, 2))
        if not films:
            return out
        card = card_with(Oil.load(self.setup.oil), values, self.temperature)
        oils: dict[float, Lubricant] = {}
        for group in self.groups:
            for row, contact, temperature in zip(group.rows, group.contacts, group.temperatures, strict=True):
                if row in films:
                    if temperature not in oils:
                        oils[temperature] = lubricant_of(card, temperature, rising=self.setup.rising)
                    out[row, 0] = films[row].log_friction(contact, oils[temperature])
        return out

    def transformed(self, parts: FloatArray) -> FloatArray:
        """The first two parts, shape (..., n, 2), transformed for the surrogate."""
        friction = np.log(np.maximum(parts[..., 0], MIN_FRICTION))
        share = np.clip(parts[..., 1], MIN_SHARE, 1.0 - MIN_SHARE)
        return np.stack([friction, np.log(share / (1.0 - share))], axis=-1)

    def friction(self, transformed: FloatArray, values: Values) -> FloatArray:
        """mu of all rows, shape (n,), from the transformed parts and the boundary friction."""
        film = np.exp(transformed[..., 0])
        share = 1.0 / (1.0 + np.exp(-transformed[..., 1]))
        # film friction of a rough contact refers to the whole load
        return np.asarray(np.where(self.roughness > 0.0, film + share * values["boundary_friction"], film))


@dataclass(frozen=True, eq=False)
class Surrogate:
    """Friction near a set of values: fixed films, and a correction that is linear in logarithms."""

    solver: FrictionSolver
    values: dict[str, float]  # values of all parameters at the centre
    names: tuple[str, ...]  # fitted parameters
    centre: FloatArray  # transformed parts at the centre; shape (n, 2)
    # derivatives of the parts by the logarithm of each fitted parameter minus those at fixed films; shape (n, 2, k)
    slopes: FloatArray
    films: Mapping[int, FrozenFilm]  # fixed films
    held: FloatArray  # parts with fixed films at `values`; shape (n, 2)

    @property
    def moving(self) -> bool:
        """Whether any fitted parameter requires solutions."""
        return any(name != UNSOLVED for name in self.names)

    @property
    def log_values(self) -> FloatArray:
        """Logarithms of the fitted values at the centre, shape (k,)."""
        return np.log([self.values[name] for name in self.names])

    def values_at(self, log_values: FloatArray) -> dict[str, float]:
        """Values of all parameters with other logarithms of the fitted ones."""
        return {**self.values, **dict(zip(self.names, map(float, np.exp(log_values)), strict=True))}

    def at(self, log_values: FloatArray) -> FloatArray:
        """mu of all rows, shape (n,)."""
        step = log_values - self.log_values
        values = self.values_at(log_values)
        change = self.solver.held(values, self.films) - self.held if self.moving else 0.0
        return self.solver.friction(self.centre + change + self.slopes @ step, values)

    def jacobian(self, log_values: FloatArray) -> FloatArray:
        """d mu/d ln(value), shape (n, k), by differences of the surrogate."""
        return np.asarray(approx_fprime(log_values, self.at, 1e-5))

    def moved(self, values: dict[str, float], centre: FloatArray) -> Surrogate:
        """The surrogate about another solved point, with slopes corrected along the step (Broyden 1965)."""
        place = np.log([values[name] for name in self.names])
        step = place - self.log_values
        # parameters that require no solution do not change the parts
        step = np.where([name != UNSOLVED for name in self.names], step, 0.0)
        length = float(step @ step)
        slopes = self.slopes
        if length > 0.0:
            change = self.solver.held(values, self.films) - self.held
            wrong = np.nan_to_num(centre - self.centre - change - self.slopes @ step)
            slopes = slopes + wrong[..., None] * step / length
        films = self.solver.films
        return Surrogate(self.solver, values, self.names, centre, slopes, films, self.solver.held(values, films))
