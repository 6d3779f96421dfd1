"""Measured against computed, state by state: bias, standard deviation and share inside the 90 % interval.

    python validation/truth_table.py --rows validation/out/truth.csv             # 15 minutes on two cores
    python validation/truth_table.py --rows validation/out/truth.csv --table     # statistics of rows that were computed

In the manner of the validation guide of the NIST fire models. Nothing is fitted. Gear friction is that of a published
correlation of measured FZG friction with the oil factors of FEUP (`data/reference/measured/gears.toml`), known to 15 %.
That friction was found from measured loss with the loss factor of rigid teeth, which share the load in equal parts
where two pairs touch; the computed one is the computed loss over the same factor.
Bias: exp of the mean of ln(computed/measured), less 1; standard deviation: of that logarithm. Inside: measured in the
interval of the computed, widened by what the measurement is known to.
"""

from __future__ import annotations

import csv
import itertools
import math
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from common import command_line
from measured import films, measured, mu

import efficiency
import ehl
from efficiency.conditions.conditions import resolve_friction
from efficiency.loss.ehl_friction import EhlFriction
from ehl.common.data import data_path
from ehl.uncertainty.result import score_of

PAGE, MARKERS = Path("docs/validation_truth.md"), ("<!-- truth: begin -->", "<!-- truth: end -->")
GEARS, OILS = ("fzg_c14", "fzg_c40"), ("minr", "paor", "estr", "pagd", "p150")
TORQUES, SPEEDS, CELSIUS = (183.35, 302.0, 94.1), (1200.0, 200.0, 500.0, 2000.0), 80.0  # N m, rpm of the wheel, degC


@dataclass(frozen=True)
class State:
    """One state: what was measured and its relative standard deviation, what is computed with its 90 % interval."""

    quantity: str
    case: str
    oil: str
    torque: float
    speed: float
    measured: float
    measured_sd: float
    computed: float
    low: float
    high: float
    pressure: float
    film_ratio: float

    @property
    def inside(self) -> bool:
        """Whether the interval holds the measured value, both as wide as they are known."""
        wide = score_of(0.9) * self.measured_sd
        ends = [math.hypot(math.log(end / self.computed), wide) if end > 0.0 else wide for end in (self.low, self.high)]
        return -ends[0] <= math.log(self.measured / self.computed) <= ends[1]


def schlenk_feup(pair: Any, oil: str, torque: float, speed: float, celsius: float) -> float:
    """Mean friction coefficient by the correlation; `torque` and `speed` of the pinion [N m, rad/s]."""
    known = tomllib.loads(data_path("reference/measured", "gears.toml").read_text(encoding="utf-8"))["fzg_friction"]
    involute = pair.design.involute
    load = torque / involute.base[0] / (1e3 * involute.face_width)
    radius = 1e3 * math.prod(involute.tangent) / sum(involute.tangent) / math.cos(involute.base_helix)
    total = 2.0 * speed * involute.pitch[0] * math.sin(involute.working_angle)
    viscosity = 1e3 * float(ehl.Oil.load(oil).at(celsius + 273.15).viscosity_inlet)
    group = (load / (total * radius)) ** 0.2 * viscosity**-0.05
    return float(0.048 * group * known["ra_um"] ** 0.25 * known["oil_factor"][oil])


def rigid_loss_factor(pair: Any) -> float:
    """H_V of spur gears: loss over power and a constant friction coefficient, the load shared in equal parts [-].

    pi (u + 1)/(z_1 u) (1 - eps + eps_1^2 + eps_2^2) (Ohlendorf 1958, unverified; exact for contact ratios of 1 to 2).
    """
    involute = pair.design.involute
    ends = [
        (math.sqrt(tip**2 - base**2) - base * math.tan(involute.working_angle)) / involute.base_pitch
        for tip, base in zip(involute.tip, involute.base, strict=True)
    ]
    one, two = involute.teeth
    return math.pi * (one + two) / (one * two) * (1.0 - sum(ends) + sum(end**2 for end in ends))


def gear_states(model: str, points: int, jobs: int | None) -> Iterator[State]:
    """Mean mesh friction of the FZG gears over oils, loads and speeds."""
    sd = tomllib.loads(data_path("reference/measured", "gears.toml").read_text(encoding="utf-8"))["fzg_friction"]["sd"]
    meshes = {name: efficiency.load(name).mesh(positions=12, points_per_line=5) for name in GEARS}
    # the middle of the field first, so that a part of the rows says something already
    for speed, torque, name, oil in itertools.product(SPEEDS, TORQUES, GEARS, OILS):
        pair, loaded = efficiency.load(name), meshes[name].load(torque)
        friction = resolve_friction(model, pair.design)
        if isinstance(friction, EhlFriction):
            friction = replace(friction, points=points, tolerance=0.0, jobs=jobs)
        omega = 1.5 * speed * math.pi / 30.0
        result = loaded.efficiency(friction, oil=oil, speed=omega, temperature=CELSIUS + 273.15)
        lost = 1.0 - result.efficiency
        found = lost / rigid_loss_factor(pair)
        low, high = ((1.0 - end) / lost * found for end in (result.efficiency_upper, result.efficiency_lower))
        ratio = float(np.median(result.lubrication.film_ratio))
        reference = schlenk_feup(pair, oil, torque, omega, CELSIUS)
        yield State("mean mesh friction", name, oil, torque, omega, reference, sd, found, low, high,
                    result.pressure_hertz_max, ratio)  # fmt: skip


def bearing_states() -> Iterator[State]:
    """Saturated traction of five oils in thrust ball bearings, at 1.5 GPa, 80 degC, 2 m/s and slip 0.1 (our choice)."""
    given = measured("ball_bearing_traction")
    for oil in OILS:
        contact = ehl.Contact(
            oil=oil, temperature=353.15, pressure_hertz=1.5e9, radius_equivalent=9.5e-3, speed_entrainment=2.0,
            slide_to_roll=0.1,
        )  # fmt: skip
        interval = contact.uncertainty(jobs=1)
        yield State("full-film traction", "thrust ball bearing", oil, 0.0, 2.0, given[oil], 0.10, interval.value,
                    interval.low, interval.high, 1.5e9, math.inf)  # fmt: skip


def film_states() -> Iterator[State]:
    """Films of a ball on glass, mean of each series, between the temperatures of probe and reservoir."""
    for row in films()[0]:
        middle = math.sqrt(row.computed_low * row.computed_high)
        oil = row.remark.split()[1].rstrip(",;")
        yield State("film", row.quantity, oil, 0.0, math.nan, row.measured_low, 0.10, middle, row.computed_low,
                    row.computed_high, 0.5e9, math.inf)  # fmt: skip


def disc_states() -> Iterator[State]:
    """Mineral oils on twin discs and in gears: one published mean."""
    given = measured("gear_oil_family")["mineral"]
    at = itertools.product(("fva3", "minr"), (0.8, 1.2), (60.0, 90.0), (2.0, 8.0))
    found = [mu(oil, t, p, 20.0, u, 0.2) for oil, p, t, u in at]
    yield State("full-film traction", "twin discs, mean", "fva3, minr", 0.0, math.nan, given, 0.10,
                float(np.mean(found)), min(found), max(found), 1.0e9, math.inf)  # fmt: skip


def statistics(states: Sequence[State]) -> dict[str, float]:
    """Number, bias, standard deviation and share inside the interval."""
    ratio = np.log([s.computed / s.measured for s in states])
    spread = float(ratio.std(ddof=1)) if ratio.size > 1 else math.nan
    return {
        "states": ratio.size,
        "bias": math.exp(float(ratio.mean())) - 1.0,
        "deviation": spread,
        "inside": float(np.mean([s.inside for s in states])),
    }


def exponents(states: Sequence[State]) -> dict[str, tuple[float, float, float]]:
    """Exponents of computed friction over load and over speed: least, mean, greatest over the series."""
    found = {}
    for name, held in (("torque", "speed"), ("speed", "torque")):
        slopes = []
        series: dict[Any, list[State]] = {}
        for s in states:
            series.setdefault((s.case, s.oil, getattr(s, held)), []).append(s)
        for group in series.values():
            if len(group) >= 2:
                x, y = (np.log([getattr(s, n) for s in group]) for n in (name, "computed"))
                slopes.append(float(np.polyfit(x, y, 1)[0]))
        if slopes:
            found[name] = min(slopes), float(np.mean(slopes)), max(slopes)
    return found


def page(states: Sequence[State]) -> str:
    """The tables of the page."""
    lines = ["| quantity | states | bias | standard deviation | inside the 90 % interval |", "|---|---|---|---|---|"]
    groups: dict[str, list[State]] = {}
    for s in states:
        groups.setdefault(s.quantity, []).append(s)
        if s.quantity == "mean mesh friction":
            groups.setdefault(f"- {s.oil}", []).append(s)
            groups.setdefault(f"- {s.case}", []).append(s)
    for name, group in groups.items():
        f = statistics(group)
        lines.append(
            f"| {name} | {f['states']:.0f} | {100 * f['bias']:+.0f} % | {100 * f['deviation']:.0f} % | "
            f"{100 * f['inside']:.0f} % |"
        )
    gears = groups.get("mean mesh friction", [])
    lines += ["", "| exponent of mesh friction over | least | mean | greatest | correlation |", "|---|---|---|---|---|"]
    for name, (least, mean, most) in exponents(gears).items():
        lines.append(
            f"| {name} | {least:+.2f} | {mean:+.2f} | {most:+.2f} | {'+0.20' if name == 'torque' else '-0.20'} |"
        )
    return "\n".join(lines)


def write_page(states: Sequence[State]) -> None:
    """The tables between the markers of the page."""
    text = PAGE.read_text(encoding="utf-8")
    start, end = (text.index(marker) for marker in MARKERS)
    PAGE.write_text(text[: start + len(MARKERS[0])] + "\n" + page(states) + "\n" + text[end:], encoding="utf-8")


def read_rows(path: Path) -> list[State]:
    """States of a file of rows."""
    words = ("quantity", "case", "oil")
    with path.open(encoding="utf-8", newline="") as file:
        return [State(**{k: v if k in words else float(v) for k, v in row.items()}) for row in csv.DictReader(file)]


def main(argv: Sequence[str] | None = None) -> None:
    """Rows of all states, and the page made of them."""
    parser = command_line(__doc__)
    parser.add_argument("--rows", type=Path, default=Path("validation/out/truth.csv"))
    parser.add_argument("--model", default="ehl", help="friction model of the gears")
    parser.add_argument("--points", type=int, default=24, help="contacts solved for each gear state")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--table", action="store_true", help="only the page, of rows that were computed")
    options = parser.parse_args(argv)
    if not options.table:
        options.rows.parent.mkdir(parents=True, exist_ok=True)
        with options.rows.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, [f.name for f in fields(State)])
            writer.writeheader()
            gears = gear_states(options.model, options.points, options.jobs)
            for state in itertools.chain(bearing_states(), film_states(), disc_states(), gears):
                writer.writerow(asdict(state))
                file.flush()
    states = [state for state in read_rows(options.rows) if math.isfinite(state.computed)]
    write_page(states)
    print(page(states))


if __name__ == "__main__":
    main()
