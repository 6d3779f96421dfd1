"""What the search for machine settings leaves behind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from efficiency.blanks.checks import TOP_LAND
from efficiency.contact.gear_flanks import MEMBERS, GearFlanks
from efficiency.contact.tooth_grid import TIP_REMEDIES, tooth_shape
from efficiency.contact.transmission import Transmission
from efficiency.cutting.cutter import FlankSide
from efficiency.design.design import Design
from efficiency.machine_settings.conjugate import FitGrid
from efficiency.machine_settings.fit import FittedFlank
from ehl.common.arrays import FloatArray
from ehl.common.numbers import finite_or_none
from ehl.common.pages import Reportable

RESIDUAL_LIMIT = 3e-6


@dataclass(frozen=True)
class UndercutPoint:
    """A point that the pinion flank does not reach."""

    # blank coordinates of the gear point that would touch it [m]
    gear_u: float
    gear_h: float
    place: str  # where on the gear flank: toe, middle or heel, and root, middle or tip


@dataclass(frozen=True)
class FlankFit:
    """Residual of one pinion flank."""

    side: FlankSide  # pinion flank, ``"concave"`` (drive) or ``"convex"`` (coast)
    grid: FitGrid  # where it was fitted
    fitted: FittedFlank  # relief and residual at the points of the grid
    start_error: float  # distance of the conjugate start from the conjugate flank [m]
    undercut: tuple[UndercutPoint, ...]  # points that do not exist on the flank
    # unloaded transmission error of the mesh; None where it was not or could not be computed
    transmission: Transmission | None = None

    @property
    def transmission_error(self) -> float | None:
        """Peak to peak of the unloaded transmission error of the mesh [rad]."""
        return None if self.transmission is None else self.transmission.peak_to_peak

    @property
    def residual_map(self) -> FloatArray:
        """Rows (u [m], h [m], residual [m]); undercut points are not a number."""
        residual = np.where(self.fitted.found, self.fitted.residual, np.nan)
        return np.stack([self.grid.u, self.grid.h, residual], axis=1)


@dataclass(frozen=True, repr=False)
class SettingsResult(Reportable):
    """Machine settings from targets."""

    presenter = "efficiency.machine_settings.report:settings"

    design: Design  # the pair as its file holds it
    text: str  # the design file
    # residuals of both pinion flanks
    concave: FlankFit
    convex: FlankFit
    iterations: int  # of the fits together
    seconds: float  # wall time
    # ``"converged"``; ``"pointed"`` where the cut flanks of a member cross below its tip; ``"undercut"`` where more
    # than a twentieth of a working flank is undercut; ``"residual"`` where a residual exceeds `RESIDUAL_LIMIT`
    status: str
    warnings: tuple[str, ...]  # what to look at

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
        """Plain numbers in SI units.

        Returns: points that do not exist are null.
        """
        out: dict[str, Any] = {
            "name": self.design.name,
            "status": self.status,
            "iterations": self.iterations,
            "seconds": self.seconds,
            "warnings": list(self.warnings),
        }
        for flank in self.flanks:
            out[flank.side] = {
                "residual_rms": flank.fitted.rms,
                "residual_max": flank.fitted.largest,
                "transmission_error": flank.transmission_error,
                "root_error": flank.fitted.root_error.tolist(),
                "undercut": [
                    {"gear_u": point.gear_u, "gear_h": point.gear_h, "place": point.place} for point in flank.undercut
                ],
                "residual_map": [[finite_or_none(float(value)) for value in row] for row in flank.residual_map],
            }
        out["design"] = self.design.model_dump()
        return out


# share of a flank's points, or of the gear's working depth, that may be undercut in a usable pair (ours)
UNDERCUT_LIMIT = 0.05

Flaw = Literal["pointed", "undercut"]


@dataclass(frozen=True)
class ToothFinding:
    """What is wrong with a cut tooth."""

    # ``"pointed"``: the flanks cross below the tip; ``"undercut"``: the cutter took away working flank. None for what a
    # designer has to know but may accept.
    flaw: Flaw | None
    text: str  # place, amount and remedy


def tip_findings(flanks: GearFlanks, module_normal: float) -> list[ToothFinding]:
    """Tip thickness of the cut teeth of both members: no tooth, or less than a hard tip needs.

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
            findings.append(ToothFinding("pointed", f"{what}: its flanks cross; {TIP_REMEDIES[member]}"))
        elif tip < TOP_LAND * module_normal * 1e3:
            limit = f"below {TOP_LAND:g} mean normal modules ({TOP_LAND * module_normal * 1e3:.2f} mm)"
            findings.append(ToothFinding(None, f"{what}, {limit}: a hardened tip breaks; {TIP_REMEDIES[member]}"))
    return findings


def undercut_findings(fits: tuple[FlankFit, ...], gear_lowest: float) -> list[ToothFinding]:
    """Undercut of the working flanks of pinion and gear.

    fits: both pinion flanks.
    gear_lowest: fraction of the gear's working depth from which on its flanks span the face.
    """
    findings = []
    if gear_lowest > 0.03:
        findings.append(
            ToothFinding(
                "undercut" if gear_lowest > UNDERCUT_LIMIT else None,
                f"gear: undercut below {gear_lowest:.2g} of its working depth; no contact was asked for there; "
                "raise depth.gear_addendum_factor or the pressure angle",
            )
        )
    for fit in fits:
        if fit.undercut:
            count, total, where = len(fit.undercut), fit.grid.u.size, fit.undercut[0].place
            findings.append(
                ToothFinding(
                    "undercut" if count > UNDERCUT_LIMIT * total else None,
                    f"{fit.side}: {count} of {total} points undercut ({where}); raise the pressure angle, lower "
                    "depth.depth_factor or depth.gear_addendum_factor",
                )
            )
    return findings
