"""Stribeck curves and load shares of three lays, beside two published asperity shares."""

from __future__ import annotations

import math
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from mixed_scenes import (
    STEEL,
    Scene,
    eyring_oil,
    friction,
    gaussian_pair,
    lagged_share,
    line,
    print_table,
    speed_of_film_ratio,
    startup_of,
    write_csv,
)

from ehl.fluid.lubricant import Lubricant
from ehl.line_contact import LineContact
from ehl.rough._kernels.march import MACRO_LOAD, SHARE
from ehl.rough.averaging import Window, net_exchange


def masjedi_khonsari_2012(contact: LineContact, oil: Lubricant, rms: float, hardness: float) -> float:
    """Asperity load share of a line contact, a fit to a statistical model (Masjedi & Khonsari 2012, J. Tribol. 134).

    Form and coefficients from memory; no longer a share below a film ratio of about 0.1, where it passes 1.
    """
    speed, load, material = contact.dowson_groups(oil)
    sigma, hard = rms / contact.radius_equivalent, hardness / contact.effective_modulus
    inside = 4470.0 * sigma**6.015 * hard**1.168 * load**0.485 * speed**-3.741 * material**-2.898
    return 0.01 * 0.005 * load**-0.408 * speed**-0.088 * material**0.103 * math.log1p(inside)


def stribeck(out: Path, window: float) -> None:
    """mu and both shares over the film ratio, only the speed changing."""
    oil, rms, mesh = eyring_oil(), 0.4e-6, 120.0
    ratios = (4.0, 2.0, 1.0, 0.5, 0.25, 0.12, 0.06, 0.03, 0.012, 0.004)
    columns = (
        "gamma", "lambda", "mu", "mu 90 %", "asperity share", "roughness share", "M-K 2012", "1 - erf",
        "net exchange", "lagged",
    )  # fmt: skip
    rows = []
    for gamma in (math.inf, 3.0, 1.0):
        for ratio in ratios:
            contact = line(speed_of_film_ratio(ratio, rms, oil))
            scene = Scene(contact, oil, gaussian_pair(contact, rms, 0.1), 30e-9, gamma)
            member = Window(scene.run(mesh))
            member.start(startup_of(scene))
            member.roll(window)
            records = member.records
            drained = math.isfinite(gamma)
            rows.append(
                (
                    gamma,
                    ratio,
                    float(friction(records).mean()),
                    member.interval()[1],
                    float(records[:, SHARE].mean()),
                    1.0 - float(records[:, MACRO_LOAD].mean()) if drained else math.nan,
                    masjedi_khonsari_2012(contact, oil, rms, STEEL.hardness),
                    math.erfc(ratio),
                    net_exchange(member)[0],
                    lagged_share(records),
                )
            )
        print_table("", columns, rows[-len(ratios) :])
        write_csv(out / "mixed_stribeck.csv", columns, rows)
    draw(out, rows)


def draw(out: Path, rows: list[tuple[float, ...]]) -> None:
    """Friction left, shares right."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 3.9))
    for gamma, colour in ((math.inf, "C0"), (3.0, "C1"), (1.0, "C2")):
        part = np.array([r for r in rows if r[0] == gamma])
        name = "sealed (γ = ∞)" if math.isinf(gamma) else f"γ = {gamma:.0f}"
        left.errorbar(part[:, 1], part[:, 2], part[:, 3], fmt="o-", color=colour, ms=3, capsize=2, label=name)
        right.semilogx(part[:, 1], part[:, 4], "o--", color=colour, ms=3, label=f"asperity share, {name}")
        if math.isfinite(gamma):
            right.semilogx(part[:, 1], part[:, 5], "s-", color=colour, ms=3, label=f"roughness share, {name}")
    part = np.array([r for r in rows if r[0] == 1.0])
    valid = part[:, 6] <= 1.0
    right.semilogx(part[valid, 1], part[valid, 6], "k-", lw=1, label="Masjedi-Khonsari 2012 (from memory)")
    right.semilogx(part[:, 1], part[:, 7], "k:", lw=1, label="1 - erf λ")
    left.set(xscale="log", xlabel="λ", ylabel="friction coefficient", ylim=(0.0, None))
    right.set(xlabel="λ", ylabel="share of the load", ylim=(-0.02, 1.05))
    left.legend(fontsize=7)
    right.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.tight_layout()
    figure.savefig(out / "mixed_stribeck.png", dpi=130)
