"""The points of a plan as columns: sampled, crossed with its lists, with what no gear has left out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ehl.fluid.lubricant_inputs import DirectLubricant, OilLubricant
from ehl.io.units import ValueRange
from ehl.io.validation import validate
from regression.friction.conditions import LUBRICANT_UNITS, derive, lubricant_row
from regression.plan.axes import VARIABLES, quantity_of
from regression.plan.constraints import constrained_figures
from regression.plan.plan import TABLE_OF, Plan
from regression.plan.sampling import Accept, Array, Block, BoxSampler, IntArray, filtered, lattice

_TEMPERATURE: ValueRange = quantity_of(VARIABLES["temperature_oil"])


@dataclass(frozen=True)
class PlanPoints:
    """All points of a plan, in a fixed order.

    Parameters
    ----------
    origin : tuple of str
        sobol, latin, corner, lattice or table.
    columns : dict
        Values of the variables, SI.
    oils : tuple of str or None
        Oil card of each point; None where the lubricant is given by numbers.
    seed : int array or None
        Of the roughness of each point; None where the model knows none.
    skipped : dict
        Window to the share of the points looked at that lie outside of it.
    """

    origin: tuple[str, ...]
    columns: dict[str, Array]
    oils: tuple[str | None, ...]
    seed: IntArray | None
    skipped: dict[str, float]

    def __len__(self) -> int:
        return len(self.origin)

    def values(self, index: int) -> dict[str, float]:
        """Values of the variables at one point."""
        return {name: float(column[index]) for name, column in self.columns.items()}


def plan_points(plan: Plan) -> PlanPoints:
    """All points of a plan, in a fixed order: oils, lists, sampled points, corners, realisations of the roughness."""
    origin: list[str] = []
    oils: list[str | None] = []
    columns: dict[str, list[Array]] = {name: [] for name in (*plan.axes, *plan.columns)}
    numbers: list[IntArray] = []
    looked: Counter[str] = Counter()
    for oil in (None,) if "oil" in plan.table else plan.oils or (None,):
        for fixed in lattice(plan.axes):
            for block in _blocks(plan, constraint_check(plan, fixed, oil, looked)):
                n = block.number.size
                origin += [block.origin] * n
                oils += _oils(plan, block.number, oil)
                numbers.append(block.number)
                for name, parts in columns.items():
                    parts.append(block.columns[name] if name in block.columns else np.full(n, fixed[name]))
    repeat = plan.sampling.realisations
    return PlanPoints(
        tuple(o for o in origin for _ in range(repeat)),
        {name: np.repeat(np.concatenate(parts), repeat) for name, parts in columns.items()},
        tuple(o for o in oils for _ in range(repeat)),
        roughness_seeds(plan, np.concatenate(numbers)),
        {name: count / looked["all"] for name, count in looked.items() if name != "all"},
    )


def roughness_seeds(plan: Plan, number: IntArray) -> IntArray | None:
    """Seeds of the profiles that points of these numbers meet, all realisations; None where the model knows none."""
    if plan.model.roughness != "deterministic":
        return None
    repeat = plan.sampling.realisations
    own = np.zeros_like(number) if plan.sampling.same_profile else number
    return np.asarray(plan.surface.seed + (own[:, None] * repeat + np.arange(repeat)).ravel())


def _blocks(plan: Plan, accept: Accept | None) -> Iterator[Block]:
    sampler = BoxSampler(plan.axes, plan.sampling.method, plan.sampling.seed)
    if plan.table:
        yield filtered("table", plan.columns, np.arange(len(next(iter(plan.table.values())))), accept)
    elif sampler.ranges:
        assert plan.sampling.size is not None
        yield sampler.inside(plan.sampling.size, accept)
        if plan.sampling.corners:
            yield sampler.corners(None if plan.sampling.corners is True else int(plan.sampling.corners), accept)
    else:
        yield filtered("lattice", {}, np.arange(1), accept)


def _oils(plan: Plan, number: IntArray, oil: str | None) -> list[str | None]:
    """Oil card of each point of a block."""
    if "oil" in plan.table:
        return [str(plan.table["oil"][row]) for row in number]
    return [oil] * number.size


def constraint_check(
    plan: Plan, fixed: Mapping[str, float], oil: str | None, looked: Counter[str] | None = None
) -> Accept | None:
    """What says of sampled points, beside these fixed values, whether a gear has them; None without constraints."""
    windows = plan.constraints.windows
    if not windows:
        return None
    counts: Counter[str] = Counter() if looked is None else looked

    def accept(columns: dict[str, Array], number: IntArray) -> NDArray[np.bool_]:
        values = {**{name: np.full(number.size, value) for name, value in fixed.items()}, **columns}
        figures = constrained(plan, values, _oils(plan, number, oil))
        passed = np.ones(number.size, dtype=bool)
        for name, window in windows.items():
            inside = window.holds(figures[name])
            counts[name] += int(np.count_nonzero(~inside))
            passed &= inside
        counts["all"] += number.size
        return passed

    return accept


def constrained(plan: Plan, columns: Mapping[str, Array], oils: Sequence[str | None]) -> dict[str, Array]:
    """The figures of `regression.plan.constraints.Constraints` at points given by values of the variables."""
    table = state_table(plan, columns, len(oils))
    ratio = None
    if plan.constraints.need_oil:
        ratio = derive({**table, **lubricant_table(plan, columns, oils)})["film_ratio_formula"]
    return constrained_figures(table, plan.bodies, ratio)


def state_table(plan: Plan, columns: Mapping[str, Array], size: int) -> dict[str, Array]:
    """Columns of `regression.friction.conditions.STATE_UNITS` from the values of the variables."""
    temperature = _TEMPERATURE.check(plan.lubricant.get("temperature_oil", 353.15), "lubricant.temperature_oil")
    table = {
        "effective_modulus": np.full(size, plan.modulus),
        "speed_sliding_lengthwise": np.zeros(size),
        "temperature_oil": np.full(size, temperature),
        "roughness_rms_1": np.zeros(size),
        "roughness_rms_2": np.zeros(size),
        "correlation_length": np.full(size, plan.surface.correlation_length),
        **columns,
    }
    if "lengthwise_to_roll" in table:
        table["speed_sliding_lengthwise"] = table.pop("lengthwise_to_roll") * table["speed_entrainment"]
    if "roughness_rms" in table:
        table["roughness_rms_1"] = table["roughness_rms_2"] = table.pop("roughness_rms") / 2.0**0.5
    return table


def lubricant_table(plan: Plan, columns: Mapping[str, Array], oils: Sequence[str | None]) -> dict[str, Array]:
    """Columns of `regression.friction.conditions.LUBRICANT_UNITS` at the points."""
    names = [name for name in columns if TABLE_OF.get(name) == "lubricant"]
    rows = []
    for i, oil in enumerate(oils):
        content = {**plan.lubricant, **{name: float(columns[name][i]) for name in names}}
        if oil is not None:
            content["oil"] = oil
        given: OilLubricant | DirectLubricant = (
            validate(OilLubricant, content, "lubricant")
            if "oil" in content
            else validate(DirectLubricant, content, "lubricant")
        )
        rows.append(lubricant_row(given.lubricant(), float(columns["pressure_hertz"][i])))
    return {name: np.array([row[name] for row in rows]) for name in LUBRICANT_UNITS}
