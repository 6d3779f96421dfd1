"""Report sections and figures of one contact; of a transient run also friction over travel and roughness."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ehl.common.arrays import FloatArray
from ehl.common.data import reason_text
from ehl.common.errors import InputError
from ehl.common.figures import BLUE, GREY, ORANGE, new_figure
from ehl.common.notes import CONTACT_NOTES, Note, group_notes
from ehl.common.quantities import axis_label, plus_minus, quantity, to_display
from ehl.common.sections import Folded, Head, Item, KeyFigures, MainResult, Medium, Notes, Picture, Row, Section, Text
from ehl.common.table import Table
from ehl.inputs import ContactProblem
from ehl.line_contact import LineContact
from ehl.rough import TransientResult
from ehl.rough.accuracy import BATCH
from ehl.rough.averaging import MIN_BATCHES, batch_means
from ehl.rough.mixed import rough_surfaces
from ehl.surface.roughness import RoughProfile, autocorrelation
from ehl.uncertainty.result import InputUncertainty, plot_sources

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ehl.smooth.solver import SteadyResult

DARK, RED = "#222831", "#a3242c"
SURFACES = (BLUE, ORANGE)
SHOWN = (-2.0, 1.35)  # [b]


def plot_transient(problem: ContactProblem, run: TransientResult, smooth: SteadyResult, title: str) -> Axes:
    """Time means (left), last step (right), friction over travel and profiles (below)."""
    b = problem.line.half_width
    hot = run.run.problem.settings.thermal
    surfaces = rough_surfaces(problem.surface, problem.line)
    figure = new_figure(11.0, 13.0)
    axes = figure.subplot_mosaic(
        [
            ["pressure", "pressure_now"],
            ["film", "film_now"],
            ["temperature" if hot else "film", "filling"],
            ["friction", "friction"],
            ["heights", "heights"],
            ["correlation", "spectrum"],
        ],
        height_ratios=(3.0, 2.4, 1.8, 2.2, 1.9, 2.2),
    )
    figure.suptitle(title, fontsize=10)
    _pressures(axes["pressure"], problem.line, run, mean=True)
    _mean_film(axes["film"], smooth, run, b)
    if hot:
        x, mean = run.profiles.x / b, run.profiles
        _temperatures(axes["temperature"], x, mean.temperature_film, {"warmer surface": mean.temperature_surface})
        axes["temperature"].legend(loc="upper left", frameon=False, fontsize=8)
    _pressures(axes["pressure_now"], problem.line, run, mean=False)
    _last_film(axes["film_now"], run, b)
    _last_filling(axes["filling"], run, b)
    for name in ("pressure", "film", "pressure_now", "film_now"):
        axes[name].set_xlim(SHOWN)
    for name in ("temperature" if hot else "film", "filling"):
        axes[name].set(xlim=SHOWN, xlabel="x/b [-]")
    _friction(axes["friction"], run)
    profiles = [(i, p) for i, p in enumerate((surfaces.profile_1, surfaces.profile_2)) if p is not None and p.rms > 0.0]
    _heights(axes["heights"], profiles, b)
    _correlation(axes["correlation"], profiles)
    _spectrum(axes["spectrum"], profiles)
    return axes["pressure"]


def hertz_line(axes: Axes, pressure_hertz: float) -> None:
    """The Hertz pressure over x/b [GPa]."""
    inside = np.linspace(-1.0, 1.0, 201)
    axes.plot(inside, pressure_hertz / 1e9 * np.sqrt(1.0 - inside**2), color=GREY, lw=1.0, ls="--", label="Hertz")


def _pressures(axes: Axes, line: LineContact, run: TransientResult, *, mean: bool) -> None:
    """Fluid and asperity pressure with that of Hertz: time mean, also in total, or last time step."""
    shown = run.profiles if mean else run.snapshot
    x, fluid, asperities = shown.x / line.half_width, shown.pressure_fluid / 1e9, shown.pressure_asperity / 1e9
    hertz_line(axes, line.pressure_hertz)
    if mean:
        axes.plot(x, fluid + asperities, color=DARK, lw=1.0, label="total")
    axes.plot(x, fluid, color=BLUE, lw=1.5 if mean else 1.2, label="fluid")
    axes.fill_between(x, asperities, color=ORANGE, lw=0.0, label="asperities")
    if mean and math.isfinite(run.roughness_load_share):
        axes.plot(x, run.profiles.pressure_macroscopic / 1e9, color=RED, ls=":", label="macroscopic")
    axes.set(ylabel=axis_label("pressure"), ylim=(0.0, None))
    axes.set_title(f"mean over {run.travel:.3g} half-widths of travel" if mean else "last time step", fontsize=9)
    axes.legend(loc="upper left", frameon=False, fontsize=8)


def _mean_film(axes: Axes, smooth: SteadyResult, run: TransientResult, b: float) -> None:
    axes.plot(smooth.x / b, smooth.film * 1e9, color=GREY, lw=1.0, ls="--", label="smooth, isothermal")
    axes.plot(run.profiles.x / b, run.profiles.film * 1e9, color=BLUE, label="film")
    axes.axhline(run.boundary_film * 1e9, color=RED, lw=0.8, ls=":", label="boundary film")
    highest = max(run.film_mean, smooth.film_central)
    axes.set(ylabel=axis_label("film_thickness"), ylim=(0.0, 3.0 * highest * 1e9))
    axes.legend(loc="upper center", frameon=False, fontsize=8)


def _temperatures(axes: Axes, x: FloatArray, film: FloatArray, surfaces: Mapping[str, FloatArray]) -> None:
    """Temperatures of the film and of named surfaces over x/b."""
    axes.plot(x, to_display("temperature", film), color=ORANGE, label="film")
    for dash, (name, temperature) in zip(("-", "--"), surfaces.items(), strict=False):
        axes.plot(x, to_display("temperature", temperature), color=BLUE, ls=dash, label=name)
    axes.set(ylabel=axis_label("temperature"))


def _last_film(axes: Axes, run: TransientResult, b: float) -> None:
    last = run.snapshot
    x, film = last.x / b, last.film * 1e9
    axes.plot(x, film, color=BLUE, lw=1.2, label="film")
    axes.axhline(run.boundary_film * 1e9, color=RED, lw=0.8, ls=":", label="boundary film")
    touching = last.pressure_asperity > 0.0
    axes.plot(x[touching], film[touching], color=ORANGE, marker="o", ms=4.0, ls="none", label="contact")
    inside = np.abs(x) < 1.0
    axes.set(ylabel=axis_label("film_thickness"), ylim=(0.0, 1.45 * float(film[inside].max())))
    axes.legend(loc="upper center", framealpha=0.9, edgecolor="none", fontsize=8, ncols=3)


def _last_filling(axes: Axes, run: TransientResult, b: float) -> None:
    x = run.snapshot.x / b
    axes.fill_between(x, run.snapshot.filling, color=BLUE, alpha=0.25, lw=0.0)
    axes.plot(x, run.snapshot.filling, color=BLUE, lw=1.0)
    axes.set(ylabel="filling [-]", ylim=(0.0, 1.05))


def running_mean(run: TransientResult) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mean of mu and half width of its 90 % interval over the first 2, 4, 6... half-widths of the window.

    Returns: travel [b], mean [-], half_width [-], shape (n,); the half width is nan with too few batches.
    """
    mu = run.history_friction
    per_half_width = mu.size / run.travel
    batch = round(BATCH * per_half_width)
    ends = np.arange(batch, mu.size + 1, batch)
    pairs = np.array([batch_means(mu[:end], batch) for end in ends]).reshape(-1, 2)
    return run.history_travel[ends - 1], pairs[:, 0], pairs[:, 1]


def _friction(axes: Axes, run: TransientResult) -> None:
    travel, mean, half_width = running_mean(run)
    axes.plot(run.history_travel, run.history_friction, color=GREY, lw=0.6, alpha=0.8, label="each time step")
    known = np.isfinite(half_width)
    if known.any():
        axes.fill_between(
            travel[known], (mean - half_width)[known], (mean + half_width)[known], color=BLUE, alpha=0.2, lw=0.0,
            label=f"90 % interval (at least {MIN_BATCHES} batches)",
        )  # fmt: skip
    axes.plot(travel, mean, color=BLUE, label="running mean")
    axes.set(xlim=(0.0, run.travel), xlabel="travel [b]", ylabel=axis_label("friction_coefficient"))
    low, high = np.quantile(run.history_friction, (0.002, 0.998))
    axes.set_ylim(low - 0.1 * (high - low), high + 0.35 * (high - low))
    axes.legend(loc="upper right", frameon=False, fontsize=8, ncols=3)


def _heights(axes: Axes, profiles: list[tuple[int, RoughProfile]], b: float) -> None:
    apart = 8.0 * max(profile.rms for _, profile in profiles) * 1e6
    mark = float(f"{0.25 * apart:.1g}")
    words, ticks, labels = [], [], []
    for row, (i, profile) in enumerate(profiles):
        axes.plot(profile.x * 1e3, profile.heights * 1e6 - row * apart, color=SURFACES[i], lw=0.7)
        words.append(
            f"surface {i + 1}: Rq {profile.rms * 1e6:.3g} µm, "
            f"correlation length {profile.correlation_length * 1e6:.3g} µm, "
            f"skewness {profile.skewness:.2f}, kurtosis {profile.kurtosis:.2f}, "
            f"cut-off {profile.cutoff * 1e6:.3g} µm ({profile.source})"
        )
        ticks += [value - row * apart for value in (-mark, 0.0, mark)]
        labels += [f"{-mark:g}", "0", f"{mark:g}"]
    axes.set_yticks(ticks, labels, fontsize=8)
    longest = max(profile.length for _, profile in profiles)
    axes.set(xlim=(0.0, longest * 1e3), xlabel="x [mm]", ylabel="height [µm]")
    axes.set_title("\n".join(words), fontsize=8)
    low, high = axes.get_ylim()
    y = low - 0.02 * (high - low)
    axes.plot([0.0, 2.0 * b * 1e3], [y, y], color=DARK, lw=3.0, solid_capstyle="butt")
    axes.annotate("Hertz width", (2.0 * b * 1e3, y), xytext=(4, 0), textcoords="offset points", fontsize=8, va="center")
    axes.set_ylim(y - 0.08 * (high - low), high)


def _correlation(axes: Axes, profiles: list[tuple[int, RoughProfile]]) -> None:
    reach = 4.0 * max(profile.correlation_length for _, profile in profiles)
    for i, profile in profiles:
        acf = autocorrelation(np.asarray(profile.heights))
        lag = profile.spacing * np.arange(acf.size)
        near = lag <= reach
        axes.plot(lag[near] * 1e6, acf[near], color=SURFACES[i], label=f"surface {i + 1}")
        smooth = np.exp(-((lag[near] / profile.correlation_length) ** 2))
        axes.plot(lag[near] * 1e6, smooth, color=SURFACES[i], lw=0.8, ls="--")
    axes.axhline(0.0, color=GREY, lw=0.5)
    axes.plot([], [], color=GREY, lw=0.8, ls="--", label="Gaussian of the same length")
    axes.set(xlabel="lag [µm]", ylabel="autocorrelation [-]", xlim=(0.0, reach * 1e6))
    axes.legend(loc="upper right", frameon=False, fontsize=8)


def _spectrum(axes: Axes, profiles: list[tuple[int, RoughProfile]]) -> None:
    for i, profile in profiles:
        n = profile.heights.size
        amplitude = 2.0 * np.abs(np.fft.rfft(profile.heights * 1e9)[1:]) / n
        wavelength = profile.length / np.arange(1, amplitude.size + 1) * 1e6
        shown = amplitude > 1e-5 * float(amplitude.max())
        axes.loglog(wavelength[shown], amplitude[shown], color=SURFACES[i], lw=0.7, label=f"surface {i + 1}")
        axes.axvline(profile.cutoff * 1e6, color=SURFACES[i], lw=0.8, ls=":")
    axes.plot([], [], color=GREY, lw=0.8, ls=":", label="cut-off")
    axes.set(xlabel="wavelength [µm]", ylabel="amplitude [nm]")
    axes.legend(loc="lower right", frameon=False, fontsize=8)


def plot_contact(result: Any, ax: Axes | None = None) -> Axes:
    """Figure of pressure, film and temperatures; of a transient run also its history and roughness."""
    if result.problem is None or result.film is None or result.isothermal is None:
        raise InputError("plot", result.reason, "a solved contact")
    if ax is None and result.transient is not None:
        return plot_transient(result.problem, result.transient, result.isothermal, _caption(result))
    return _plot_smooth(result, ax)


def _caption(result: Any) -> str:
    """Title of the figure."""
    if result.transient is None:
        return (
            f"μ = {_friction_text(result)}, h_c = {result.film_central * 1e9:.1f} nm, "
            f"h_min = {result.film_min * 1e9:.1f} nm"
        )
    errors = f"mesh ±{100.0 * result.mesh_error:.2g} %, 90 % interval ±{100.0 * result.statistical_error:.2g} %"
    first = f"μ = {_friction_text(result)} ({errors})"
    if math.isfinite(result.friction_boundary_half):
        half, double = result.friction_boundary_half, result.friction_boundary_double
        first += f",  {half:.3g} to {double:.3g} at half and twice the boundary film"
    second = f"λ = {result.film_ratio:.2g},  asperities carry {100.0 * result.asperity_load_share:.2g} %"
    if math.isfinite(result.roughness_load_share):
        second += f", {100.0 * result.roughness_load_share:.2g} % of the load above the macroscopic pressure"
    return f"{first}\n{second},  {result.status} {reason_text(result.reason)}".rstrip()


def _plot_smooth(result: Any, ax: Axes | None) -> Axes:
    """Pressure and film over x/b with the Hertz pressure; temperatures in a second plot if they were computed."""
    line, film, heat = result.problem.line, result.film, result.heat
    b = line.half_width
    temperature_axes = None
    if ax is not None:
        axes = ax
    elif heat:
        axes, temperature_axes = new_figure(7.0, 6.6).subplots(2, 1, sharex=True, height_ratios=(3, 2))
    else:
        axes = new_figure().add_subplot()
    hertz_line(axes, line.pressure_hertz)
    axes.plot(film.x / b, to_display("pressure", film.pressure), color=BLUE, label="pressure")
    axes.set(ylabel=axis_label("pressure"), xlim=(-2.0, 1.5), ylim=(0.0, None))
    film_axes = axes.twinx()
    film_axes.plot(film.x / b, to_display("film_thickness", film.film), color=ORANGE, label="film thickness")
    film_axes.set(
        ylabel=axis_label("film_thickness"), ylim=(0.0, 4.0 * to_display("film_thickness", film.film_central))
    )
    lines = [*axes.get_lines(), *film_axes.get_lines()]
    axes.legend(lines, [str(line.get_label()) for line in lines], loc="upper right", frameon=False)
    axes.set_title(_caption(result))
    if heat and temperature_axes:
        surfaces = {"surface 1": heat.temperature_flash_1, "surface 2": heat.temperature_flash_2}
        _temperatures(temperature_axes, heat.x / b, heat.temperature_film, surfaces)
        temperature_axes.legend(loc="upper left", frameon=False)
    (temperature_axes or axes).set_xlabel("x/b [-]")
    return axes


_TILES = ("film_central", "film_min", "film_ratio", "pressure_max", "temperature_film_max")


def contact_sections(result: Any, medium: Medium, uncertainty: InputUncertainty | None = None) -> list[Section]:
    """Sections of one contact, including one that failed."""
    inputs = [] if result.problem is None else [result.problem.to_dict()]
    operating_point = [Table.from_records(inputs, name="operating point", vertical=True)] if inputs else []
    if medium != "page":
        more = [] if uncertainty is None else [uncertainty.table()]
        head = Head(f"Line contact, {result.operating_point}")
        return [Section("", [head, result.table(), *(operating_point if medium == "files" else []), *more])]
    sections = [_headline(result, uncertainty)]
    if result.film is not None:
        solution = Picture(lambda: plot_contact(result), "Pressure, film and temperatures over x/b.", "solution")
        sections.append(Section("Solution", [solution]))
    if uncertainty is not None and uncertainty.sources:
        caption = "Change of friction by each input alone; the error of the solution is separate."
        bars = Picture(lambda: plot_sources(uncertainty), caption, "uncertainty")
        sections.append(Section("Input uncertainty", [bars, Folded("Sources in numbers", [uncertainty.table()])]))
    tables: list[Item] = []
    if result.status != "failed":
        tables.append(replace(result.table(), title="Results.", notes=()))
    tables += [replace(table, title="Operating point.") for table in operating_point]
    sections.append(Section("Results and operating point", [Row(tables)]))
    computed: list[Item] = [Text(f"{result.outcome.capitalize()}; {result.cost}.")]
    if result.skipped:
        computed.insert(0, Table(("neglected", "reason"), [text.partition(": ")[::2] for text in result.skipped]))
    sections.append(Section("How it was computed", computed))
    return sections


def _headline(result: Any, uncertainty: InputUncertainty | None) -> Section:
    head = Head("Line contact", result.operating_point)
    notes = group_notes([("", note) for note in result.notes], CONTACT_NOTES)
    if result.status == "failed":
        answer = MainResult("no answer", f"friction coefficient: {reason_text(result.reason)}")
        return Section("", [head, answer, Notes([Note("fault", f"failed: {reason_text(result.reason)}"), *notes])])
    if result.status == "unsettled":
        notes.insert(0, Note("warning", result.outcome))
    known = [_inputs(uncertainty), (plus_minus(result.friction_error), "error of the solution")]
    if math.isfinite(result.friction_boundary_half):
        ends = sorted((result.friction_boundary_half, result.friction_boundary_double))
        known.append((f"{ends[0]:.3g} to {ends[1]:.3g}", "at half and twice the boundary film, an empirical input"))
    tiles = []
    for name in _TILES:
        value = getattr(result, name)
        if name == "film_ratio" and not math.isfinite(value):
            tiles.append(("smooth", "surfaces without a film ratio"))
        elif math.isfinite(value):
            tiles.append((quantity(name).text(value, 3), quantity(name).label))
    if math.isfinite(result.film_ratio):
        tiles.insert(3, (f"{100.0 * result.asperity_load_share:.3g} %", "load on asperities"))
    answer = MainResult(_friction_text(result), quantity("friction_coefficient").label, known)
    return Section("", [head, answer, KeyFigures(tiles), Notes(notes)])


def _inputs(uncertainty: InputUncertainty | None) -> tuple[str, str]:
    if uncertainty is None:
        return "not computed", "interval by uncertain inputs (solve --uncertainty, or Contact.uncertainty in Python)"
    if not uncertainty.low < uncertainty.high:
        return "no interval", "; ".join(uncertainty.notes) or "no input is uncertain"
    most = ", ".join(f"{name} {half:.2g}" for name, half in list(uncertainty.groups.items())[:3])
    meaning = f"{100.0 * uncertainty.level:.0f} % interval by uncertain inputs, largest contributions: {most}"
    return f"{uncertainty.low:.3g} to {uncertainty.high:.3g}", meaning


def _friction_text(result: Any) -> str:
    """The friction coefficient with two digits of its error, at most four."""
    error = result.friction_error
    digits = 4 if not 0.0 < error < math.inf else min(max(2, 1 - math.floor(math.log10(error))), 4)
    return f"{result.friction_coefficient:.{digits}g}"
