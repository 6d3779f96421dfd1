"""A formula as a LaTeX document: its equations in the order of the computation, coefficients, range, errors."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import ClassVar

from regression.export.printer import ATOM, COMPARE, POWER, PRODUCT, Printer, description
from regression.export.program import Program, reached
from regression.export.record import Value
from regression.friction.conditions import UNITS

SYMBOLS: dict[str, str] = {
    "pressure_hertz": r"p_{\mathrm{H}}",
    "radius_equivalent": "R",
    "effective_modulus": "E'",
    "speed_entrainment": r"u_{\mathrm{r}}",
    "slide_to_roll": "S_x",
    "speed_sliding_lengthwise": "v_y",
    "temperature_oil": "T",
    "correlation_length": r"l_{\mathrm{c}}",
    "peklenik_number": r"\gamma",
    "roughness_rms": "R_q",
    "viscosity_inlet": r"\eta_0",
    "viscosity_kinematic": r"\nu",
    "viscosity_mean_pressure": r"\eta_p",
    "pressure_viscosity": r"\alpha",
    "pressure_viscosity_film": r"\alpha_f",
    "eyring_stress": r"\tau_0",
    "limiting_shear_coefficient": r"\Lambda",
    "temperature_viscosity": r"\beta",
    "thermal_conductivity": r"k_{\mathrm{oil}}",
    "load_per_length": "w'",
    "half_width": "b",
    "speed_sum": r"u_{\Sigma}",
    "speed_sliding": r"v_{\mathrm{s}}",
    "slide_to_roll_total": "S",
    "film_formula": "h_0",
    "film_ratio_formula": r"\lambda",
    "boundary_friction": r"\mu_{\mathrm{b}}",
    "friction": r"\mu",
}
_COMPARED = {"less": "<", "less_equal": r"\le", "greater": ">", "greater_equal": r"\ge"}


class LatexPrinter(Printer):
    """Mathematics that LaTeX and the smaller mathtext of matplotlib both set."""

    functions: ClassVar[Mapping[str, str]] = {
        **{name: rf"\{name}" for name in ("exp", "sin", "cos", "tan", "sinh", "cosh", "tanh", "arctan")},
        "log": r"\ln",
        "log10": r"\lg",
        "maximum": r"\max",
        "minimum": r"\min",
        "arcsinh": r"\operatorname{arsinh}",
        "arctanh": r"\operatorname{artanh}",
        "erf": r"\operatorname{erf}",
        "erfc": r"\operatorname{erfc}",
        "choose": r"\operatorname{if}",
    }
    times = r" \, "
    both, either, opposite = r" \wedge ", r" \vee ", r"\neg "
    infinite, undefined = r"\infty", r"\mathrm{NaN}"

    def variable(self, name: str) -> str:
        """Its symbol; without one its name, set upright."""
        if name in SYMBOLS:
            return SYMBOLS[name]
        if name.startswith("k_"):
            return rf"c_{{\mathrm{{{_escaped(name[2:])}}}}}"
        return rf"\mathrm{{{_escaped(name)}}}"

    def number(self, number: float) -> str:
        """Digits, with powers of ten as such."""
        if math.isinf(number) or math.isnan(number):
            return super().number(number)
        text = f"{number:.10g}"
        mantissa, _, exponent = text.partition("e")
        if not exponent:
            return text
        return rf"{mantissa} \times 10^{{{int(exponent)}}}" if mantissa != "1" else rf"10^{{{int(exponent)}}}"

    def function(self, name: str, arguments: Sequence[str]) -> str:
        """A call with growing brackets; roots and absolute values by their signs."""
        if name == "sqrt":
            return rf"\sqrt{{{arguments[0]}}}"
        if name == "absolute":
            return rf"\left| {arguments[0]} \right|"
        return rf"{self.functions.get(name, name)} \left( {', '.join(arguments)} \right)"

    def power(self, base: tuple[str, int], exponent: tuple[str, int]) -> tuple[str, int]:
        """Raised exponents; a base with an exponent or bracket of its own is enclosed."""
        right = re.sub(r"^\((-[^()]*)\)$", r"\1", exponent[0])
        enclosed = base[1] < ATOM or not re.fullmatch(r"[\w.']+|\\[a-z]+|(?:\\mathrm|[a-z]_)\{[^{}]*\}", base[0])
        left = rf"\left( {base[0]} \right)" if enclosed else base[0]
        return f"{left}^{{{right}}}", POWER

    def comparison(self, operation: str, left: str, right: str) -> tuple[str, int]:
        """The sign of the comparison."""
        return f"{left} {_COMPARED[operation]} {right}", COMPARE

    @staticmethod
    def _enclosed(part: tuple[str, int], level: int) -> str:
        text, own = part
        return text if own >= level else rf"\left( {text} \right)"

    def _text(self, value: Value, named: bool = True) -> tuple[str, int]:
        if value.operation == "divide" and not (named and value.name):
            above, below = (self._text(operand)[0] for operand in value.operands)
            return rf"\frac{{{above}}}{{{below}}}", PRODUCT
        if value.operation == "constant" and r"\times" in self.number(value.number):
            text = self.number(value.number)
            return (rf"\left( {text} \right)" if text.startswith("-") else text), PRODUCT
        if value.operation == "multiply" and not (named and value.name) and value.operands[1].operation == "constant":
            # two numbers side by side would read as one
            parts = [self._enclosed(self._text(operand), PRODUCT) for operand in value.operands]
            return r" \cdot ".join(parts), PRODUCT
        return super()._text(value, named)


def _escaped(name: str) -> str:
    return name.replace("_", r"\_")


def equations(program: Program) -> list[tuple[str, str]]:
    """Symbol and expression of every step that mu needs, in the order of the computation."""
    printer = LatexPrinter()
    mu = next(step for step in program.steps if step.name == "mu")
    # mu = friction times the ramp at little sliding, where there is a value
    ramped = mu.operands[1]
    friction = ramped if ramped.name else ramped.operands[0]
    needed = reached((friction,))
    lines = [(printer.variable(step.name), printer.expression(step)) for step in program.steps if step in needed]
    return [*lines[:-1], (SYMBOLS["friction"], lines[-1][1])]


def latex_text(program: Program, name: str) -> str:
    """A document that compiles by itself; its body can be taken over into another one."""
    printer = LatexPrinter()
    formula = program.formula
    least = formula.ranges.get("slide_to_roll_total", (0.0, 0.0))[0]
    title, *about = (line for line in description(program)[:4])
    lines = [
        rf"% {name}",
        r"\documentclass{article}",
        r"\usepackage{amsmath,booktabs,geometry}",
        r"\allowdisplaybreaks",
        r"\begin{document}",
        rf"\section*{{{_plain(title)}}}",
        *(_plain(line) + "\n" for line in about),
        r"SI units. In the order of the computation:",
        r"\begin{gather*}",
    ]
    lines += [" \\\\\n".join(f"{symbol} = {expression}" for symbol, expression in equations(program))]
    lines += [r"\end{gather*}"]
    if least > 0.0:
        lines += [
            f"Below the least sliding of the data, $S_0 = {printer.number(least)}$, "
            "$\\mu(S) = \\mu(S_0) \\, S / S_0$.\n"
        ]
    rows = [
        (f"${printer.variable(a.name)}$", _plain(f"{a.name}: {a.meaning}"), _plain(a.unit or "-"))
        for a in program.arguments
    ]
    lines += _table(("symbol", "argument", "unit"), rows)
    lines += _table(
        ("coefficient", "value"), [(f"${printer.variable(c.name)}$", f"{c.number!r}") for c in program.coefficients]
    )
    ranges = [
        (_plain(variable), f"{low:.6g}", f"{high:.6g}", _plain(UNITS[variable] or "-"))
        for variable, (low, high) in formula.ranges.items()
    ]
    lines += _table(("range of", "from", "to", "unit"), ranges)
    widths = [
        (f"{band.low:g}", "" if band.high is None else f"{band.high:g}", f"{math.exp(band.log_width):.4f}")
        for band in formula.interval.bands
    ]
    if widths and not formula.interval.normalised:
        lines += [
            f"Interval of {100.0 * formula.interval.level:g} \\%: $\\mu$ over and times the factor of its band.\n"
        ]
        lines += _table((r"$\lambda$ from", "to", "factor"), widths)
    return "\n".join([*lines, r"\end{document}", ""])


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    body = [" & ".join(row) + r" \\" for row in rows]
    columns = "l" * len(header)
    return [
        rf"\begin{{center}}\begin{{tabular}}{{{columns}}}",
        r"\toprule",
        " & ".join(header) + r" \\",
        r"\midrule",
        *body,
        r"\bottomrule",
        r"\end{tabular}\end{center}",
        "",
    ]


def _plain(text: str) -> str:
    """Text with the characters LaTeX gives a meaning to."""
    for sign, escaped in (
        ("\\", r"\textbackslash "),
        ("_", r"\_"),
        ("%", r"\%"),
        ("&", r"\&"),
        ("#", r"\#"),
        ("$", r"\$"),
    ):
        text = text.replace(sign, escaped)
    return text.replace("^", r"\^{}").replace("~", r"\~{}")
