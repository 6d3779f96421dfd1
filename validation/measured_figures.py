"""Figures of measured.py: measured and computed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure


def draw_film(curves: Sequence[dict[str, Any]], path: Path) -> None:
    """Central film over speed: marks measured, bands the point formula between reservoir and probe temperature."""
    figure = Figure(figsize=(10.5, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    for place, curve in enumerate(curves):
        axes = right if "reading" in curve["name"] or "SHC" in curve["name"] else left
        colour, speed, order = f"C{place}", curve["speed"], np.argsort(curve["speed"])
        axes.plot(speed, curve["film"], "o", ms=4, color=colour, label=curve["name"])
        low, high = np.minimum(*curve["computed"]), np.maximum(*curve["computed"])
        axes.fill_between(speed[order], low[order], high[order], color=colour, alpha=0.35, lw=0)
        axes.plot(speed[order], curve["computed"][0][order], "-", lw=1, color=colour)
        axes.plot(*curve["line"], ":", lw=1, color=colour)
    left.set(title="FVA 3", xscale="log", yscale="log", ylabel="central film [nm]")
    right.set(title="FVA 3, two readings; SHC 320 (card paor)")
    for axes in (left, right):
        axes.set_xlabel("entrainment speed [m/s]")
        axes.grid(alpha=0.3, which="both")
        axes.legend(fontsize=8)
    note = (
        "marks measured, lines Hamrock-Dowson with the card\n"
        "(band up to the reservoir temperature), dots the solver's line contact"
    )
    left.text(0.98, 0.02, note, transform=left.transAxes, ha="right", va="bottom", fontsize=7)
    figure.savefig(path, dpi=130)


def draw_low_slip(curves: dict[str, Any], path: Path) -> None:
    """Friction over slip, as it is and over its value at 20 %."""
    figure = Figure(figsize=(9.5, 3.8), layout="constrained")
    for axes, relative in zip(figure.subplots(1, 2), (False, True), strict=True):
        for name, values in {"measured, oil unknown": curves["measured"], **curves["computed"]}.items():
            last = values[-1] if relative else 1.0
            style = "ko" if name.startswith("measured") else "-"
            slips = curves["slip"] if style == "ko" else curves["slips"]
            axes.plot(100.0 * np.array(slips), np.array(values) / last, style, ms=5, label=name)
        axes.set(xlabel="slide-to-roll ratio [%]", ylim=(0.0, None))
        axes.set_ylabel("friction coefficient" + (" over that at 20 %" if relative else ""))
        axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="lower right")
    figure.savefig(path, dpi=130)


def draw_oils(ratios: dict[str, Any], path: Path) -> None:
    """Friction of the oils over the mineral one: measured in bearings, computed over the states."""
    figure = Figure(figsize=(5.6, 3.6), layout="constrained")
    axes = figure.subplots()
    for place, (oil, values) in enumerate(ratios["computed"].items()):
        axes.plot([place] * 2, [values.min(), values.max()], "-", lw=9, color="C0", alpha=0.4, solid_capstyle="butt")
        axes.plot(
            place, values.mean(), "_", ms=18, mew=2, color="C0", label="computed, range and mean" if place == 0 else ""
        )
        for bearing, mark in (("roller", "ks"), ("ball", "k^")):
            label = f"measured, {bearing} thrust bearing" if place == 0 else ""
            axes.plot(place, ratios["given"][bearing][oil], mark, ms=7, mfc="w", label=label)
    axes.set_xticks(range(len(ratios["computed"])), list(ratios["computed"]))
    axes.set(ylabel="friction over that of minr", ylim=(0.0, 1.1))
    axes.grid(alpha=0.3, axis="y")
    axes.legend(fontsize=8)
    figure.savefig(path, dpi=130)
