"""What the kernels pass around: constants of a run, and groups of node arrays.

All tuples are plain NamedTuples: compiled code reads them by name and they cost nothing at run time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ehl.fluid.lookup import LawTable
from ehl.fluid.rheology import PLAIN, ShearNumbers


class Fluid(NamedTuple):
    """The lubricant in scaled variables (pressure in p_h, film in the film unit)."""

    table: LawTable  # viscosity and density
    heated: bool  # whether the viscosity follows the film temperature
    eyring: bool
    sliding: float  # eta0 u_s/(reference stress h_unit)
    along: float  # cos^2 of the angle between sliding and x
    flux: float  # dt p_h h_unit^2/(12 eta0 dx^2)
    flux_lateral: float  # dt p_h h_unit^2 k_e^2/(12 eta0); 0 = sealed
    stress: float  # reference stress/p_h: that of tau0, or 1 for a Newtonian oil
    limit: float  # Lambda of tau <= tau_L0 + Lambda p, in the traction alone
    temperature: float  # inlet [K]
    shear: ShearNumbers = PLAIN  # the shear law
    short: bool = True  # whether the vectorised forms of Newton and Ree-Eyring serve
    limit_ambient: float = 0.0  # tau_L0/p_h


class Solids(NamedTuple):
    """Solids, load and mesh limits."""

    boundary: float  # h_boundary in film units
    cap: float  # hardness/p_h
    load: float  # sum of the nodal pressures
    full_load: float  # the same with what the wedge ahead of the mesh carries
    wedge_shear: float  # shear force on that wedge, in nodal pressures
    inlet_pressure: float  # at the first node, from the wedge ahead of it
    friction: float  # boundary friction coefficient
    outlet: int  # first node at which the fluid pressure is zero by rule
    middle_first: int  # nodes of the mean film
    middle_last: int
    tolerance: float  # of mass and gap, film units


class Elastic(NamedTuple):
    """Sums of exponentials of an elastic kernel, in film units per p_h."""

    weights: np.ndarray
    ratios: np.ndarray
    weights_newton: np.ndarray  # the shorter sum of the Newton matrix, same constant
    ratios_newton: np.ndarray


class Surfaces(NamedTuple):
    """Rough profiles sampled twice per node spacing, and their motion."""

    parabola: np.ndarray  # rigid smooth gap at the nodes, film units
    x: np.ndarray  # nodes, half-widths
    profile_1: np.ndarray  # heights, film units
    profile_2: np.ndarray
    shift_1: float  # samples per time step
    shift_2: float
    front: float  # where the roughness starts at time zero, half-widths
    front_width: float
    spacing: float  # of the nodes, half-widths


class Heat(NamedTuple):
    """Conduction into the surfaces and across the film, SI."""

    on: bool
    speed: float  # sliding speed [m/s]
    pressure_unit: float  # [Pa]
    film_unit: float  # [m]
    conductivity: float  # of the film at ambient pressure [W/(m K)]
    conductivity_rise: float  # k/k0 = 1 + rise p/(1 + bend p), per p_h
    conductivity_bend: float
    weights: np.ndarray  # (2, modes) of the inverse-root kernel, K m2/W
    ratios: np.ndarray  # (modes,)
    nodes_per_step_1: float
    nodes_per_step_2: float
    bulk_1: float  # bulk temperatures above the inlet's [K]
    bulk_2: float
    rolling: np.ndarray  # heat of the pressure-driven flow of the smooth film [W/m2]
    # of the smooth film (`ehl.rough.mixed.film_heat_of`): heat convected to a node [W/m2], and share of the heat of the
    # shear that is kept there [-]
    convected: np.ndarray
    kept: np.ndarray


class SideFlow(NamedTuple):
    """Side flow, and the update rules of the macroscopic pressure and of the mean total pressure."""

    on: bool
    first: int  # first node that exchanges: ahead of it the gap is many times the roughness
    window: int  # steps averaged for one update
    relaxation: float
    settled: float  # windows after which the gain of P falls as 1/n
    storage: float  # compliance of the diagonal
    thick: float  # weight of the step by the mean film (`mean_film_step`)
    spot: float  # width over which that outflow is averaged [nodes]
    isotropic: float  # 1/(gamma k_e dx)^2: lateral outflow of a spot as that along x over gamma^2


class Strain(NamedTuple):
    """Elastic part of the film shear (`ehl.elastic_shear`)."""

    counted: float  # how much of it counts; 0 = left out
    film: float  # way of a time step: stress gained 1/(film h + bodies), in p_h
    bodies: float


class Model(NamedTuple):
    """Everything that stays constant during a run."""

    fluid: Fluid
    contact: Solids
    elastic: Elastic  # of the pressure less its time mean
    elastic_mean: Elastic  # of the time mean: the line kernel
    surfaces: Surfaces
    heat: Heat
    side_flow: SideFlow
    strain: Strain


class State(NamedTuple):
    """What one time step hands to the next."""

    fluid_pressure: np.ndarray
    contact_pressure: np.ndarray
    fluid_pressure_old: np.ndarray
    contact_pressure_old: np.ndarray
    mean_pressure: np.ndarray  # slow average, static part of the predictor
    predicted: np.ndarray  # fluid pressure by the first prediction, and the change of it to the second
    change: np.ndarray
    film: np.ndarray
    mass: np.ndarray  # rho h, or the carried mass where the gap is not full
    mass_old: np.ndarray
    temperature: np.ndarray  # at which the film has its effective viscosity [K]
    rise_share: np.ndarray  # of its rise above the surfaces in that of mid-film under even heat
    along_share: np.ndarray  # `ehl.heat.traction.flow_shares`
    across_share: np.ndarray
    surface_temperature: np.ndarray  # (2, n) rise [K]
    flux_into: np.ndarray  # (2, n) heat flux into the surfaces [W/m2]
    memory: np.ndarray  # (2, modes, n + 3) thermal memory on surface-fixed grids
    memory_base: np.ndarray  # (2,) ring-buffer start
    memory_offset: np.ndarray  # (2,) grid position between nodes
    entering: np.ndarray  # (2, n + 3) flux of the last step by slot of the memory
    shear: np.ndarray  # film shear stress of the viscous law, p_h
    strained: np.ndarray  # the same with its elastic part
    outflow: np.ndarray  # factor on the side flow out of spots under high pressure
    scalars: np.ndarray  # see the indices below


CAPPED = 4  # node kind in addition to FLUID and CONTACT: total pressure at the hardness, mass carried
# entries of State.scalars: rigid gap, its last value, time steps rolled so far, steps since this run started, means of
# the squares of State.change and of its products with the errors of State.predicted
RIGID_APPROACH, RIGID_APPROACH_OLD, TRAVEL, AGE, CHANGES_SQUARED, CHANGES_TIMES_ERRORS = range(6)


class Macroscopic(NamedTuple):
    """Macroscopic pressure and the averages that drive it."""

    pressure: np.ndarray
    typical: np.ndarray  # lateral fluidity of the typical gap, exp<ln f_y>
    sum_exchange: np.ndarray  # over the current window
    sum_pressure: np.ndarray
    sum_conductance: np.ndarray
    sum_log_flux: np.ndarray
    sum_log_lateral: np.ndarray
    conductance: np.ndarray  # long averages
    log_flux: np.ndarray
    counts: np.ndarray  # steps in the window, updates so far
    shares: np.ndarray  # asperity load share: sum over the current window, long average
    total_exchange: np.ndarray  # over the whole run, for the net exchange
    matrix: np.ndarray  # (4, n) scratch
    total: np.ndarray  # time mean of the total pressure, Q
    sum_total: np.ndarray  # of the total pressure, over the current window
    deflection: np.ndarray  # (K_log - K_e) Q, film units
    kind: np.ndarray  # scratch: nodes at which Q is updated


class Step(NamedTuple):
    """The problem of one time step: what is known before pressure is."""

    gap: np.ndarray  # rigid gap with roughness, without approach
    upstream_mass: np.ndarray  # mass at the upstream_mass of the characteristic
    weight: np.ndarray  # 2/3 where BDF2 holds, 1 where backward Euler does
    # of the last step: place of the film temperature in the table, and shares as in `State`
    thermal: np.ndarray
    along_share: np.ndarray
    across_share: np.ndarray


class FluidityRows(NamedTuple):
    """A row of points: film, pressure, place of the temperature and shares in, fluidity and its derivatives out."""

    film: np.ndarray
    pressure: np.ndarray
    thermal: np.ndarray
    along_share: np.ndarray
    across_share: np.ndarray
    density: np.ndarray  # rho/rho0
    density_slope: np.ndarray  # d ln(rho)/dp
    exponent: np.ndarray  # ln(eta/eta0)
    slope: np.ndarray  # d ln(eta)/dp
    rate: np.ndarray  # eta u_s/(tau0 h)
    viscous: np.ndarray  # fluidity at the low-shear viscosity
    per_film: np.ndarray  # 1/h
    stress_slope: np.ndarray  # d ln tau0/dp
    known_film: np.ndarray  # of the last evaluation
    known_pressure: np.ndarray
    known_f: np.ndarray
    f: np.ndarray
    by_film: np.ndarray
    by_pressure: np.ndarray  # at constant density
    listed: np.ndarray  # first of each four points to be evaluated

    @classmethod
    def of(cls, n: int) -> FluidityRows:
        """Rows of n points with one temperature across the film."""
        rows = cls(*(np.zeros(n, dtype=np.int64 if name == "listed" else np.float64) for name in cls._fields))
        rows.along_share[:] = rows.across_share[:] = 1.0
        return rows


class HeatRows(NamedTuple):
    """Rows of the balance of shear stress and temperature."""

    conductance: np.ndarray  # of the film [W/(m2 K)]; zero where it is broken
    jump: np.ndarray  # temperature difference the past leaves between the surfaces [K]
    rub: np.ndarray  # heat freed at the walls: asperity friction and pressure-driven flow [W/m2]
    base: np.ndarray  # film temperature without shear heat [K]
    resistance: np.ndarray  # K per p_h of shear stress
    place: np.ndarray  # of the pressure in the table
    rate: np.ndarray  # ln of the scaled shear rate
    scale: np.ndarray  # tau0 over the reference stress
    slope: np.ndarray  # d tau/dT
    decay: np.ndarray  # -d ln(eta)/dT [1/K]
    low: np.ndarray  # bracket of the film temperature
    high: np.ndarray
    left: np.ndarray  # what the balance is still off by [K]
    sums: np.ndarray  # (n + 3,) rise by slot of the memory
    line: np.ndarray  # (n + 3,) the same in the order of the nodes


class Work(NamedTuple):
    """Scratch of the Newton iteration."""

    kind: np.ndarray
    total: np.ndarray
    response: np.ndarray
    residual: np.ndarray  # (2, n): mass, gap
    source: np.ndarray  # net flow into the node
    half: FluidityRows  # along x, entry i between nodes i and i + 1
    node: FluidityRows  # across, for the drainage
    fluidity: np.ndarray  # along x as used: relaxed or kept in the fallbacks
    flow: np.ndarray
    flow_by_film: np.ndarray  # derivatives by the mean of both ends
    flow_by_pressure: np.ndarray
    density: np.ndarray  # at the nodes, and its pressure slope
    density_slope: np.ndarray
    exchange: np.ndarray  # conductance to the macroscopic pressure
    outward: np.ndarray  # side flow out of the node, and its derivatives
    outward_by_film: np.ndarray
    outward_by_pressure: np.ndarray
    heat: HeatRows
    band: np.ndarray
    unit: np.ndarray
    solution: np.ndarray
    block: np.ndarray


class Saved(NamedTuple):
    """Copies a fallback returns to."""

    path_fluid: np.ndarray  # last good point of the continuation
    path_contact: np.ndarray
    last_fluid: np.ndarray
    last_contact: np.ndarray
    path: np.ndarray  # progress of the continuation
    last_step: Step
    target_step: Step
