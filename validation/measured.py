"""What others measured against what the program computes with its defaults: nothing is tuned.

``python validation/measured.py [--out docs/figures] [--page docs/validation_measured.md]``

The measured values are in data/reference/measured. One table goes to validation/out/measured.csv, with a remark for
each row, and between the markers of the page; the figures go to the folder. A point contact is computed as the line
contact of the same radius and the same mean pressure; its film also by the point formula of Hamrock & Dowson, which
tests the oil card and not the solver.
"""

from __future__ import annotations

import csv
import math
import tomllib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import numpy as np
from common import OUT, command_line, write_rows
from measured_figures import draw_film, draw_low_slip, draw_oils
from roughness_effects import lay, over_smooth

import ehl
from ehl.common.data import data_path
from ehl.fluid.lubricant import Lubricant
from ehl.inputs import SurfaceInput
from ehl.material import effective_modulus

KELVIN = 273.15
MEAN_POINT, MEAN_LINE = 2.0 / 3.0, math.pi / 4.0  # mean over largest Hertz pressure
BALL_RADIUS = 19.05e-3 / 2.0
STEEL = {"youngs_modulus": 210e9, "poisson_ratio": 0.3}
GLASS = {
    "youngs_modulus": 70e9, "poisson_ratio": 0.21,
    "thermal_conductivity": 1.0, "heat_capacity": 800.0, "density": 2500.0,
}  # fmt: skip
RQ_OVER_RA = math.sqrt(math.pi / 2.0)  # of Gaussian heights
MARKERS = ("<!-- measured: begin -->", "<!-- measured: end -->")


@dataclass(frozen=True)
class Row:
    """One measured number or range and the computed one."""

    case: str
    quantity: str
    unit: str
    measured_low: float
    measured_high: float
    computed_low: float
    computed_high: float
    mark: str
    remark: str

    @property
    def deviation(self) -> float:
        """Computed over measured, middle by middle, less one."""
        return (self.computed_low + self.computed_high) / (self.measured_low + self.measured_high) - 1.0


def measured(name: str) -> dict[str, Any]:
    """One entry of ranges.toml."""
    with data_path("reference/measured", "ranges.toml").open("rb") as file:
        found: dict[str, Any] = tomllib.load(file)[name]
    return found


def columns(name: str) -> dict[str, list[str]]:
    """A measured CSV file by columns."""
    with data_path("reference/measured", name).open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {key: [row[key] for row in rows] for key in rows[0]}


def mu(oil: str, temperature: float, pressure: float, radius: float, speed: float, slip: float, **more: Any) -> float:
    """Friction coefficient of one contact; temperature in degC, pressure in GPa, radius in mm."""
    contact = ehl.Contact(
        oil=oil, temperature=temperature + KELVIN, pressure_hertz=1e9 * pressure, radius_equivalent=1e-3 * radius,
        speed_entrainment=speed, slide_to_roll=slip, **more,
    )  # fmt: skip
    return solved(contact).friction_coefficient


def solved(contact: ehl.Contact) -> ehl.ContactResult:
    """The result; one that failed stops the benchmark."""
    result = contact.solve()
    if result.status == "failed":
        raise RuntimeError(f"{contact}: {result.reason}")
    return result


def spread(values: Iterable[float]) -> tuple[float, float]:
    """Least and greatest."""
    found = list(values)
    return min(found), max(found)


# --- films ---------------------------------------------------------------------------------------------------------


def hamrock_dowson_1977(oil: Lubricant, speed: float, load: float, radius: float, modulus: float) -> float:
    """Central film of a circular point contact [m]: H = 2.69 U^0.67 G^0.53 W^-0.067 (1 - 0.61 exp(-0.73)).

    U = eta0 u/(E'R), G = alpha_film E', W = w/(E'R^2) with our E' (twice the reduced modulus).
    """
    group = oil.viscosity_inlet * speed / (modulus * radius)
    load_group, material = load / (modulus * radius**2), oil.pressure_viscosity_film * modulus
    return radius * 2.69 * group**0.67 * material**0.53 * load_group**-0.067 * (1.0 - 0.61 * math.exp(-0.73))


def point_pressure(load: float, radius: float, modulus: float) -> float:
    """Largest Hertz pressure of a ball on a plane [Pa]."""
    half_width = (3.0 * load * radius / modulus) ** (1.0 / 3.0)
    return 1.5 * load / (math.pi * half_width**2)


def line_film(card: str, temperature: float, speed: float, load: float) -> float:
    """Central film of the solver in the line contact of the same radius and mean pressure [m]: no oil leaks aside."""
    modulus = effective_modulus(ehl.Material(**STEEL), ehl.Material(**GLASS))
    pressure = point_pressure(load, BALL_RADIUS, modulus) * MEAN_POINT / MEAN_LINE
    contact = ehl.Contact(
        oil=card, temperature=temperature + KELVIN, pressure_hertz=pressure, radius_equivalent=BALL_RADIUS,
        speed_entrainment=speed, slide_to_roll=0.0, solid_1=STEEL, solid_2=GLASS,
    )  # fmt: skip
    return solved(contact).film_central


def films() -> tuple[list[Row], list[dict[str, Any]]]:
    """Films of a ball on glass, series by series: means over the speeds, at probe and reservoir temperature."""
    data = columns("film_ball_on_disc.csv")
    modulus = effective_modulus(ehl.Material(**STEEL), ehl.Material(**GLASS))
    rows, curves = [], []
    names = list(dict.fromkeys(data["series"]))
    for name in names:
        at = [i for i, series in enumerate(data["series"]) if series == name]
        probe, reservoir, load, speed, film = (
            np.array([float(data[key][i]) for i in at])
            for key in (
                "temperature_oil_degC", "temperature_reservoir_degC", "load_N", "speed_entrainment_m_s", "film_nm",
            )
        )  # fmt: skip
        card = data["card"][at[0]]
        computed = [
            np.array(
                [
                    1e9 * hamrock_dowson_1977(ehl.Oil.load(card).at(t + KELVIN), u, w, BALL_RADIUS, modulus)
                    for t, u, w in zip(temperature, speed, load, strict=True)
                ]
            )
            for temperature in (probe, reservoir)
        ]
        some = range(0, len(at), 3)
        line = [1e9 * line_film(card, probe[i], speed[i], load[i]) for i in some]
        curves.append(
            {"name": name, "speed": speed, "film": film, "computed": computed, "line": (speed[list(some)], line)}
        )
        means = [float(np.exp(np.mean(np.log(values)))) for values in (film, *computed)]
        scatter = float(np.std(np.log(film / computed[0])))
        ratio = float(np.exp(np.mean(np.log(np.array(line) / computed[0][list(some)]))))
        remark = (
            f"card {card}; point formula, at reservoir and probe temperature; scatter {100 * scatter:.0f} %; "
            f"solver's line contact {ratio:.2f} times the formula"
        )
        low, high = spread(means[1:])
        rows.append(Row("film", f"central film, {name}", "nm", means[0], means[0], low, high, "read", remark))
    return rows, curves


# --- friction in full film -----------------------------------------------------------------------------------------


def low_slip() -> tuple[list[Row], dict[str, Any]]:
    """Friction over slip at 3.5 GPa in the shape mu(SRR)/mu(20 %), oils of several families in place of the unknown."""
    data = columns("traction_low_slip.csv")
    slip = [float(v) for v in data["slide_to_roll"]]
    found = [float(v) for v in data["friction_coefficient"]]
    pressure = 3.5 * MEAN_POINT / MEAN_LINE
    cards = ("fva3", "minr", "paor", "75w90")
    slips = tuple(slip)
    curves = {card: [mu(card, 40.0, pressure, 1e3 * BALL_RADIUS, 0.025, s) for s in slips] for card in cards}
    ratios = [values[0] / values[-1] for values in curves.values()]
    ratio = found[0] / found[-1]
    cards_named = ", ".join(cards)
    gear = [mu("75w90", 80.0, 1.25, 15.0, 5.0, s) for s in (slip[0], slip[-1])]
    rows = [
        Row("low slip", "mu at 1 % over mu at 20 % slip, 3.5 GPa", "", ratio, ratio, *spread(ratios), "secondary",
            f"0.025 m/s, 40 degC; oil unknown, cards {cards_named}"),
        Row("low slip", "mu at 1 % over mu at 20 % slip, gear contact", "", ratio, ratio, *[gear[0] / gear[1]] * 2,
            "secondary", "shape only: 75w90 at 1.25 GPa, 5 m/s, 80 degC, compared with the ball at 3.5 GPa"),
        Row("low slip", "mu at 20 % slip, 3.5 GPa", "", found[-1], found[-1], *spread(v[-1] for v in curves.values()),
            "secondary", "size only: the oil is unknown"),
    ]  # fmt: skip
    return rows, {"slip": slip, "measured": found, "computed": curves, "slips": slips}


def bearing_oils() -> tuple[list[Row], dict[str, Any]]:
    """Friction of four VG 320 oils over that of the mineral one, where a short roller slips on a flat washer."""
    given = measured("bearing_oil_ratio")
    states = list(product((0.6, 1.0), (60.0, 80.0), (2.0,), (0.03, 0.12)))
    oils = ("minr", "paor", "estr", "pagd")
    found = {oil: np.array([mu(oil, t, p, 5.0, u, s) for p, t, u, s in states]) for oil in oils}
    rows = [
        Row("oil family", f"{oil}/minr, roller thrust bearing", "", given["roller"][oil], given["roller"][oil],
            *spread(found[oil] / found["minr"]), given["mark"],
            f"mean {np.mean(found[oil] / found['minr']):.2f}; {len(states)} states, 0.6-1 GPa, 60-80 degC, slip 3-12 %")
        for oil in oils[1:]
    ]  # fmt: skip
    ratios = {oil: found[oil] / found["minr"] for oil in oils[1:]}
    return rows, {"given": given, "computed": ratios}


def family_order() -> list[Row]:
    """Naphthenic, paraffinic, PAO, ester, polyglycol at equal state, each over the next: 1 or more is the order."""
    states = list(product((0.8, 1.2), (60.0, 90.0), (2.0,), (0.05, 0.2)))
    # of one viscosity grade each
    chains = (("n100", "m100", "pao100"), ("minr", "paor", "estr", "pagd"))
    mean = {oil: np.array([mu(oil, t, p, 10.0, u, s) for p, t, u, s in states]) for oil in sum(chains, ())}
    return [
        Row("oil family", f"{first}/{second} at equal state", "", 1.0, math.inf, *spread(mean[first] / mean[second]),
            "secondary", "published order: naphthenic > paraffinic > PAO >= ester > polyglycol")
        for chain in chains
        for first, second in pairwise(chain)
    ]  # fmt: skip


def gear_oils() -> list[Row]:
    """Twin discs of a gear laboratory: size of mineral friction, ester and polyglycol over it."""
    given = measured("gear_oil_family")
    states = list(product((0.8, 1.2), (60.0, 90.0), (2.0, 8.0), (0.2,)))
    mean = {
        oil: np.array([mu(oil, t, p, 20.0, u, s) for p, t, u, s in states]) for oil in ("fva3", "minr", "estr", "pagd")
    }
    mineral = np.concatenate((mean["fva3"], mean["minr"]))
    at = "radius 20 mm, 0.8 and 1.2 GPa, 60 and 90 degC, 2 and 8 m/s, slip 20 %, smooth"
    rows = [
        Row("oil family", "mu of mineral oils, twin disc and gears", "", given["mineral"], given["mineral"],
            *spread(mineral), given["mark"], f"fva3 and minr, mean {mineral.mean():.3f}; {at}")
    ]  # fmt: skip
    for family, oil in (("ester", "estr"), ("polyglycol", "pagd")):
        low, high = given["twin_disc_ratio"][family]
        rows.append(
            Row("oil family", f"{family}/mineral, twin disc", "", low, high, *spread(mean[oil] / mean["minr"]),
                given["mark"], f"{oil}/minr at the same states; in gears {given['gear_ratio'][family][0]} to 1")
        )  # fmt: skip
    return rows


# --- rough contacts ------------------------------------------------------------------------------------------------


def superfinished() -> list[Row]:
    """Ground against superfinished teeth in a gas turbine oil."""
    given, oil = measured("superfinished_gears"), measured("alpha_turbine_ester")
    finishes = [1e-6 * RQ_OVER_RA * given[name] for name in ("ra_ground_um", "ra_superfinished_um")]
    # the oil by its numbers at 90 degC
    inverse = 1.0 / (90.0 + KELVIN) - 1.0 / 311.1
    viscosity = oil["viscosity_Pa_s"] * math.exp(3609.6 * inverse + 7.7657e5 * inverse**2)
    alpha = math.exp(1.15607 * math.log(viscosity) - 17.496) / viscosity
    ratios, films = [], []
    for speed in (5.0, 15.0):
        contact = ehl.Contact(
            viscosity_inlet=viscosity, pressure_viscosity=alpha, temperature_oil=90.0 + KELVIN, pressure_hertz=1e9,
            radius_equivalent=15e-3, speed_entrainment=speed, slide_to_roll=0.3, accuracy="fast",
        )  # fmt: skip
        ground, fine = (
            solved(contact.replace(roughness_rms_1=rq, roughness_rms_2=rq, **waves(name)))
            for rq, name in zip(finishes, ("ground", "superfinished"), strict=True)
        )
        ratios.append(fine.friction_coefficient / ground.friction_coefficient)
        films.append(ground.film_ratio)
    remark = f"Rq 0.50 and 0.06 um, 1 GPa, 90 degC, 5 and 15 m/s, slip 0.3; film ratio as ground {films[0]:.2f}, "
    return [
        Row("finish", "superfinished/ground", "", given["friction_ratio"], given["friction_ratio"],
            *spread(ratios), given["mark"], remark + f"{films[1]:.2f}; loads and speeds of the rig not readable")
    ]  # fmt: skip


def waves(name: str) -> dict[str, float]:
    """Correlation length, lay and skewness of a finish that has run in."""
    card = ehl.Finish.load(name, "run_in")
    return {
        "correlation_length": card.correlation_length.value, "peklenik_number": card.lay_ratio.value,
        "skewness": card.skewness.value,
    }  # fmt: skip


def thick_film() -> list[Row]:
    """No gain of a finer finish where the film ratio is 2."""
    given = measured("superfinished_thick_film")
    contact = ehl.Contact(
        oil="fva3", temperature=60.0 + KELVIN, pressure_hertz=1e9, radius_equivalent=20e-3, speed_entrainment=15.0,
        slide_to_roll=0.2, accuracy="fast",
    )  # fmt: skip
    film = solved(contact).film_central
    rough = solved(contact.replace(roughness_rms=film / given["film_ratio"], **waves("ground")))
    fine = solved(contact.replace(roughness_rms=film / given["film_ratio"] / 5.0, **waves("superfinished")))
    ratio = fine.friction_coefficient / rough.friction_coefficient
    return [
        Row("finish", "finer/ground finish at film ratio 2", "", given["friction_ratio"], given["friction_ratio"],
            ratio, ratio, given["mark"], f"fva3, 60 degC; Rq {1e6 * film / given['film_ratio']:.2f} um and a fifth")
    ]  # fmt: skip


def marks_and_films() -> list[Row]:
    """Direction of the grinding marks, and rough over smooth contacts in mixed and full film."""
    given, direction = measured("roughness_over_smooth"), measured("grinding_direction")
    remark = "1 GPa, 80 degC, 2 m/s, slip 0.5, isotropic"
    rows = [
        Row("finish", "marks along/across the motion, discs", "", *[direction["friction_ratio"]] * 2,
            *spread(row["along"] / row["across"] for row in lay()), direction["mark"],
            "fva3 and 75w90, 1 GPa, 80 degC, slip 0.2, film ratio 0.5 to 3.1; states of the rig not readable")
    ]  # fmt: skip
    for family, oil, low, high in (("mineral oil", "minr", 1.0, math.inf), ("PAO", "paor", 1.0, math.inf),
                                   ("polyglycol", "pagd", 0.0, 1.0)):  # fmt: skip
        ratios = [row["over_smooth"] for row in over_smooth((oil,), (None,))]
        quantity = f"rough/smooth at film ratio 0.5 to 3.5, {family}"
        rows.append(Row("finish", quantity, "", low, high, *spread(ratios), given["mark"], remark))
    return rows


def boundary() -> list[Row]:
    """Default boundary friction, and how friction grows with a thicker boundary film."""
    default = SurfaceInput().boundary_friction
    given, zddp = measured("boundary_friction"), measured("boundary_friction_zddp")
    sources = (
        ("FZG gears, upper limit", given["fzg_gears"], given["mark"]),
        ("roller contact", given["roller_contact"], given["mark"]),
        ("pin on disc", given["pin_on_disc"], given["mark"]),
        ("ZDDP tribofilms, rolling and sliding", zddp["rolling_sliding"], zddp["mark"]),
        ("base oil on a tribofilm", zddp["base_oil_on_tribofilm"], zddp["mark"]),
    )
    rows = [
        Row("boundary", f"mu_b, {name}", "", *limits, default, default, mark, "computed: the default of every contact")
        for name, limits, mark in sources
    ]
    grown = measured("tribofilm_growth")
    ratios = []
    for speed in (0.5, 1.5):
        contact = ehl.Contact(
            oil="fva3", temperature=120.0 + KELVIN, pressure_hertz=1e9, radius_equivalent=BALL_RADIUS,
            speed_entrainment=speed, slide_to_roll=1.0, roughness_rms=0.1e-6, accuracy="fast",
        )  # fmt: skip
        thin, thick = (solved(contact.replace(boundary_film=film)).friction_coefficient for film in (10e-9, 60e-9))
        ratios.append(thick / thin)
    ratio = grown["friction_after"] / grown["friction_before"]
    rows.append(
        Row("boundary", "mu after over before a tribofilm grew", "", ratio, ratio, *spread(ratios), grown["mark"],
            "boundary film 10 to 60 nm, fva3, 1 GPa, Rq 0.1 um, 0.5 and 1.5 m/s; oil, load, finish unknown")
    )  # fmt: skip
    return rows


# --- oil under pressure, gears -------------------------------------------------------------------------------------


def secant_and_slope(card: ehl.Oil, temperature: float) -> tuple[float, float]:
    """ln(eta/eta0)/p at 0.2 GPa and at p = 0 [1/GPa]; temperature in degC."""
    oil = card.at(temperature + KELVIN)
    secant = float(oil.log_viscosity_ratio(np.array([0.2e9]))[0]) / 0.2
    return spread((secant, 1e9 * float(oil.alpha)))


def viscosity() -> list[Row]:
    """Cards against single measured figures under pressure."""
    pao, ester, squalane = (measured(name) for name in ("alpha_pao", "alpha_turbine_ester", "squalane_200_MPa"))
    unsaid = "secant at 0.2 GPa and slope; which of them is printed is not said"
    rows = [
        Row("pressure", "alpha of PAO 100 at 25 degC", "1/GPa", *[pao["pao100_per_GPa"]] * 2,
            *secant_and_slope(ehl.Oil.load("pao100"), 25.0), pao["mark"], f"card pao100, {unsaid}")
    ]  # fmt: skip
    # density 980 kg/m3, 4 %/K and nu100 unverified: the family sets ln(eta/eta0) by nu
    nu_40 = 1e6 * ester["viscosity_Pa_s"] / 980.0 * math.exp(-0.04 * (40.0 - ester["temperature_degC"]))
    generic = ehl.Oil.generic("ester", nu_40=f"{nu_40} cSt", nu_100="5.1 cSt")
    rows.append(
        Row("pressure", "alpha of a turbine ester at 38 degC", "1/GPa", *[ester["alpha_per_GPa"]] * 2,
            *secant_and_slope(generic, ester["temperature_degC"]), ester["mark"], f"generic ester, {unsaid}")
    )  # fmt: skip
    oil = ehl.Oil.load("squalane").at(squalane["temperature_K"])
    value = 1e3 * float(oil.viscosity(np.array([1e6 * squalane["pressure_MPa"]]))[0])
    rows.append(
        Row("pressure", "squalane at 200 degC and 200 MPa", "mPa s", *squalane["viscosity_mPa_s"], value, value,
            squalane["mark"], "one digit; card squalane, constants unverified and stated for 20 to 60 degC only")
    )  # fmt: skip
    for temperature in (40.0, 100.0):
        other, card = (
            float(ehl.Oil.load(name).at(temperature + KELVIN).log_viscosity_ratio(np.array([0.8e9]))[0])
            for name in ("fva3_400", "fva3")
        )
        rows.append(
            Row("pressure", f"ln(eta/eta0) of FVA 3 at 0.8 GPa, {temperature:.0f} degC", "", other, other, card, card,
                "read", "two published laws of one reference oil: fva3_400 (FVA 400) and fva3")
        )  # fmt: skip
    return rows


def gears() -> list[Row]:
    """Mesh efficiency of the shipped pairs compared with whole axles, their mean friction with published ranges."""
    import efficiency
    from efficiency.conditions.conditions import resolve_friction
    from efficiency.loss.ehl_friction import EhlFriction

    pairs = [efficiency.load(name) for name in ("fh_hypoid_9x34", "fm_hypoid_13x42", "fm_spiral_bevel_14x39")]
    loaded = [pair.mesh().load() for pair in pairs]
    models = ("75w90", "xu_kahraman_2007", "constant:0.05")
    found: dict[str, list[Any]] = {}
    for name in models:
        model = [resolve_friction(name, pair.design) for pair in pairs]
        # one process and 40 contacts of each mesh: the benchmark is not about its time
        model = [replace(m, jobs=1, points=40, tolerance=0.0) if isinstance(m, EhlFriction) else m for m in model]
        found[name] = [mesh.efficiency(m) for mesh, m in zip(loaded, model, strict=True)]
    axle, friction = measured("axle_efficiency"), measured("gear_mean_friction")
    rows = []
    for model in models:
        values = [result.efficiency for result in found[model][:2]]
        rows.append(
            Row("gears", f"hypoid mesh efficiency, {model}", "", axle["low"], axle["high"], *spread(values),
                axle["mark"], "measured: whole axles with bearings, seals and churning; the mesh alone must lie above")
        )  # fmt: skip
    for model in models[:3]:
        means = [result.friction_coefficient_mean for result in found[model]]
        rows.append(
            Row("gears", f"mean mu in the mesh, {model}", "", friction["low"], friction["high"], *spread(means),
                friction["mark"], "three shipped pairs at their operating point")
        )  # fmt: skip
    return rows


# --- table ---------------------------------------------------------------------------------------------------------


def number(value: float) -> str:
    """Three digits; nothing for a bound that is none."""
    return "" if math.isinf(value) else f"{value:.3g}"


def span(low: float, high: float) -> str:
    """One figure, or a range."""
    return number(low) if low == high else f"{number(low)} to {number(high)}".removesuffix(" to ")


def markdown(rows: Sequence[Row]) -> str:
    """The table of the page."""
    lines = ["| case | quantity | measured | computed | deviation | mark |", "|---|---|---|---|---|---|"]
    for row in rows:
        unit = f" [{row.unit}]" if row.unit else ""
        one_sided = math.isinf(row.measured_high) or row.measured_low == 0.0 or row.case == "gears"
        deviation = "" if one_sided else f"{100.0 * row.deviation:+.0f} %"
        least = "at least " if math.isinf(row.measured_high) else ""
        values = (span(row.measured_low, row.measured_high), span(row.computed_low, row.computed_high))
        lines.append(
            f"| {row.case} | {row.quantity}{unit} | {least}{values[0]} | {values[1]} | {deviation} | {row.mark} |"
        )
    return "\n".join(lines)


def write(rows: Sequence[Row], page: Path | None) -> None:
    """measured.csv, and the table between the markers of the page."""
    write_rows(OUT / "measured.csv", rows)
    if page is not None and page.is_file():
        before, rest = page.read_text(encoding="utf-8").split(MARKERS[0])
        after = rest.split(MARKERS[1])[1]
        page.write_text(f"{before}{MARKERS[0]}\n{markdown(rows)}\n{MARKERS[1]}{after}", encoding="utf-8")


def main(argv: Sequence[str] | None = None) -> list[Row]:
    """Run the cases; see the head of the file."""
    parser = command_line(__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs/figures"))
    parser.add_argument("--page", type=Path, default=Path("docs/validation_measured.md"))
    options = parser.parse_args(argv)
    film_rows, film_curves = films()
    slip_rows, slip_curves = low_slip()
    oil_rows, oil_ratios = bearing_oils()
    rows = [*film_rows, *slip_rows, *oil_rows, *family_order()]
    more: tuple[Callable[[], list[Row]], ...] = (
        gear_oils, superfinished, thick_film, marks_and_films, boundary, viscosity, gears,
    )  # fmt: skip
    rows += [row for case in more for row in case()]
    draw_film(film_curves, options.out / "measured_film.png")
    draw_low_slip(slip_curves, options.out / "measured_low_slip.png")
    draw_oils(oil_ratios, options.out / "measured_oils.png")
    write(rows, options.page)
    print(markdown(rows))
    return rows


if __name__ == "__main__":
    main()
