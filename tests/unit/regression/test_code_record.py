"""Recording: operations, names and refusals; laws of all oil cards; every family can be exported."""

import json
import math
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contacts import gear_state
from scipy.special import expit
from small_plans import point_options

from ehl.common.data import data_names
from ehl.fluid.oil import Oil
from regression.export import record
from regression.export.program import program_of
from regression.export.python_text import PythonPrinter, python_text
from regression.export.record import NotRecordable
from regression.formula import Formula
from regression.friction.conditions import LUBRICANT_UNITS, conditions_of, lubricant_row
from regression.friction.families import FAMILIES

# functions a family may use, and arguments where their rewriting could lose digits
FUNCTIONS: list[tuple[Callable[[Any, Any], Any], list[float], list[float]]] = [
    (lambda x, y: (x + y) * (x - (y - 1.0)) / (x / y) - -((x**2.0) ** y) / np.exp(np.log(x)), [3.0, 0.5], [4.0, 2.0]),
    (lambda x, y: np.hypot(x, y), [3.0, 1e-9], [4.0, 1e-3]),
    (lambda x, y: np.log1p(x) + np.expm1(y), [1e-12, 3.0], [1e-12, 5.0]),
    (lambda x, y: np.expm1(x) / np.log1p(y), [40.0, 1e-9], [1e3, 1e-9]),
    (lambda x, y: expit(x) + np.logaddexp(x, y), [-30.0, 2.0], [30.0, 2.5]),
    (lambda x, y: np.where((x > 1.5) & ~(y > 2.0), x, y), [1.0, 3.0], [2.0, 2.0]),
    (lambda x, y: np.clip(x, 0.0, 1.0) + np.square(y) + np.cbrt(y) + np.reciprocal(y), [-1.0, 0.5], [2.0, 3.0]),
    (lambda x, y: np.exp(-x) * np.tanh(y) * np.arctan(y) + np.abs(-x), [0.3, 2.0], [0.1, 4.0]),
    (lambda x, y: np.divide(x, y, out=np.full_like(x, np.inf), where=y > 0.0), [1.0, 2.0], [0.0, 4.0]),
    (lambda x, y: np.column_stack([np.ones_like(x), x, y]) @ np.array([1.0, 2.0, 3.0]), [1.0, 2.0], [3.0, 4.0]),
]


@pytest.mark.parametrize(("function", "x", "y"), FUNCTIONS)
def test_recordings_compute_the_same(function: Callable[[Any, Any], Any], x: list[float], y: list[float]) -> None:
    value = record.value_of(function(record.argument("x"), record.argument("y")))
    given = {"x": np.array(x), "y": np.array(y)}
    text = PythonPrinter().expression(value)
    with np.errstate(all="ignore"):
        found = eval(text, {"np": np, **given})
        wanted = function(given["x"], given["y"])
    np.testing.assert_allclose(found, wanted, rtol=2e-14)


def test_what_cannot_be_recorded_is_refused() -> None:
    x = record.argument("x")
    for use, other in ((math.exp, ()), (np.sum, ()), (np.add.reduce, ()), (np.heaviside, (0.5,))):
        with pytest.raises(NotRecordable):
            use(x, *other)
    for use in (lambda: x if x > 0.0 else -x, lambda: x * np.array([1.0, 2.0])):
        with pytest.raises(NotRecordable):
            use()


@pytest.mark.parametrize("name", data_names("oils"))
def test_laws_of_the_oil_cards_are_the_same_for_arrays(name: str) -> None:
    oil = Oil.load(name)
    temperature = np.array([-30.0, 15.0, 40.0, 65.0, 80.0, 100.0, 121.0, 190.0]) + 273.15
    pressure = np.geomspace(1e8, 4e9, temperature.size)
    found = conditions_of(gear_state(pressure_hertz=pressure, temperature_oil=temperature), oil)
    one_by_one = [lubricant_row(oil.at(t), p) for t, p in zip(temperature.tolist(), pressure.tolist(), strict=True)]
    for variable in LUBRICANT_UNITS:
        wanted = [row[variable] for row in one_by_one]
        np.testing.assert_allclose(found[variable], wanted, rtol=1e-12, err_msg=variable)


@pytest.mark.parametrize("family", FAMILIES)
def test_every_family_can_be_exported(family: str) -> None:
    form = FAMILIES[family]
    values = form.start or np.linspace(-0.3, 0.2, len(form.terms)).tolist()
    given = {"family": family, "equation": form.equation, "coefficients": dict(zip(form.terms, values, strict=True))}
    formula = Formula.model_validate(Formula.load("fva3_short").model_dump(by_alias=True) | given)
    program = program_of(formula)
    namespace: dict[str, Any] = {}
    exec(python_text(program, "friction"), namespace)
    rng = np.random.default_rng(3)
    table = {name: rng.uniform(*limits, 50) for name, limits in formula.ranges.items()}
    names = ("pressure_hertz", "radius_equivalent", "speed_entrainment", "temperature_oil")
    changes = {"slide_to_roll": table["slide_to_roll_total"], "roughness_rms_1": table["roughness_rms"]}
    state = gear_state(**{name: table[name] for name in names}, **changes, roughness_rms_2=0.0)
    wanted = formula.evaluate(conditions_of(state, Oil.load("fva3")))
    given = [np.asarray(getattr(state, name)) for name in program.arguments]
    mu, lower, upper, flag = namespace["friction"](*given)
    np.testing.assert_allclose([mu, lower, upper], [wanted.mu, wanted.lower, wanted.upper], rtol=1e-11)
    np.testing.assert_array_equal(flag, formula.mu(state, oil="fva3").flag)


PAGE = (Path(__file__).resolve().parents[3] / "docs" / "formula_code.md").read_text(encoding="utf-8")


def test_example_of_the_page(mixed_ehl: Callable[..., Any], tmp_path: Path) -> None:
    """The C program of docs/formula_code.md gives what `mixed-ehl mu` gives; its call fits the exported function."""
    assert mixed_ehl("export", "fva3_short", "-o", tmp_path / "friction.c").code == 0
    example = re.search(r"```c\n(.*?)```", PAGE, flags=re.DOTALL)
    call = re.search(r"= friction\((.*?)\);", example.group(1))
    given = [float(number) for number in call.group(1).split(",")]
    program = program_of(Formula.load("fva3_short"))
    assert len(given) == len(program.arguments)
    namespace: dict[str, Any] = {}
    exec(python_text(program, "friction"), namespace)
    mu, lower, upper, flag = namespace["friction"](*given)
    options = point_options(pressure="1.2 GPa", correlation_length="30 um")
    shown = mixed_ehl("mu", "fva3_short", *options, "--json")
    # the command takes E' of the steel card, the page a rounded one
    assert mu == pytest.approx(json.loads(shown.out)["friction_coefficient"], rel=1e-3)
    if shutil.which("gcc") is not None:
        (tmp_path / "main.c").write_text(example.group(1))
        subprocess.run(["gcc", "-O2", "main.c", "-o", "main", "-lm"], cwd=tmp_path, check=True, timeout=60)
        printed = subprocess.run([str(tmp_path / "main")], capture_output=True, text=True, check=True, timeout=60)
        assert printed.stdout == f"mu = {mu:.5f} ({lower:.5f} to {upper:.5f}), flag {flag}\n"
