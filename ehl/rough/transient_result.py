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
    """Steps by the way they were solved; only ``lagged`` and ``unconverged`` change the discrete problem."""

    plain: int  # by Newton
    # relaxed, slow: by Newton and relaxed Picard iteration on the fluidity in turns, and by Picard with weight 0.2
    relaxed: int
    continued: int  # by continuation from the step before
    slow: int
    lagged: int  # with the fluidity of the prediction
    unconverged: int  # not converged; the pressures of the step before were kept

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
    temperature_film: FloatArray  # mid-layer [K]
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

    status: str  # "converged", or "unsettled" when mu is usable but its error exceeds the tolerance, or "failed"
    reason: str  # one of `REASONS`
    notes: tuple[str, ...]  # limits of the model that this case touches
    # mu = fluid + asperity part [-]
    friction_coefficient: float
    friction_fluid: float
    friction_asperity: float
    # integral of the asperity pressure over the load [-]; this part carries the boundary friction
    asperity_load_share: float
    # 1 - integral of the macroscopic pressure over the load [-]; what statistical models call the asperity load. nan
    # when sealed.
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
    # half width of the 90 % interval of mu over other stretches of the same surfaces, over mu: the figure above, larger
    # where the window is longer than the profiles or a surface brings little new roughness
    realisation_error: float
    # error of mesh and time step that their extrapolation leaves, over mu (`ehl.rough.batch_means.richardson`)
    mesh_error: float
    film_error: float  # the same of the mean film, with the half width of its 90 % interval, over the film
    # mu at half and twice the boundary film; nan where not computed (share below 0.01, or accuracy "fast")
    friction_boundary_half: float
    friction_boundary_double: float
    boundary_film: float  # h_boundary [m]
    # largest running sum of the mean side flow along x over the throughput [-]; small when the macroscopic pressure has
    # settled
    net_exchange: float
    # its statistical threshold in a window of this length (1 % level) [-]; nan without enough batches
    net_exchange_threshold: float
    capped_share: float  # mean share of the nodes whose pressure is at the hardness [-]
    fallbacks: Fallbacks  # steps by the way they were solved, start-up included
    iterations_per_step: float  # Newton or Picard iterations
    # of the fine run
    nodes: int
    steps: int
    repeats: int  # blocks of the window that were thrown away and rolled again, because the film of a step had jumped
    travel: float  # window [b]
    seconds: float  # wall time of everything
    # mu over the rolled distance [b] in the window
    history_travel: FloatArray = field(repr=False)
    history_friction: FloatArray = field(repr=False)
    profiles: Profiles = field(repr=False)  # time means
    snapshot: Snapshot = field(repr=False)  # last step
    # the fine run as it stands after the last step; a copy of it can be marched on
    run: TransientRun = field(repr=False)
    # error of mu by the subgrid film in place of roughness finer than the mesh, over mu (`ehl.rough.subgrid`); 0
    # without
    subgrid_error: float = 0.0
    exchange_error: float = 0.0  # error of mu by what the side flow gains or loses in the mean, over mu

    @property
    def friction_error(self) -> float:
        """Error of mu over itself: independent parts, added in quadrature [-]."""
        return math.hypot(self.mesh_error, self.statistical_error, self.subgrid_error, self.exchange_error)
