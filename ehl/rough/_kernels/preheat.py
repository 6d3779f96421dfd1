"""Heat both surfaces by a flux that stands still, without solving for the film."""

from __future__ import annotations

from numba import njit

from ehl.rough._kernels.elasticity import PUBLIC
from ehl.rough._kernels.heat import recall_surfaces, store_fluxes


@njit(**(PUBLIC | {"_nrt": True}))  # assignment of whole arrays asks for it
def preheat(steps, flux, state, work, model):
    """Roll the surfaces through the flux (2, n) for a number of steps, from their bulk temperatures."""
    state.memory[:] = 0.0
    state.entering[:] = 0.0
    state.flux_into[:] = flux
    for _ in range(steps):
        store_fluxes(state, work)
        recall_surfaces(state, work, model)
    store_fluxes(state, work)
