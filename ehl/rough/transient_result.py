"""Result of the transient solver."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ehl.rough.run import TransientRun

Array = NDArray[np.float64]

REASONS = (
    "",
    "statistical_interval",
    "macroscopic_pressure",
    "net_exchange",
    "unconverged_steps",
    "lagged_steps",
    "film_jump",
    "not_finite",
)


@dataclass(frozen=True)
class Fallbacks:
    """Steps by the way they were solved; only ``lagged`` and ``unconverged`` change the discrete problem.

    Parameters
    ----------
    plain : int
        By Newton.
    relaxed, slow : int
        By Newton and relaxed Picard iteration on the fluidity in turns, and by Picard with weight 0.2.
    continued : int
        By continuation from the step before.
    lagged : int
        With the fluidity of the prediction.
    unconverged : int
        Not converged; the pressures of the step before were kept.
    """

    plain: int
    relaxed: int
    continued: int
    slow: int
    lagged: int
    unconverged: int

    @property
    def total(self) -> int:
        """All steps."""
        return self.plain + self.relaxed + self.continued + self.slow + self.lagged + self.unconverged


@dataclass(frozen=True, eq=False)
class Profiles:
    """Time means along x over the window; shape (n,) each.

    Parameters
    ----------
    x : ndarray
        Nodes [m].
    pressure_fluid, pressure_asperity : ndarray
        Parts of the pressure [Pa].
    pressure_macroscopic : ndarray
        P of the side flow [Pa]; zero when sealed.
    film : ndarray
        Gap [m].
    temperature_film : ndarray
        Mid-layer [K].
    temperature_surface : ndarray
        Warmer surface [K].
    """

    x: Array
    pressure_fluid: Array
    pressure_asperity: Array
    pressure_macroscopic: Array
    film: Array
    temperature_film: Array
    temperature_surface: Array


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The last time step; shape (n,) each.

    Parameters
    ----------
    x : ndarray
        Nodes [m].
    pressure_fluid, pressure_asperity : ndarray
        [Pa].
    film : ndarray
        Gap [m].
    filling : ndarray
        Mass over the mass of a full gap [-]; below 1 where the film is broken.
    temperature_film : ndarray
        [K].
    """

    x: Array
    pressure_fluid: Array
    pressure_asperity: Array
    film: Array
    filling: Array
    temperature_film: Array


@dataclass(frozen=True, eq=False)
class TransientResult:
    """Friction, films and shares of a rough moving contact, averaged over the window, with their errors.

    Parameters
    ----------
    status : str
        "converged", or "unsettled" when mu is usable but its interval is wider than asked for, or "failed".
    reason : str
        One of `REASONS`.
    notes : tuple of str
        Limits of the model that this case touches.
    friction_coefficient, friction_fluid, friction_asperity : float
        mu = fluid + asperity part [-].
    asperity_load_share : float
        Integral of the asperity pressure over the load [-]; this part carries the boundary friction.
    roughness_load_share : float
        1 - integral of the macroscopic pressure over the load [-]; what statistical models call the asperity load.
        nan when sealed.
    film_mean : float
        Mean gap over 80 % of the Hertz width [m].
    film_min, pressure_max : float
        Time means of the smallest gap [m] and the largest pressure [Pa].
    film_ratio : float
        lambda by Moes's film formula [-]; infinity when smooth.
    temperature_film_max, temperature_flash : float
        Time means of the largest film and surface temperature [K]; the inlet temperature without heat.
    statistical_error : float
        Half width of the 90 % interval of mu by batch means, over mu; nan without enough batches.
    realisation_error : float
        Half width of the 90 % interval of mu over other stretches of the same surfaces, over mu: the figure above,
        larger where the window is longer than the profiles or a surface brings little new roughness.
    mesh_error : float
        Error of mesh and time step that their extrapolation leaves, over mu (`ehl.rough.batch_means.richardson`).
    film_error : float
        The same of the mean film, with the half width of its 90 % interval, over the film.
    friction_boundary_half, friction_boundary_double : float
        mu at half and twice the boundary film; nan where not computed (share below 0.01, or accuracy "fast").
    boundary_film : float
        h_boundary [m].
    net_exchange : float
        Largest running sum of the mean side flow along x over the throughput [-]; small when the macroscopic
        pressure has settled.
    net_exchange_threshold : float
        Its statistical threshold in a window of this length (1 % level) [-]; nan without enough batches.
    capped_share : float
        Mean share of the nodes whose pressure is at the hardness [-].
    fallbacks : Fallbacks
        Steps by the way they were solved, start-up included.
    iterations_per_step : float
        Newton or Picard iterations.
    nodes, steps : int
        Of the fine run.
    repeats : int
        Blocks of the window that were thrown away and rolled again, because the film of a step had jumped.
    travel : float
        Window [b].
    seconds : float
        Wall time of everything.
    history_travel, history_friction : ndarray
        mu over the rolled distance [b] in the window.
    profiles : Profiles
        Time means.
    snapshot : Snapshot
        Last step.
    run : Run
        The fine run as it stands after the last step; a copy of it can be marched on.
    subgrid_error : float
        Error of mu by the subgrid film in place of roughness finer than the mesh, over mu (`ehl.rough.subgrid`); 0
        without.
    exchange_error : float
        Error of mu by what the side flow gains or loses in the mean, over mu.
    """

    status: str
    reason: str
    notes: tuple[str, ...]
    friction_coefficient: float
    friction_fluid: float
    friction_asperity: float
    asperity_load_share: float
    roughness_load_share: float
    film_mean: float
    film_min: float
    pressure_max: float
    film_ratio: float
    temperature_film_max: float
    temperature_flash: float
    statistical_error: float
    realisation_error: float
    mesh_error: float
    film_error: float
    friction_boundary_half: float
    friction_boundary_double: float
    boundary_film: float
    net_exchange: float
    net_exchange_threshold: float
    capped_share: float
    fallbacks: Fallbacks
    iterations_per_step: float
    nodes: int
    steps: int
    repeats: int
    travel: float
    seconds: float
    history_travel: Array = field(repr=False)
    history_friction: Array = field(repr=False)
    profiles: Profiles = field(repr=False)
    snapshot: Snapshot = field(repr=False)
    run: TransientRun = field(repr=False)
    subgrid_error: float = 0.0
    exchange_error: float = 0.0

    @property
    def friction_error(self) -> float:
        """Error of mu over itself: independent parts, added in quadrature [-]."""
        return math.hypot(self.mesh_error, self.statistical_error, self.subgrid_error, self.exchange_error)
