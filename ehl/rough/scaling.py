"""Dimensionless constants and initial state of a transient run, from the contact in SI units."""

import math
from dataclasses import dataclass, field

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError
from ehl.elastic_shear import body_compliance, counted, elastic_share, isothermal_stress
from ehl.fluid.lookup import law_table
from ehl.fluid.lubricant import Lubricant
from ehl.line_contact import LineContact
from ehl.material import Material
from ehl.rough._kernels.fluid import density_rows
from ehl.rough._kernels.motion import SAMPLES
from ehl.rough._kernels.quasi_separable import MODES, exponential_product
from ehl.rough._kernels.records import Elastic, Fluid, Heat, Model, SideFlow, Solids, Strain, Surfaces
from ehl.rough.exponential_sums import ExponentialSum, bessel_kernel, fit_root_kernel, log_kernel, range_of
from ehl.rough.surfaces import RoughSurfaces, sample_ring

OUTLET = 1.2  # end of the fluid pressure [b]; beyond it a spurious solution with fluid pressure at the edge exists
FARTHEST = 8.0  # largest distance of asperity contact from the middle [b]
MIDDLE = 0.8  # half length of the mean film [b]
ROUGHNESS_FRONT = (-1.3, 0.3)  # start of the roughness and width of the ramp [b]
DRAINED_GAP = 10.0  # gap over composite Rq above which local and mean pressure agree
EXCHANGE_WINDOW = 0.1  # travel per update of the macroscopic pressure [b]
# updates of P after which its gain decreases as 1/n; with the short windows of fine roughness the means scatter little
# but P changes over tens of b
SETTLED, SETTLED_FINE = 240.0, 1200.0
# film ratios up to and from which the step of the macroscopic pressure by the mean film has weights 0 and 1: its net
# exchange is smaller above 2 and larger below 1.5 (108 contacts of the shipped data)
THICK = (1.75, 2.5)
# averaging width of the outflow of a contact spot over the correlation length; without averaging the positive part of
# the outflow grows with mesh refinement
SPOT = 1.0
# exponent of gamma below 1 in `flattening_wave_number` (this work): from two two-dimensional solutions at gamma .5; two
# at .7 and .5 were compared (docs/roughness.md)
MARKS_ALONG = 0.7
ELASTIC_MODES = 10
HEAT_MODES = 10
NO_LIMIT = 1e9  # limiting shear stress over pressure without a limit
HEAT_RANGE = 16  # passages over which the thermal kernel is fitted


@dataclass(frozen=True)
class Settings:
    """Numerical choices of one run."""

    nodes: int  # approximate number of nodes over the solved length
    boundary_film: float  # h_boundary [m]
    boundary_friction: float  # mu_b [-]
    peklenik_number: float  # gamma; infinity is sealed
    thermal: bool  # thermal effects on
    hardness: float  # limit of the total pressure [Pa]
    # of mass and gap in one step, over the film unit; the residual enters the next step (`settle_mass`) and does not
    # accumulate
    tolerance: float = 1e-4
    start_travel: float = 0.0  # travel of the surfaces at the start of the run [b]
    # bulk temperatures of both bodies with thermal effects [K]; default: the inlet temperature
    temperature_bulk: tuple[float, float] | None = None
    # x [m] and the heat of the pressure-driven flow there [W/m2]; default: none
    film_heat: tuple[FloatArray, ...] | None = field(default=None, repr=False, compare=False)
    exchange_window: float = EXCHANGE_WINDOW  # travel per update of the macroscopic pressure [b]


@dataclass(frozen=True)
class Units:
    """Scales of a run, SI."""

    half_width: float
    pressure: float
    film: float
    spacing: float
    time_step: float

    @property
    def steps_per_half_width(self) -> float:
        """Time steps per b of travel."""
        return self.half_width / self.spacing


@dataclass(frozen=True)
class RunProblem:
    """Constants and mesh of a run."""

    units: Units
    settings: Settings
    model: Model
    x: FloatArray
    film_estimate: float
    deflection: float  # film units per unit of the integrated log kernel and p_h


def solved_length(contact: LineContact, film: float) -> tuple[float, float]:
    """Inlet and outlet [b]: the inlet is fully flooded, the outlet lies beyond film rupture.

    The length of a rigid cylinder, sqrt(2 R h), determines them for films that are thick against the deformation.
    """
    rigid = math.sqrt(2.0 * contact.radius_equivalent * film) / contact.half_width
    return -max(2.5, 1.0 + 4.0 * rigid), max(OUTLET, rigid + 0.2)


def hertz_gap(contact: LineContact, reach: FloatArray) -> FloatArray:
    """Gap of a smooth dry contact [m] at a distance above 1 b from the middle [b]."""
    root = np.sqrt(reach**2 - 1.0)
    scale = contact.half_width**2 / (2.0 * contact.radius_equivalent)
    return np.asarray(scale * (reach * root - np.log(reach + root)))


def rough_length(contact: LineContact, film: float, rms: float) -> tuple[float, float]:
    """Inlet and outlet of the mesh [b]: `solved_length`, extended at the same spacing over the asperity contact.

    Asperities touch where film and Hertz gap together are less than three Rq (up to `FARTHEST`).
    """
    inlet, outlet = solved_length(contact, film)
    reach = np.linspace(1.0, FARTHEST, 701)
    touching = float(np.interp(3.0 * rms - film, hertz_gap(contact, reach), reach))
    return min(inlet, -touching - 0.5), max(outlet, touching)


def inlet_wedge(contact: LineContact, viscosity: float, film: float, inlet: float) -> tuple[float, float, float]:
    """Pressure [Pa], load and shear force [N/m] of the flooded wedge upstream of the mesh.

    Integral of 12 eta u_r (h - h_c)/h^3 from far upstream with the film h_c and the gap of a dry Hertz contact. The
    boundary condition p = 0 would give a film that is 1 % thinner at -2.7 b and 0.2 % at -4.5 b.
    """
    b = contact.half_width
    reach = np.geomspace(-inlet, -100.0 * inlet, 2001)
    gap = hertz_gap(contact, reach)
    slope = 12.0 * viscosity * contact.speed_entrainment * b * gap / (film + gap) ** 3
    shear = viscosity * contact.speed_sliding * b * np.trapezoid(1.0 / (film + gap), reach)
    # load = int p dx = int slope (reach - start) dx, by parts
    load = b * np.trapezoid(slope * (reach - reach[0]), reach)
    return float(np.trapezoid(slope, reach)), float(load), float(shear)


def drained_from(contact: LineContact, film: float, rms: float, x: FloatArray) -> int:
    """First node whose smooth gap is below 10 Rq; at least 2."""
    wide = x < -1.0
    gap = hertz_gap(contact, np.where(wide, -x, 1.0))
    return max(2, int(np.argmax(~wide | (film + gap < DRAINED_GAP * rms))))


def scaled_fluid(contact: LineContact, lubricant: Lubricant, units: Units, wave_number: float, heated: bool) -> Fluid:
    """Lubricant laws for pressures in p_h and films in the film unit; `heated`: with the film temperature.

    ``wave_number`` [1/m] is that of the lateral mode (`flattening_wave_number`); 0 for sealed valleys.
    """
    p = units.pressure
    shear = lubricant.shear_law
    stress = shear.reference(p)
    flow = units.time_step * p * units.film**2 / (12.0 * lubricant.viscosity_inlet)
    return Fluid(
        table=law_table(lubricant, p, heated),
        heated=heated,
        eyring=lubricant.rheology == "eyring",
        sliding=lubricant.viscosity_inlet * contact.speed_sliding / (stress * units.film),
        along=contact.sliding_cosine**2,
        flux=flow / units.spacing**2,
        flux_lateral=flow * wave_number**2,
        stress=stress / p,
        limit=NO_LIMIT if shear.limit_in_flow else min(shear.limit_slope, NO_LIMIT),
        temperature=lubricant.temperature,
        shear=shear.numbers(p, stress, units.film / units.half_width),
        short=not shear.limit_in_flow and shear.rheology in ("newtonian", "eyring"),
        limit_ambient=0.0 if shear.limit_in_flow else shear.limit_ambient / p,
    )


def scaled_strain(contact: LineContact, lubricant: Lubricant, units: Units, film: float) -> Strain:
    """Elastic part of the film shear, zero if its estimate is negligible."""
    share = counted(elastic_share(contact, lubricant, film, isothermal_stress(contact, lubricant, film)))
    if share == 0.0:
        return Strain(0.0, 0.0, 1.0)
    stress_per_way = units.pressure / (contact.speed_sliding * units.time_step)
    return Strain(
        share, units.film / lubricant.shear_modulus * stress_per_way, body_compliance(contact) * stress_per_way
    )


def scaled_heat(
    contact: LineContact,
    lubricant: Lubricant,
    materials: tuple[Material, Material],
    units: Units,
    settings: Settings,
    x: FloatArray,
) -> Heat:
    """Thermal kernels of both surfaces for this time step, and heat in the smooth film on the nodes."""
    bulk = bulk_temperatures(settings, lubricant)
    kernel = fit_root_kernel(HEAT_RANGE * range_of(x.size), HEAT_MODES)
    root = math.sqrt(units.time_step / math.pi)
    at, *heats, kept = settings.film_heat or (*np.zeros((3, 1)), np.ones(1))
    nodes = x * units.half_width
    rolling, convected = (np.interp(nodes, at, heat, left=0.0, right=0.0) for heat in heats)
    weights = np.array([kernel.weights * root / m.thermal_effusivity for m in materials])
    return Heat(
        on=settings.thermal,
        speed=contact.speed_sliding,
        pressure_unit=units.pressure,
        film_unit=units.film,
        conductivity=lubricant.thermal_conductivity,
        conductivity_rise=lubricant.film_conductivity.c1 * units.pressure,
        conductivity_bend=lubricant.film_conductivity.c2 * units.pressure,
        weights=weights,
        ratios=kernel.ratios.copy(),
        nodes_per_step_1=contact.speed_1 / contact.speed_entrainment,
        nodes_per_step_2=contact.speed_2 / contact.speed_entrainment,
        bulk_1=bulk[0] - lubricant.temperature,
        bulk_2=bulk[1] - lubricant.temperature,
        rolling=rolling,
        convected=convected,
        kept=np.interp(nodes, at, kept, left=1.0, right=1.0),
    )


def bulk_temperatures(settings: Settings, lubricant: Lubricant) -> tuple[float, float]:
    """Bulk temperatures of both bodies [K]; the inlet temperature without thermal effects."""
    inlet = lubricant.temperature
    return (inlet, inlet) if settings.temperature_bulk is None or not settings.thermal else settings.temperature_bulk


def build_problem(
    contact: LineContact,
    lubricant: Lubricant,
    surfaces: RoughSurfaces,
    materials: tuple[Material, Material],
    settings: Settings,
) -> RunProblem:
    """Scaled constants on a mesh whose spacing divides the period of the roughness."""
    b = contact.half_width
    p_h = contact.pressure_hertz
    estimate = contact.film_moes(lubricant)
    inlet, outlet = solved_length(contact, estimate)
    spacing = (outlet - inlet) * b / settings.nodes
    if surfaces.profiles:
        period = surfaces.profiles[0].length
        spacing = period / math.ceil(period / spacing)
    film_unit = max(estimate, surfaces.rms, settings.boundary_film)
    units = Units(b, p_h, film_unit, spacing, spacing / contact.speed_entrainment)
    inlet, outlet = rough_length(contact, estimate, surfaces.rms)
    dx = spacing / b
    last = math.ceil(outlet / dx) + 2
    first = -math.ceil(-inlet / dx)
    x = np.asarray(dx * (np.arange(first, last) + 0.5), dtype=float)
    n = x.size

    # the oil upstream of the mesh has the mean temperature of the bodies
    warm = np.array([sum(bulk_temperatures(settings, lubricant)) / 2.0])
    viscosity = math.exp(float(lubricant.log_viscosity(np.zeros(1), warm)[0]))
    wedge_pressure, wedge_load, wedge_shear = inlet_wedge(contact, viscosity, estimate, float(x[0]))
    gamma = settings.peklenik_number
    sealed = not math.isfinite(gamma) or not surfaces.profiles
    wave_number = 0.0 if sealed else flattening_wave_number(surfaces.correlation_length, gamma)
    deflection = 4.0 * p_h * spacing / (math.pi * contact.effective_modulus * film_unit)
    size = range_of(n)
    line = (log_kernel(size, ELASTIC_MODES), log_kernel(size, MODES))
    lateral = line
    if not sealed:
        lateral = bessel_kernel(wave_number * spacing, ELASTIC_MODES, MODES)
    model = Model(
        fluid=scaled_fluid(contact, lubricant, units, wave_number, settings.thermal),
        contact=Solids(
            boundary=settings.boundary_film / film_unit,
            cap=settings.hardness / p_h,
            load=(contact.load_per_length - wedge_load) / (p_h * spacing),
            full_load=contact.load_per_length / (p_h * spacing),
            wedge_shear=wedge_shear / (p_h * spacing),
            inlet_pressure=wedge_pressure / p_h,
            friction=settings.boundary_friction,
            outlet=int(np.searchsorted(x, outlet)),
            middle_first=int(np.searchsorted(x, -MIDDLE)),
            middle_last=int(np.searchsorted(x, MIDDLE)),
            tolerance=settings.tolerance,
        ),
        elastic=scaled_elastic(*lateral, deflection),
        elastic_mean=scaled_elastic(*line, deflection),
        surfaces=Surfaces(
            parabola=(x * b) ** 2 / (2.0 * contact.radius_equivalent * film_unit),
            x=x,
            profile_1=sample_ring(surfaces.profile_1, spacing / SAMPLES) / film_unit,
            profile_2=sample_ring(surfaces.profile_2, spacing / SAMPLES) / film_unit,
            shift_1=SAMPLES * contact.speed_1 / contact.speed_entrainment,
            shift_2=SAMPLES * contact.speed_2 / contact.speed_entrainment,
            front=ROUGHNESS_FRONT[0],
            front_width=ROUGHNESS_FRONT[1],
            spacing=dx,
        ),
        heat=scaled_heat(contact, lubricant, materials, units, settings, x),
        side_flow=SideFlow(
            on=not sealed,
            first=drained_from(contact, estimate, surfaces.rms, x),
            window=max(1, round(settings.exchange_window / dx)),
            relaxation=0.2,
            settled=SETTLED if settings.exchange_window >= EXCHANGE_WINDOW else SETTLED_FINE,
            storage=4.0 * p_h * b / (math.pi * contact.effective_modulus * film_unit),
            thick=min(max((estimate / surfaces.rms - THICK[0]) / (THICK[1] - THICK[0]), 0.0), 1.0)
            if surfaces.rms
            else 0.0,
            spot=SPOT * surfaces.correlation_length / spacing,
            isotropic=0.0 if sealed else 1.0 / (gamma * wave_number * spacing) ** 2,
        ),
        strain=scaled_strain(contact, lubricant, units, estimate),
    )
    return RunProblem(units, settings, model, x, estimate, deflection)


def scaled_elastic(full: ExponentialSum, short: ExponentialSum, deflection: float) -> Elastic:
    """Elastic kernels of the film and of the Newton matrix, film units per p_h."""
    return Elastic(full.weights * deflection, full.ratios.copy(), short.weights * deflection, short.ratios.copy())


def flattening_wave_number(correlation_length: float, gamma: float) -> float:
    """Lateral wave number k_e of the pressure that flattens two-dimensional roughness [1/m] (own work).

    k_e^2 = <k_y^2 k^2>/<k^2> of the Gaussian spectrum of the lengths lc and gamma lc: 2/(gamma lc)^2 times
    (1 + 3/gamma^2)/(1 + 1/gamma^2). Marks along the motion (gamma below 1) act as if they were longer waves: k_e times
    gamma^`MARKS_ALONG`, after two-dimensional solutions.
    """
    k = math.sqrt(2.0 * (1.0 + 3.0 / gamma**2) / (1.0 + 1.0 / gamma**2)) / (gamma * correlation_length)
    return float(k * min(gamma, 1.0) ** MARKS_ALONG)


def density_ratio(pressure: FloatArray, fluid: Fluid) -> FloatArray:
    """rho/rho0 at pressures in the solver's unit."""
    density, slope = np.zeros((2, pressure.size))
    density_rows(np.ascontiguousarray(pressure), fluid.table, density, slope)
    return density


def hertz_start(problem: RunProblem) -> tuple[FloatArray, FloatArray, float]:
    """Initial state: Hertz pressure, the mass of a film of the estimated thickness, and the approach of the bodies."""
    x, model = problem.x, problem.model
    if not np.any(np.abs(x) < 0.7):
        raise ConvergenceError("film_above_radius", "the film is too thick for a mesh with inlet and contact")
    pressure = np.sqrt(np.maximum(1.0 - x * x, 0.0))
    pressure *= model.contact.load / pressure.sum()
    response = np.zeros(x.size)
    exponential_product(pressure, model.elastic_mean.weights, model.elastic_mean.ratios, response)
    rigid = model.surfaces.parabola + response
    film = problem.film_estimate / problem.units.film
    level = film - float(rigid[np.abs(x) < 0.7].mean())
    mass = density_ratio(pressure, model.fluid) * np.maximum(level + rigid, 0.9 * film)
    mass = np.where(x > 0.0, np.minimum(mass, 1.3 * film), mass)
    return pressure, mass, level
