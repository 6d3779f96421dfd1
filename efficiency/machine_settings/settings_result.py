"""Result of the search for machine settings."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from efficiency.blanks.checks import TOP_LAND
from efficiency.contact.contact_search import Transmission
from efficiency.contact.gear_flanks import MEMBERS, GearFlanks
from efficiency.contact.tooth_grid import TIP_REMEDIES, tooth_shape
from efficiency.cutting.cutter import FlankSide
from efficiency.design.design import Design
from efficiency.machine_settings.conjugate import FitGrid
from efficiency.machine_settings.fit import FittedFlank
from efficiency.output.machine_summary import settings_tables
from ehl.common.arrays import FloatArray, finite_or_none
from ehl.common.pages import Reportable
from ehl.common.quantities import quantity
from ehl.common.sections import Head, Medium, Section
from ehl.common.table import Column, Table

RESIDUAL_LIMIT = 3e-6


@dataclass(frozen=True)
class UndercutPoint:
    """A point that does not exist on the pinion flank."""

    # blank coordinates of the mating gear point [m]
    gear_u: float
    gear_h: float
    place: str  # position on the gear flank: toe, middle or heel, and root, middle or tip


@dataclass(frozen=True)
class FlankFit:
    """Residual of one pinion flank."""

    side: FlankSide  # pinion flank, ``"concave"`` (drive) or ``"convex"`` (coast)
    grid: FitGrid  # points of the fit
    fitted: FittedFlank  # relief and residual at the points of the grid
    # unloaded transmission error of the mesh; None if it was not or could not be computed
    transmission: Transmission | None = None

    @property
    def undercut(self) -> tuple[UndercutPoint, ...]:
        """Points that do not exist on the flank."""
        points, grid = [], self.grid
        for k in np.flatnonzero(~self.fitted.found):
            along = "toe" if grid.x[k] < -1 / 3 else "heel" if grid.x[k] > 1 / 3 else "middle"
            across = "root" if grid.y[k] < -1 / 3 else "tip" if grid.y[k] > 1 / 3 else "mid-depth"
            points.append(UndercutPoint(float(grid.u[k]), float(grid.h[k]), f"{along}, {across} of the gear"))
        return tuple(points)

    @property
    def transmission_error(self) -> float | None:
        """Peak-to-peak unloaded transmission error of the mesh [rad]."""
        return None if self.transmission is None else self.transmission.peak_to_peak

    @property
    def residual_map(self) -> FloatArray:
        """Rows (u [m], h [m], residual [m]); nan for undercut points."""
        residual = np.where(self.fitted.found, self.fitted.residual, np.nan)
        return np.stack([self.grid.u, self.grid.h, residual], axis=1)


@dataclass(frozen=True, repr=False)
class SettingsResult(Reportable):
    """Machine settings computed from targets."""

    design: Design  # content of the design file
    text: str  # text of the design file
    # residuals of both pinion flanks
    concave: FlankFit
    convex: FlankFit
    iterations: int  # total number of iterations of the fits
    seconds: float  # wall time [s]
    # ``"converged"``; ``"pointed"`` if the cut flanks of a member intersect below its tip; ``"undercut"`` if more than
    # a twentieth of a working flank is undercut; ``"residual"`` if a residual exceeds `RESIDUAL_LIMIT`
    status: str
    warnings: tuple[str, ...]  # warnings

    @property
    def flanks(self) -> tuple[FlankFit, FlankFit]:
        """Both flanks, drive first."""
        return self.concave, self.convex

    @property
    def rms(self) -> float:
        """Larger of both residuals, root mean square [m]."""
        return max(flank.fitted.rms for flank in self.flanks)

    def sections(self, medium: Medium = "page", *args: Any, **options: Any) -> list[Section]:
        """Settings, fit with warnings, and residual maps of flanks that do not meet their targets."""
        maps = [_map(flank) for flank in self.flanks if flank.fitted.largest > MAP_FROM]
        head = Head(f"Machine settings: {self.design.name}")
        return [Section("", [head, *settings_tables(self.design), _fit(self), *maps])]

    def __repr__(self) -> str:
        return (
            f"SettingsResult({self.design.name!r}: {self.status}, residual RMS {self.rms:.3g} m, "
            f"{len(self.warnings)} warnings)"
        )

    def to_dict(self) -> dict[str, Any]:
        """Content with numbers in SI units; points that do not exist are null."""
        out: dict[str, Any] = {"name": self.design.name}
        out |= {name: getattr(self, name) for name in ("status", "iterations", "seconds", "warnings")}
        for flank in self.flanks:
            out[flank.side] = {
                "residual_rms": flank.fitted.rms,
                "residual_max": flank.fitted.largest,
                "transmission_error": flank.transmission_error,
                "root_error": flank.fitted.root_error,
                "undercut": flank.undercut,
                "residual_map": flank.residual_map,
            }
        return dict(finite_or_none(out)) | {"design": self.design.model_dump()}


MAP_FROM = 1e-9  # largest residual above which a residual map is shown [m]


def _fit(result: SettingsResult) -> Table:
    places = ("toe", "middle", "heel")
    rows = []
    for flank in result.flanks:
        fitted, missing = flank.fitted, len(flank.undercut)
        root = list(fitted.root_error) or [None] * len(places)
        found = fitted.rms, fitted.largest, missing, fitted.found.size
        rows.append((flank.side, *found, *root, flank.transmission_error))
    heads: list[Column | str] = [
        *("pinion flank", "residual_rms", "residual_max"),
        Column("undercut_points", label="undercut points"),
        Column("points", label="points of the grid"),
        *(Column(f"root_error_{place}", of="root_error", label=f"root error, {place}") for place in places),
        "transmission_error",
    ]
    ended = f"{result.status}, {result.iterations} iterations, {result.seconds:.2f} s"
    notes = [*(f"warning: {warning}" for warning in result.warnings), ended]
    return Table(heads, rows, "fit", notes, vertical=True)


def _map(flank: FlankFit) -> Table:
    """Residual over the gear flank: depth fraction over the rows with the tip on top, toe to heel over the columns."""
    along, deep = flank.grid.shape
    shape = (deep, along)
    residual, found = flank.fitted.residual.reshape(shape), flank.fitted.found.reshape(shape)
    u, depth = flank.grid.u.reshape(shape)[0], 0.5 * (flank.grid.y.reshape(shape)[:, 0] + 1.0)
    picked = range(0, along, 2)
    at = [f"{quantity('gear_u').to_display(float(u[k])):.1f}" for k in picked]
    heads = [Column("depth", of="pattern_depth", label="depth", decimals=2)]
    heads += [Column(f"at {text} mm", of="residual_max", label=f"{text} mm", decimals=1) for text in at]
    levels = reversed(range(deep))
    rows = [(depth[i], *(residual[i, k] if found[i, k] else "undercut" for k in picked)) for i in levels]
    title = (
        f"residual of the {flank.side} pinion flank over the gear flank; columns: distance from the mean point to the "
    )
    return Table(heads, rows, f"{title}heel; depth: 0 root, 1 tip", name=f"residual {flank.side}")


# largest undercut fraction of the points of a flank, or of the working depth of the gear, in a usable pair (this work)
UNDERCUT_LIMIT = 0.05

ToothFinding = tuple[Literal["pointed", "undercut"] | None, str]
"""Defect of a cut tooth: pointed (the flanks intersect below the tip), undercut (the cutter removed part of the working
flank), or None if acceptable; place, amount and remedy."""


def tip_findings(flanks: GearFlanks, module_normal: float) -> list[ToothFinding]:
    """Findings on the tip thickness of the cut teeth of both members: pointed, or too thin for a hardened tip.

    flanks: the four flanks.
    module_normal: mean normal module [m].
    """
    findings: list[ToothFinding] = []
    for member in MEMBERS:
        shape = tooth_shape(flanks, member)
        thinnest = int(np.argmin(shape.thickness_tip))
        tip, place = float(shape.thickness_tip[thinnest]) * 1e3, float(shape.face[thinnest]) * 1e3
        what = f"{member}: the cut tooth is {tip:.2f} mm thick at its tip, {place:.3g} mm from the toe"
        if tip <= 0.0:
            findings.append(("pointed", f"{what}: its flanks intersect; {TIP_REMEDIES[member]}"))
        elif tip < TOP_LAND * module_normal * 1e3:
            limit = f"below {TOP_LAND:g} mean normal modules ({TOP_LAND * module_normal * 1e3:.2f} mm)"
            findings.append((None, f"{what}, {limit}: a hardened tip breaks; {TIP_REMEDIES[member]}"))
    return findings


def undercut_findings(fits: tuple[FlankFit, ...], gear_lowest: float) -> list[ToothFinding]:
    """Findings on the undercut of the working flanks of pinion and gear.

    fits: both pinion flanks.
    gear_lowest: fraction of the working depth of the gear above which its flanks cover the face width.
    """
    findings: list[ToothFinding] = []
    if gear_lowest > 0.03:
        text = f"gear: undercut below {gear_lowest:.2g} of its working depth, where no contact was required; "
        text += "raise depth.gear_addendum_factor or the pressure angle"
        findings.append(("undercut" if gear_lowest > UNDERCUT_LIMIT else None, text))
    for fit in fits:
        if fit.undercut:
            count, total, where = len(fit.undercut), fit.grid.u.size, fit.undercut[0].place
            text = f"{fit.side}: {count} of {total} points undercut ({where}); raise the pressure angle, reduce "
            text += "depth.depth_factor or depth.gear_addendum_factor"
            findings.append(("undercut" if count > UNDERCUT_LIMIT * total else None, text))
    return findings
