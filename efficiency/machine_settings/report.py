"""Report sections of machine settings and corrections: settings, residuals, residual maps, warnings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ehl.common.quantities import quantity
from ehl.common.sections import Head, Medium, Section
from ehl.common.table import Column, Table

if TYPE_CHECKING:
    from efficiency.machine_settings.correction import MachineCorrections
    from efficiency.machine_settings.settings_result import FlankFit, SettingsResult

MAP_FROM = 1e-9  # largest residual above which a residual map is shown [m]


def settings_sections(result: SettingsResult, medium: Medium) -> list[Section]:
    """Settings, fit with warnings, and residual maps of flanks that do not meet their targets."""
    maps = [_map(flank) for flank in result.flanks if flank.fitted.largest > MAP_FROM]
    head = Head(f"Machine settings: {result.design.name}")
    return [Section("", [head, _settings(result), _fit(result), *maps])]


def correction_sections(result: MachineCorrections, medium: Medium) -> list[Section]:
    """New settings of the machine, and the deviations before and after correction."""
    tables = []
    for flanks in dict.fromkeys(item.flanks for item in result.corrections):
        own = [item for item in result.corrections if item.flanks == flanks]
        parts = {"change": "change", "uncertainty": "uncertainty", "before": "nominal", "to set": "corrected"}
        rows = [(part, *(getattr(item, name) for item in own)) for part, name in parts.items()]
        of = "both flanks" if flanks == "both" else f"{flanks} flank"
        settings = (Column(i.setting, label=i.setting.replace("_", " "), decimals=_decimals(i.setting)) for i in own)
        title = f"{result.design}, {result.member}, {of}: machine corrections"
        tables.append(Table(["setting", *settings], rows, title, name=f"corrections_{flanks}", vertical=True))
    fields = (
        *("deviation_rms", "deviation_max", "spiral_angle_error", "pressure_angle_error"),
        *("lengthwise_crowning", "profile_crowning", "twist"),
    )
    deviations = Table(
        ["flank", *(Column(name, label=name.replace("_", " "), decimals=2) for name in fields)],
        [(f"{item.flank}, {item.part}", *(getattr(item, name) for name in fields)) for item in result.deviations],
        "Deviation from nominal, positive for excess material",
        result.notes,
        name="deviations",
        vertical=True,
    )
    head = Head(f"Machine corrections: {result.design}, {result.member}")
    return [Section("", [head, *tables, deviations])]


def _decimals(setting: str) -> int:
    """Decimals of a setting in its display unit: 0.1 um, 0.36 arcsec, 1e-6."""
    return 4 if quantity(setting).display in ("mm", "deg") else 6


def _settings(result: SettingsResult) -> Table:
    """Settings of the design file, one column per flank."""
    columns = {}
    for member in ("pinion", "gear"):
        for side in ("concave", "convex"):
            given = getattr(getattr(result.design, member), side).model_dump()
            columns[f"{member} {side}"] = {name: value for table in given.values() for name, value in table.items()}
    names = dict.fromkeys(name for values in columns.values() for name in values)
    used = [name for name in names if any(values.get(name) not in (None, 0.0) for values in columns.values())]
    return Table(
        ["flank", *(Column(name, label=name.replace("_", " "), digits=6) for name in used)],
        [(flank, *(values.get(name) for name in used)) for flank, values in columns.items()],
        result.design.name,
        name="settings",
        vertical=True,
    )


def _fit(result: SettingsResult) -> Table:
    places = ("toe", "middle", "heel")
    rows = []
    for flank in result.flanks:
        fitted = flank.fitted
        root = list(fitted.root_error) or [None] * len(places)
        missing = len(flank.undercut)
        rows.append(
            (flank.side, fitted.rms, fitted.largest, missing, fitted.found.size, *root, flank.transmission_error)
        )
    return Table(
        [
            "pinion flank",
            "residual_rms",
            "residual_max",
            Column("undercut_points", label="undercut points"),
            Column("points", label="points of the grid"),
            *(Column(f"root_error_{place}", of="root_error", label=f"root error, {place}") for place in places),
            "transmission_error",
        ],
        rows,
        "fit",
        [
            *(f"warning: {warning}" for warning in result.warnings),
            f"{result.status}, {result.iterations} iterations, {result.seconds:.2f} s",
        ],
        vertical=True,
    )


def _map(flank: FlankFit) -> Table:
    """Residual over the gear flank: depth fraction over the rows with the tip on top, toe to heel over the columns."""
    along, deep = flank.grid.shape
    shape = (deep, along)
    residual, found = flank.fitted.residual.reshape(shape), flank.fitted.found.reshape(shape)
    u, depth = flank.grid.u.reshape(shape)[0], 0.5 * (flank.grid.y.reshape(shape)[:, 0] + 1.0)
    picked = range(0, along, 2)
    at = [f"{quantity('gear_u').to_display(float(u[k])):.1f}" for k in picked]
    return Table(
        [
            Column("depth", of="pattern_depth", label="depth", decimals=2),
            *(Column(f"at {text} mm", of="residual_max", label=f"{text} mm", decimals=1) for text in at),
        ],
        [
            (depth[row], *(residual[row, k] if found[row, k] else "undercut" for k in picked))
            for row in reversed(range(deep))
        ],
        f"residual of the {flank.side} pinion flank over the gear flank; columns: distance from the mean point to the "
        "heel; depth: 0 root, 1 tip",
        name=f"residual {flank.side}",
    )
