"""Exported formulas give what the formula gives, to 1e-12: 1000 points in and beyond the range, in every language.

With a process, to the rounding of its sum as well.
"""

import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refuses
from scipy.stats import qmc

from ehl.common.arrays import FloatArray
from ehl.fluid.oil import Oil
from ehl.state import ContactState
from regression.export.printer import description
from regression.export.program import program_of
from regression.formula import Formula
from regression.friction.conditions import LUBRICANT_UNITS, conditions_of
from regression.friction.models import FrictionFlag
from regression.friction.oil_cards import OilIdentity

# ranges of the points far beyond those of a formula
FAR = {
    "pressure_hertz": (0.1e9, 4e9), "radius_equivalent": (2e-3, 0.2), "effective_modulus": (2.0e11, 2.4e11),
    "speed_entrainment": (0.1, 50.0), "slide_to_roll": (1e-4, 3.0), "speed_sliding_lengthwise": (1e-3, 5.0),
    "temperature_oil": (270.0, 450.0), "correlation_length": (10e-6, 100e-6), "peklenik_number": (0.1, 20.0),
    "roughness_rms": (0.01e-6, 3e-6),
}  # fmt: skip
WITHOUT_GUARD = " without guard"  # of a formula whose guard is left out


@cache
def points(name: str) -> dict[str, FloatArray]:
    """1000 points: 600 over the range of the formula, 400 far beyond it, some smooth, some without sliding."""
    ranges = formula_of(name).ranges
    unit = qmc.Sobol(len(FAR), seed=1).random(1024)[:1000]
    table = {name: low * (high / low) ** unit[:, column] for column, (name, (low, high)) in enumerate(FAR.items())}
    for column, variable in enumerate(FAR):
        low, high = ranges.get("slide_to_roll_total" if variable == "slide_to_roll" else variable, (0.0, 0.0))
        if low > 0.0:
            table[variable][:600] = low * (high / low) ** unit[:600, column]
    table["speed_sliding_lengthwise"][:600] = 0.0
    table["slide_to_roll"][::2] *= -1.0
    table["roughness_rms"][600::50] = 0.0
    table["slide_to_roll"][601::50] = table["speed_sliding_lengthwise"][601::50] = 0.0
    return table


def state(table: dict[str, FloatArray]) -> ContactState:
    single = table["roughness_rms"] / 2.0**0.5
    rest = {name: table[name] for name in FAR if name != "roughness_rms"}
    return ContactState.of(**rest, roughness_rms_1=single, roughness_rms_2=single)


@cache
def formula_of(name: str) -> Formula:
    formula = Formula.load(name.removesuffix(WITHOUT_GUARD))
    return formula.model_copy(update={"cloud": None}) if name.endswith(WITHOUT_GUARD) else formula


def expected(name: str) -> FloatArray:
    """mu, lower, upper, flag of the formula itself, shape (1000, 4)."""
    formula = formula_of(name)
    oil = Oil.load(formula.oils[0].name or "")
    found = formula.mu(state(points(name)), oil=oil)
    return np.column_stack([found.mu, found.lower, found.upper, found.flag])


def columns(arguments: Sequence[str], name: str) -> FloatArray:
    table = points(name)
    return np.column_stack([table[argument] for argument in arguments])


def agree(found: FloatArray, name: str) -> None:
    np.testing.assert_allclose(found, expected(name), rtol=1e-12)


NAMES = ("75w90", "80w90", "75w90_short")


def test_points_see_every_flag_a_formula_has() -> None:
    flags = expected("75w90")[:, 3]
    wanted = {FrictionFlag.OK, FrictionFlag.EXTRAPOLATED_NEAR, FrictionFlag.OUTSIDE_RANGE}
    assert wanted <= set(flags.astype(int).tolist())
    assert np.count_nonzero(flags == FrictionFlag.OK) > 50


PYTHON_MAIN = """
import sys
sys.path.insert(0, "")
import numpy as np
import friction
points = np.loadtxt("points.txt")
np.savetxt("found.txt", np.column_stack(friction.friction(*points.T)), fmt="%.17g")
assert not {"ehl", "regression", "efficiency", "scipy"} & set(sys.modules)
mu, lower, upper, flag = friction.friction(*map(float, points[0]))
assert type(float(mu)) is float and int(flag) == flag and lower < mu < upper
"""


@pytest.mark.parametrize("name", NAMES)
def test_python_in_a_process_without_this_program(name: str, tmp_path: Path) -> None:
    arguments = formula_of(name).export(tmp_path / "friction.py")
    np.savetxt(tmp_path / "points.txt", columns(arguments, name), fmt="%.17g")
    subprocess.run([sys.executable, "-I", "-c", PYTHON_MAIN], cwd=tmp_path, check=True, timeout=120)
    agree(np.loadtxt(tmp_path / "found.txt"), name)


C_MAIN = """#include <stdio.h>
#include "friction.c"
int main(void)
{
    static double a[1000][COUNT];
    static friction_point points[1000];
    static friction_result many[1000];
    for (int i = 0; i < 1000; i++) {
        for (int k = 0; k < COUNT; k++) if (scanf("%lf", a[i] + k) != 1) return 1;
        points[i] = (friction_point){ARGUMENTS};
    }
    /* blocks with a rest, and less than one block */
    friction_points(995, points, many);
    friction_points(5, points + 995, many + 995);
    for (int i = 0; i < 1000; i++) {
        friction_result r = friction(ARGUMENTS), s = many[i];
        printf("%.17g %.17g %.17g %d ", r.mu, r.lower, r.upper, r.flag);
        printf("%.17g %.17g %.17g %d\\n", s.mu, s.lower, s.upper, s.flag);
    }
    return 0;
}
"""
FORTRAN_MAIN = """program main
  use friction_formula, only: friction
  implicit none
  integer, parameter :: dp = kind(1.0d0)
  real(dp) :: a(COUNT), mu, lower, upper
  integer :: flag, status
  do
    read (*, *, iostat=status) a
    if (status /= 0) exit
    call friction(ARGUMENTS, mu, lower, upper, flag)
    print '(3es27.17e3,i4)', mu, lower, upper, flag
  end do
end program main
"""
C_WARNINGS = "-Wall -Wextra -Wconversion -pedantic -Werror"
C_COMMAND = f"gcc -std=c99 -O3 -fno-math-errno {C_WARNINGS} main.c -o main -lm"
FORTRAN_COMMAND = "gfortran -std=f2008 -O2 -Wall -Wextra -pedantic -Wno-compare-reals friction.f90 main.f90 -o main"
# file, main program, argument, its first index, command, longest line
LANGUAGES = {
    "c": ("friction.c", C_MAIN, "a[i][{}]", 0, C_COMMAND, 702),
    "fortran": ("friction.f90", FORTRAN_MAIN, "a({})", 1, FORTRAN_COMMAND, 132),
}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("language", LANGUAGES)
def test_compiled_languages(language: str, name: str, tmp_path: Path) -> None:
    file, main, argument, first, command, longest = LANGUAGES[language]
    arguments = formula_of(name).export(tmp_path / file)
    text = (tmp_path / file).read_text()
    assert len(text) < 150_000
    assert len(text.splitlines()) <= 400
    assert max(map(len, text.splitlines())) <= longest
    if shutil.which(command.split()[0]) is None:
        pytest.skip(f"{command.split()[0]} is not installed")
    passed = ", ".join(argument.format(i + first) for i in range(len(arguments)))
    source = tmp_path / f"main{Path(file).suffix}"
    source.write_text(main.replace("COUNT", str(len(arguments))).replace("ARGUMENTS", passed))
    subprocess.run(command.split(), cwd=tmp_path, check=True, timeout=120)
    given = "\n".join(" ".join(f"{x:.17g}" for x in row) for row in columns(arguments, name))
    found = subprocess.run([tmp_path / "main"], input=given, capture_output=True, text=True, check=True, timeout=120)
    for results in np.hsplit(np.loadtxt(found.stdout.splitlines()), 2 if language == "c" else 1):
        agree(results, name)


@pytest.mark.parametrize("name", NAMES)
def test_matlab_file_in_octave(name: str, tmp_path: Path) -> None:
    """Runs where octave is installed; anywhere the file holds as many functions as ends."""
    arguments = formula_of(name).export(tmp_path / "friction.m")
    text = (tmp_path / "friction.m").read_text()
    assert len(text.splitlines()) <= 400
    opened = re.findall(r"^\s*(?:function|if|for)\b", text, flags=re.MULTILINE)
    assert len(opened) == len(re.findall(r"^\s*end$", text, flags=re.MULTILINE))
    octave = shutil.which("octave-cli") or shutil.which("octave")
    if octave is None:
        pytest.skip("octave is not installed")
    np.savetxt(tmp_path / "points.txt", columns(arguments, name), fmt="%.17g")
    given = ", ".join(f"x(:, {i + 1})" for i in range(len(arguments)))
    script = (
        f"x = load('points.txt'); [mu, lower, upper, flag] = friction({given}); d = [mu lower upper flag];"
        "file = fopen('found.txt', 'w'); fprintf(file, '%.17g %.17g %.17g %d\\n', d'); fclose(file);"
    )
    subprocess.run([octave, "--norc", "--quiet", "--eval", script], cwd=tmp_path, check=False, timeout=300)
    agree(np.loadtxt(tmp_path / "found.txt"), name)


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_fmu_is_valid_and_gives_the_friction(kind: str, tmp_path: Path) -> None:
    """By the independent FMPy, which also checks the description of the model."""
    fmpy = pytest.importorskip("fmpy")
    from fmpy.validation import validate_fmu

    path, name = tmp_path / "friction.fmu", "75w90"
    arguments = formula_of(name).export(path)
    assert validate_fmu(str(path)) == []
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    given = np.rec.fromarrays([np.arange(1000.0), *columns(arguments, name).T], names=["time", *arguments])
    steps = {"start_time": 0.0, "stop_time": 1000.0, "step_size": 1.0, "output_interval": 1.0}
    outputs = ["mu", "lower", "upper", "flag"]
    found = fmpy.simulate_fmu(str(path), fmi_type=kind, input=given, output=outputs, **steps)
    # outputs of a co-simulation are those of the inputs of the step before
    first = 1 if kind == "CoSimulation" else 0
    agree(np.column_stack([found[output] for output in outputs])[first : first + 1000], name)
    # sources alone, without a warning
    source = Path(fmpy.extract(path, tmp_path / "unit")) / "sources" / "friction.c"
    options = ("-std=c99", *C_WARNINGS.split(), "-Wno-unused-parameter", "-DFMI2_FUNCTION_PREFIX=friction_")
    subprocess.run(["gcc", *options, "-c", source, "-o", tmp_path / "friction.o"], check=True)


@pytest.mark.parametrize("compiler", [None, "false"])
def test_fmu_without_a_compiler_contains_its_sources(
    compiler: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: compiler)
    formula_of("fva3_short").export(tmp_path / "friction.fmu")
    with zipfile.ZipFile(tmp_path / "friction.fmu") as unit:
        assert unit.namelist() == ["modelDescription.xml", "sources/friction.c"]
    assert "without a library" in caplog.text


def python_function(path: Path) -> Callable[..., Any]:
    namespace: dict[str, Any] = {}
    exec(path.read_text(), namespace)
    function: Callable[..., Any] = namespace["friction"]
    return function


def test_code_without_guard_is_short_and_oil_properties_may_be_arguments(tmp_path: Path) -> None:
    name, path = "75w90_short", tmp_path / "friction.py"
    arguments = formula_of(name).export(path, guard=False)
    assert len(path.read_text()) < 20_000
    agree(np.column_stack(python_function(path)(*columns(arguments, name).T)), name + WITHOUT_GUARD)
    arguments = formula_of(name).export(path, oil_arguments=True)
    assert {*arguments} & set(LUBRICANT_UNITS)
    table = conditions_of(state(points(name)), Oil.load("75w90"))
    agree(np.column_stack(python_function(path)(*(table[argument] for argument in arguments))), name)


def test_beyond_the_laws_of_the_oil_there_is_no_value(tmp_path: Path) -> None:
    arguments = formula_of("fva3_short").export(tmp_path / "friction.py")
    row = dict(zip(arguments, columns(arguments, "fva3_short")[0], strict=True))
    function = python_function(tmp_path / "friction.py")
    for temperature in (500.0, 200.0, np.nan):
        mu, lower, upper, flag = function(**{**row, "temperature_oil": temperature})
        assert np.isnan([mu, lower, upper]).all()
        assert flag == FrictionFlag.UNDEFINED


def test_formula_of_several_oils_asks_which(tmp_path: Path) -> None:
    both = formula_of("fva3_short").model_copy(update={"oils": (OilIdentity(name="fva3"), OilIdentity(name="75w90"))})
    assert program_of(both, oil="75W-90").oil == "75w90"
    heads = [description(program_of(formula_of(name)))[0] for name in ("75w90", "75w90_short")]
    assert ["networks" in head for head in heads] == [True, False]
    for oil in (None, "m100"):
        with refuses("oil"):
            both.export(tmp_path / "friction.c", oil=oil)
