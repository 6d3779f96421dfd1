"""The teeth that the settings leave: tip thickness and undercut of the cut flanks, with the remedy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from efficiency.blanks.checks import TOP_LAND
from efficiency.contact.gear_flanks import MEMBERS, GearFlanks
from efficiency.contact.tooth_grid import tooth_shape
from efficiency.machine_settings.settings_result import FlankFit

# share of a flank's points, or of the gear's working depth, that may be undercut in a usable pair (ours)
UNDERCUT_LIMIT = 0.05

Flaw = Literal["pointed", "undercut"]


@dataclass(frozen=True)
class ToothFinding:
    """What is wrong with a cut tooth.

    Attributes
    ----------
    flaw : str or None
        ``"pointed"``: the flanks cross below the tip; ``"undercut"``: the cutter took away working flank. None for what
        a designer has to know but may accept.
    text : str
        Place, amount and remedy.
    """

    flaw: Flaw | None
    text: str


def tip_findings(flanks: GearFlanks, module_normal: float) -> list[ToothFinding]:
    """Tip thickness of the cut teeth of both members: no tooth, or less than a hard tip needs.

    Parameters
    ----------
    flanks : GearFlanks
        The four flanks.
    module_normal : float
        Mean normal module [m].
    """
    findings = []
    remedies = {
        "pinion": "lower the pinion's addendum (larger depth.gear_addendum_factor, smaller depth.depth_factor) or "
        "thicken it (larger depth.thickness_factor)",
        "gear": "lower the gear's addendum (smaller depth.gear_addendum_factor or depth.depth_factor) or thicken it "
        "(smaller depth.thickness_factor)",
    }
    for member in MEMBERS:
        shape = tooth_shape(flanks, member)
        thinnest = int(np.argmin(shape.thickness_tip))
        tip, place = float(shape.thickness_tip[thinnest]) * 1e3, float(shape.face[thinnest]) * 1e3
        what = f"{member}: the cut tooth is {tip:.2f} mm thick at its tip, {place:.3g} mm from the toe"
        if tip <= 0.0:
            findings.append(ToothFinding("pointed", f"{what}: its flanks cross; {remedies[member]}"))
        elif tip < TOP_LAND * module_normal * 1e3:
            limit = f"below {TOP_LAND:g} mean normal modules ({TOP_LAND * module_normal * 1e3:.2f} mm)"
            findings.append(ToothFinding(None, f"{what}, {limit}: a hardened tip breaks; {remedies[member]}"))
    return findings


def undercut_findings(fits: tuple[FlankFit, ...], gear_lowest: float) -> list[ToothFinding]:
    """Undercut of the working flanks of pinion and gear.

    Parameters
    ----------
    fits : tuple of FlankFit
        Both pinion flanks.
    gear_lowest : float
        Fraction of the gear's working depth from which on its flanks span the face.
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
