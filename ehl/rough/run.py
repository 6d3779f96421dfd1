"""State of a transient run and its time integration in blocks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.heat._kernels import RISE_ABOVE
from ehl.rough._kernels.fluid import temperature_place
from ehl.rough._kernels.heat import preheat
from ehl.rough._kernels.march import COLUMNS, march
from ehl.rough._kernels.motion import move_surfaces
from ehl.rough._kernels.quasi_separable import MODES, exponential_product
from ehl.rough._kernels.records import (
    RIGID_APPROACH,
    RIGID_APPROACH_OLD,
    TRAVEL,
    FluidityRows,
    HeatRows,
    Macroscopic,
    Saved,
    State,
    Step,
    Work,
)
from ehl.rough._kernels.side_flow import deflect_mean
from ehl.rough.scaling import RunProblem, hertz_start

PROFILES = 6


def _width(n: int) -> int:
    """Numbers from one row of n to the next: ten cache lines more than a multiple of 4096 bytes.

    Rows with the same address modulo 4096 would evict each other from the cache.
    """
    return -(-n // 512) * 512 + 80


def _rows(n: int) -> Iterator[FloatArray]:
    """Any number of arrays of n zeros (`_width`)."""
    while True:
        yield from np.zeros((16, _width(n)))[:, :n]


def _step_arrays(n: int) -> Step:
    step = Step(*islice(_rows(n), len(Step._fields)))
    step.weight[:] = step.along_share[:] = step.across_share[:] = 1.0
    return step


def _work_arrays(n: int) -> Work:
    rows = _rows(n)
    fields: dict[str, Any] = {name: next(rows) for name in Work._fields}
    fields |= {name: np.zeros((count, _width(n))) for name, count in (("residual", 2), ("band", 6), ("solution", 4))}
    for name in ("half", "node"):
        points = dict(zip(FluidityRows._fields, rows, strict=False))
        fields[name] = FluidityRows(**points | {"listed": np.zeros(n, dtype=np.int64)})
    heat = dict(zip(HeatRows._fields, rows, strict=False)) | {name: np.zeros(n + 3) for name in ("sums", "line")}
    return Work(
        **fields
        | {
            "kind": np.zeros(n, dtype=np.int64),
            "heat": HeatRows(**heat),
            "block": np.zeros((n, 4 + 2 * MODES)),
        }
    )


def _macroscopic(pressure: FloatArray) -> Macroscopic:
    n = pressure.size
    fields: dict[str, Any] = dict(zip(Macroscopic._fields, _rows(n), strict=False))
    return Macroscopic(
        **fields
        | {
            "pressure": pressure,
            "counts": np.zeros(2, dtype=np.int64),
            "shares": np.zeros(2),
            "matrix": np.zeros((4, n)),
            "kind": np.zeros(n, dtype=np.int64),
        }
    )


@dataclass
class TransientRun:
    """State of one time integration."""

    problem: RunProblem  # constants
    state: State = field(init=False, repr=False)
    macroscopic: Macroscopic = field(init=False, repr=False)
    _step: Step = field(init=False, repr=False)
    _saved: Saved = field(init=False, repr=False)
    _work: Work = field(init=False, repr=False)

    def __post_init__(self) -> None:
        model = self.problem.model
        n = self.problem.x.size
        pressure, mass, level = hertz_start(self.problem)
        scalars = np.zeros(6)
        scalars[RIGID_APPROACH] = scalars[RIGID_APPROACH_OLD] = level
        scalars[TRAVEL] = round(self.problem.settings.start_travel * self.problem.units.steps_per_half_width)
        modes = model.heat.ratios.size
        self.state = State(
            fluid_pressure=pressure.copy(),
            contact_pressure=np.zeros(n),
            fluid_pressure_old=pressure.copy(),
            contact_pressure_old=np.zeros(n),
            mean_pressure=pressure.copy(),
            predicted=np.zeros(n),
            change=np.zeros(n),
            film=np.zeros(n),
            mass=mass,
            mass_old=mass.copy(),
            temperature=np.full(n, model.fluid.temperature + 0.5 * (model.heat.bulk_1 + model.heat.bulk_2)),
            rise_share=np.full(n, RISE_ABOVE[0]),
            along_share=np.ones(n),
            across_share=np.ones(n),
            surface_temperature=np.zeros((2, n)),
            flux_into=np.zeros((2, n)),
            memory=np.zeros((2, modes, n + 3)),
            memory_base=np.zeros(2, dtype=np.int64),
            memory_offset=np.zeros(2),
            entering=np.zeros((2, n + 3)),
            shear=np.zeros(n),
            strained=np.zeros(n),
            outflow=np.ones(n),
            scalars=scalars,
        )
        start = 0.5 * pressure if model.side_flow.on else np.zeros(n)
        start[model.contact.outlet :] = 0.0
        start[:2] = model.contact.inlet_pressure
        self._work = _work_arrays(n)
        self.macroscopic = _macroscopic(start)
        if model.side_flow.on:
            self.macroscopic.total[:] = pressure
            deflect_mean(self.macroscopic, self._work, model)
        self._step = _step_arrays(n)
        self._step.thermal[:] = temperature_place(model.fluid.temperature, model.fluid.table)
        self._saved = Saved(
            path_fluid=np.zeros(n),
            path_contact=np.zeros(n),
            last_fluid=np.zeros(n),
            last_contact=np.zeros(n),
            path=np.zeros(5),
            last_step=_step_arrays(n),
            target_step=_step_arrays(n),
        )

    @property
    def travel(self) -> float:
        """Travel so far [b]."""
        return float(self.state.scalars[TRAVEL]) * self.problem.model.surfaces.spacing

    @property
    def flow(self) -> FloatArray:
        """Pressure flow times the time step, between node i and i + 1, of the last step; positive against x."""
        return self._work.flow

    def advance(self, steps: int) -> tuple[FloatArray, FloatArray]:
        """Integrate over some steps; returns their records (steps, COLUMNS) and mean profiles (PROFILES, n)."""
        records = np.zeros((steps, COLUMNS))
        profiles = np.zeros((PROFILES, self.problem.x.size))
        state = (self.state, self._step, self._saved, self.macroscopic, self._work)
        march(steps, *state, self.problem.model, records, profiles)
        return records, profiles / max(steps, 1)

    def preheat(self, travel: float, flux: FloatArray) -> None:
        """Heat the surfaces from their bulk temperatures by a steady flux (2, n) [W/m2] over a travel [b]."""
        steps = round(travel * self.problem.units.steps_per_half_width)
        preheat(steps, flux, self.state, self._work, self.problem.model)

    def elastic_response(self, total: FloatArray) -> FloatArray:
        """Elastic gap under a pressure, film units."""
        elastic, response = self.problem.model.elastic, np.zeros(total.size)
        exponential_product(total, elastic.weights, elastic.ratios, response)
        return np.asarray(response + self.macroscopic.deflection)

    def start_from(self, other: TransientRun) -> None:
        """Interpolate the state from a run of the same contact on another mesh.

        Thermal memories are not interpolated: their modes depend on the time step.
        """
        x, x_other = self.problem.x, other.problem.x

        def take(target: FloatArray, source: FloatArray) -> None:
            target[:] = np.interp(x, x_other, source)

        ratio = other.problem.units.film / self.problem.units.film
        pressures = "fluid_pressure", "contact_pressure", "mean_pressure"
        for name in (*pressures, "temperature", "rise_share", "along_share", "across_share"):
            take(getattr(self.state, name), getattr(other.state, name))
        for name in ("film", "mass"):
            take(getattr(self.state, name), ratio * getattr(other.state, name))
        self.state.fluid_pressure[self.state.fluid_pressure < 1e-9] = 0.0
        take(self.macroscopic.pressure, other.macroscopic.pressure)
        if self.problem.model.side_flow.on:
            take(self.macroscopic.total, other.macroscopic.total)
            deflect_mean(self.macroscopic, self._work, self.problem.model)
        self.state.scalars[RIGID_APPROACH] = self.state.scalars[RIGID_APPROACH_OLD] = self._level_of_film()
        if other.macroscopic.counts[1] > 0:
            scale = self.problem.units.spacing / other.problem.units.spacing  # of dt in the exchange, dt/dx^2 along x
            # nodes with side flow only: the averages of the others are zero and have no logarithm
            known = slice(other.problem.model.side_flow.first, other.problem.model.contact.outlet)
            for target, source in (
                (self.macroscopic.typical, scale * other.macroscopic.typical),
                (self.macroscopic.conductance, scale * other.macroscopic.conductance),
                (self.macroscopic.log_flux, other.macroscopic.log_flux - np.log(scale)),
            ):
                target[:] = np.interp(x, x_other[known], source[known])
            self.macroscopic.counts[1] = other.macroscopic.counts[1]
            self.macroscopic.shares[1] = other.macroscopic.shares[1]

    def branch(self, problem: RunProblem) -> TransientRun:
        """Another run that continues from this state on the same mesh with other settings."""
        other = TransientRun(problem)
        for mine, its in ((self.state, other.state), (self.macroscopic, other.macroscopic), (self._step, other._step)):
            for source, target in zip(mine, its, strict=True):
                target[...] = source
        return other

    def _level_of_film(self) -> float:
        """Rigid gap for the current mean film under the current pressures."""
        model = self.problem.model
        response = self.elastic_response(self.state.fluid_pressure + self.state.contact_pressure)
        middle = slice(model.contact.middle_first, model.contact.middle_last)
        gap = np.zeros(self.problem.x.size)
        move_surfaces(gap, self.state.scalars[TRAVEL], model.surfaces)
        return float(np.mean((self.state.film - gap - response)[middle]))
