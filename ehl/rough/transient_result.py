"""Result of the transient solver."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ehl.common.arrays import FloatArray

if TYPE_CHECKING:
    from ehl.rough.run import TransientRun


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
    """Number of steps by solution method; only ``lagged`` and ``unconverged`` change the discrete problem."""

    plain: int  # by Newton
    relaxed: int  # by alternating Newton and relaxed Picard iterations on the fluidity
    continued: int  # by continuation from the previous step
    slow: int  # by Picard iterations with weight 0.2
    lagged: int  # with the fluidity of the prediction
    unconverged: int  # not converged; the pressures of the previous step were kept

    @property
    def total(self) -> int:
        """All steps."""
        return self.plain + self.relaxed + self.continued + self.slow + self.lagged + self.unconverged


@dataclass(frozen=True, eq=False)
class Profiles:
    """Time means along x over the window; shape (n,) each."""

    x: FloatArray  # nodes [m]
    # parts of the pressure [Pa]
    pressure_fluid: FloatArray
    pressure_asperity: FloatArray
    pressure_macroscopic: FloatArray  # P of the side flow [Pa]; zero when sealed
    film: FloatArray  # gap [m]
    temperature_film: FloatArray  # at which the film has its effective viscosity [K]
    temperature_surface: FloatArray  # warmer surface [K]


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The last time step; shape (n,) each."""

    x: FloatArray  # nodes [m]
    # [Pa]
    pressure_fluid: FloatArray
    pressure_asperity: FloatArray
    film: FloatArray  # gap [m]
    filling: FloatArray  # mass over the mass of a full gap [-]; below 1 where the film is broken
    temperature_film: FloatArray  # [K]


@dataclass(frozen=True, eq=False)
class TransientResult:
    """Friction, films and shares of a rough moving contact, averaged over the window, with their errors."""

    status: str  # "converged", "unsettled" if mu is usable but its error exceeds four tolerances, or "failed"
    reason: str  # one of `REASONS`
    notes: tuple[str, ...]  # limits of the model that concern this case
    # mu = fluid + asperity part [-]
    friction_coefficient: float
    friction_fluid: float
    friction_asperity: float
    # integral of the asperity pressure over the load [-]; this part has boundary friction
    asperity_load_share: float
    # 1 - integral of the macroscopic pressure over the load [-], the asperity load of statistical models; nan when
    # sealed
    roughness_load_share: float
    film_mean: float  # mean gap over 80 % of the Hertz width [m]
    # time means of the smallest gap [m] and the largest pressure [Pa]
    film_min: float
    pressure_max: float
    film_ratio: float  # lambda by Moes's film formula [-]; infinity when smooth
    # time means of the largest film and surface temperature [K]; the inlet temperature without heat
    temperature_film_max: float
    temperature_flash: float
    # half width of the 90 % interval of mu by batch means, over mu; nan without enough batches
    statistical_error: float
    # half width of the 90 % interval of mu over other realisations of the same surfaces, over mu: `statistical_error`,
    # increased if the window is longer than the profiles or a surface contributes little new roughness
    realisation_error: float
    # error of the extrapolated mu by mesh and time step, over mu (`ehl.rough.averaging.richardson`)
    mesh_error: float
    film_error: float  # of the mean film by mesh and time step and its 90 % interval, over the film
    # mu at half and twice the boundary film; nan where not computed (share below 0.01, or accuracy "fast")
    friction_boundary_half: float
    friction_boundary_double: float
    boundary_film: float  # h_boundary [m]
    # largest running sum of the mean side flow along x over the throughput [-]; small for a settled macroscopic
    # pressure
    net_exchange: float
    fallbacks: Fallbacks  # steps by solution method, start-up included
    iterations_per_step: float  # Newton or Picard iterations
    # of the fine run
    nodes: int
    steps: int
    repeats: int  # blocks that were discarded and repeated because the film of a step had diverged
    travel: float  # window [b]
    seconds: float  # wall time [s]
    # mu over the travel [b] in the window
    history_travel: FloatArray = field(repr=False)
    history_friction: FloatArray = field(repr=False)
    profiles: Profiles = field(repr=False)  # time means
    snapshot: Snapshot = field(repr=False)  # last step
    run: TransientRun = field(repr=False)  # state of the fine run after the last step; a copy can be continued
    # error of mu by the subgrid film for unresolved roughness, over mu (`ehl.rough.mixed`); 0 without
    subgrid_error: float = 0.0
    exchange_error: float = 0.0  # error of mu by the net side flow, over mu

    @property
    def friction_error(self) -> float:
        """Relative error of mu, the root sum of squares of independent parts [-]."""
        return math.hypot(self.mesh_error, self.statistical_error, self.subgrid_error, self.exchange_error)
