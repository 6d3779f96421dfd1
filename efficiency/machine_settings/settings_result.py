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
from ehl.common.arrays import FloatArray, finite_or_none
from ehl.common.pages import Reportable

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
    undercut: tuple[UndercutPoint, ...]  # points that do not exist on the flank
    # unloaded transmission error of the mesh; None if it was not or could not be computed
    transmission: Transmission | None = None

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

    presenter = "efficiency.machine_settings.report:settings"

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
        plain: dict[str, Any] = finite_or_none(out)
        return plain | {"design": self.design.model_dump()}


# largest undercut fraction of the points of a flank, or of the working depth of the gear, in a usable pair (this work)
UNDERCUT_LIMIT = 0.05

Flaw = Literal["pointed", "undercut"]


@dataclass(frozen=True)
class ToothFinding:
    """A defect of a cut tooth."""

    # ``"pointed"``: the flanks intersect below the tip; ``"undercut"``: the cutter removed part of the working flank;
    # None: acceptable
    flaw: Flaw | None
    text: str  # place, amount and remedy


def tip_findings(flanks: GearFlanks, module_normal: float) -> list[ToothFinding]:
    """Findings on the tip thickness of the cut teeth of both members: pointed, or too thin for a hardened tip.

    flanks: the four flanks.
    module_normal: mean normal module [m].
    """
    findings = []
    for member in MEMBERS:
        shape = tooth_shape(flanks, member)
        thinnest = int(np.argmin(shape.thickness_tip))
        tip, place = float(shape.thickness_tip[thinnest]) * 1e3, float(shape.face[thinnest]) * 1e3
        what = f"{member}: the cut tooth is {tip:.2f} mm thick at its tip, {place:.3g} mm from the toe"
        if tip <= 0.0:
            findings.append(ToothFinding("pointed", f"{what}: its flanks intersect; {TIP_REMEDIES[member]}"))
        elif tip < TOP_LAND * module_normal * 1e3:
            limit = f"below {TOP_LAND:g} mean normal modules ({TOP_LAND * module_normal * 1e3:.2f} mm)"
            findings.append(ToothFinding(None, f"{what}, {limit}: a hardened tip breaks; {TIP_REMEDIES[member]}"))
    return findings


def undercut_findings(fits: tuple[FlankFit, ...], gear_lowest: float) -> list[ToothFinding]:
    """Findings on the undercut of the working flanks of pinion and gear.

    fits: both pinion flanks.
    gear_lowest: fraction of the working depth of the gear above which its flanks cover the face width.
    """
    findings = []
    if gear_lowest > 0.03:
        text = f"gear: undercut below {gear_lowest:.2g} of its working depth, where no contact was required; "
        text += "raise depth.gear_addendum_factor or the pressure angle"
        findings.append(ToothFinding("undercut" if gear_lowest > UNDERCUT_LIMIT else None, text))
    for fit in fits:
        if fit.undercut:
            count, total, where = len(fit.undercut), fit.grid.u.size, fit.undercut[0].place
            text = f"{fit.side}: {count} of {total} points undercut ({where}); raise the pressure angle, reduce "
            text += "depth.depth_factor or depth.gear_addendum_factor"
            findings.append(ToothFinding("undercut" if count > UNDERCUT_LIMIT * total else None, text))
    return findings
