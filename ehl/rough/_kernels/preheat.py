"""Heat both surfaces by a flux that stands still, without solving for the film."""

from __future__ import annotations

from ehl.compile.compiler import kernel
from ehl.rough._kernels.elasticity import PUBLIC
from ehl.rough._kernels.heat import recall_surfaces, store_fluxes


@kernel(**PUBLIC)
def preheat(steps, flux, state, work, model):
    """Roll the surfaces through the flux (2, n) for a number of steps, from their bulk temperatures."""
    for body in range(2):
        for i in range(flux.shape[1]):
            state.flux_into[body, i] = flux[body, i]
        for i in range(state.entering.shape[1]):
            state.entering[body, i] = 0.0
            for mode in range(state.memory.shape[1]):
                state.memory[body, mode, i] = 0.0
    for _ in range(steps):
        store_fluxes(state, work)
        recall_surfaces(state, work, model)
    store_fluxes(state, work)
