"""Design and targets files of machine settings."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from pydantic import BaseModel

from efficiency.blanks.pair_blank import MemberBlank, PairBlank
from efficiency.cutting.cutter import FLANK_SIDES, FlankSide
from efficiency.cutting.flank import CutFlank, index_start
from efficiency.cutting.machine import MachineSettings, machine_table
from efficiency.cutting.process import PROCESSES, CuttingProcess
from efficiency.machine_settings.fit import FittedFlank
from efficiency.machine_settings.generating import tilt_and_swivel
from efficiency.machine_settings.inputs import FlankTarget, SettingsInput
from ehl.common.files import toml_text
from ehl.common.quantities import Quantity, quantities
from ehl.common.units import ARCSEC, KELVIN
from ehl.common.validation import value_range_of

Value = str | float | int
Table = dict[str, Value]


def _written(name: str, value: Value) -> Value:
    """A value of a design file with its unit; lengths to 0.1 nm, angles to 1e-9 rad."""
    if isinstance(value, str | int):
        return value
    number, unit = float(value), quantities().get(name, Quantity(name)).unit
    if unit == "m":
        return f"{_short(number * 1e3, 7)} mm"
    return f"{_short(np.degrees(number), 8)} deg" if unit == "rad" else float(f"{number:.10g}")


def _short(value: float, digits: int) -> str:
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def _tables(content: Iterable[tuple[str, Table]]) -> str:
    whole: dict[str, Any] = {}
    for name, table in content:
        inner = whole
        for part in name.split(".") if name and table else ():
            inner = inner.setdefault(part, {})
        inner |= {key: _written(key, value) for key, value in table.items()}
    return toml_text(whole)


def machine_tables(member: str, machines: Mapping[FlankSide, MachineSettings]) -> str:
    """Machine settings of flanks as tables of a design file."""
    return _tables((f"{member}.{side}.machine", machine_table(machine)) for side, machine in machines.items())


def ease_off_table(target: FlankTarget, scale: float) -> Table:
    """Ease-off table of a conjugate pinion flank."""
    return {
        "lengthwise_crowning": scale * target.crowning_toe,
        "profile_crowning": scale * target.relief_tip,
        "bias": target.bias,
        "twist": scale * target.twist,
        "contact_face": target.contact_face,
        "contact_depth": target.contact_depth,
    }


PinionFlanks = dict[FlankSide, CutFlank] | dict[FlankSide, Table]
FittedFlanks = dict[FlankSide, FittedFlank]


def _member(
    name: str, blank: MemberBlank, flanks: PinionFlanks, extra: Table, process: CuttingProcess
) -> list[tuple[str, Table]]:
    tables: list[tuple[str, Table]] = [(name, extra), (f"{name}.blank", blank.cones.model_dump())]
    cut: dict[FlankSide, CutFlank] = {}
    for side, flank in flanks.items():
        if isinstance(flank, CutFlank):
            cut[side] = flank
        else:
            tables.append((f"{name}.{side}.ease_off", flank))
    if not cut:
        return tables
    mirror = 1.0 if blank.hand == "right" else -1.0
    machines = {side: machine_table(cut[side].machine) for side in FLANK_SIDES}
    cutters = {side: process.cutter_table(cut[side].blade, mirror) for side in FLANK_SIDES}
    shared_machine = machines["concave"] == machines["convex"]
    if shared_machine:
        tables.append((f"{name}.machine", machines["concave"]))
    shared = {key: value for key, value in cutters["concave"].items() if cutters["convex"][key] == value}
    tables.append((f"{name}.cutter", shared))
    for side in FLANK_SIDES:
        own = {key: value for key, value in cutters[side].items() if key not in shared}
        tables.append((f"{name}.{side}.cutter", own))
        if not shared_machine:
            tables.append((f"{name}.{side}.machine", machines[side]))
    return tables


def written_flank(flank: CutFlank, phase: float) -> CutFlank:
    """A fitted flank in the conventions of a design file: tilt and swivel, indexing from the mean point, blade phase.

    In face milling the rotation of a flank about its axis is not a setting and is omitted.
    """
    flank = tilt_and_swivel(flank)
    start = index_start(flank.machine, flank.blank)
    if not flank.index_ratio:
        return CutFlank(flank.blade, flank.machine, flank.blank, start)
    ahead = flank.blade.phase + flank.index_zero - start - phase / flank.index_ratio
    # the axes of a two-part head keep their direction
    turned = flank.blade.eccentricity_angle + flank.index_zero - start if flank.blade.eccentricity else 0.0
    ahead, turned = (float(np.angle(np.exp(1j * angle))) for angle in (ahead, turned))
    blade = replace(flank.blade, phase=ahead, eccentricity_angle=turned)
    return CutFlank(blade, flank.machine, flank.blank, start)


def header(inputs: SettingsInput, fitted: FittedFlanks) -> list[str]:
    """Comment of a design file: origin and choices."""
    cutting, blank = inputs.cutting, inputs.blank
    conjugate = cutting.pinion == "conjugate"
    lines = [
        f"{inputs.name}: made by `mixed-ehl settings` from a blank and contact targets.",
        f"Blank: {blank.source or blank.name} (ISO 23509 Method {blank.method}).",
        f"Gear: {cutting.gear}, {blank.process}.",
    ]
    if conjugate:
        lines.append("Pinion: no settings; its flanks are the conjugate ones less an ease-off, possibly not cuttable.")
        lines.append("Ease-off in um at the ends of the face and of the working depth of the gear:")
    else:
        machine = f"{cutting.pinion}, {cutting.machine} machine"
        lines.append(f"Pinion: {machine}, fitted to the conjugate flank plus ease-off, in um")
        lines.append("at the ends of the face and of the working depth of the gear:")
    for side in FLANK_SIDES:
        target, state = inputs.targets.of(side), fitted[side]
        chosen = (
            f"toe {target.crowning_toe * 1e6:.4g}, heel {target.crowning_heel * 1e6:.4g}, "
            f"root {target.relief_root * 1e6:.4g}, tip {target.relief_tip * 1e6:.4g}"
        )
        moved = {"bias": target.bias, "contact_face": target.contact_face, "contact_depth": target.contact_depth}
        chosen += "".join(f", {name} {value:.4g}" for name, value in moved.items() if value)
        if target.twist:
            chosen += f", twist {target.twist * 1e6:.4g}"
        if target.transmission_error is not None:
            chosen += f", scaled to {target.transmission_error / ARCSEC:.4g} arcsec"
        lost = int(np.sum(~state.found))
        residual = f"residual {state.rms * 1e6:.2f} um rms, {state.largest * 1e6:.2f} um at most, "
        lines.append(f"  {side} pinion flank: {chosen};")
        lines.append(f"    {'' if conjugate else residual}{lost} of {state.found.size} points undercut.")
    lines += [
        "Machine settings and cutters are constructed, not published; ease-off, operating point, oil, material and",
        "roughness are our choice unless the source states them. No fillet is defined.",
    ]
    return lines


def design_text(
    inputs: SettingsInput, blank: PairBlank, pinion: PinionFlanks, gear: dict[FlankSide, CutFlank], head: Iterable[str]
) -> str:
    """Text of the design file."""
    operation = inputs.operation
    lengths = {"hypoid_offset": blank.hypoid_offset, "normal_backlash": blank.backlash_normal}
    offset, backlash = (f"{_short(value * 1e3, 7)} mm" for value in lengths.values())
    shaft_angle = f"{_short(np.degrees(blank.shaft_angle), 8)} deg"
    assembly: Table = {"shaft_angle": shaft_angle, "hypoid_offset": offset, "drive_flank_pinion": "concave"}
    running: Table = {
        "torque": f"{operation.torque:.6g} N m",
        "speed": f"{operation.speed * 30.0 / np.pi:.6g} rpm",
        "temperature": f"{operation.temperature - KELVIN:.6g} degC",
        "oil": operation.oil,
    }
    tables: list[tuple[str, Table]] = [
        ("", {"name": inputs.name, "source": inputs.source or inputs.blank.source}),
        ("assembly", assembly | {"normal_backlash": backlash}),
        ("operation", running),
    ]
    for name, chosen, member, flanks in (
        ("pinion", inputs.pinion, blank.pinion, pinion),
        ("gear", inputs.gear, blank.gear, gear),
    ):
        extra: Table = {"material": chosen.material}
        if chosen.finish is not None:
            extra["finish"] = chosen.finish
        if chosen.finish is None or "roughness_rms" in chosen.model_fields_set:
            extra["roughness_rms"] = f"{chosen.roughness_rms * 1e6:.6g} um"
        if member.mounting_distance is not None:
            extra["mounting_distance"] = f"{_short(member.mounting_distance * 1e3, 8)} mm"
        tables += _member(name, member, flanks, extra, PROCESSES[blank.process])
        for edge, relief in chosen.edge_relief:
            if relief is not None:
                tables.append((f"{name}.edge_relief.{edge}", relief.model_dump()))
    comment = "".join(f"# {line}".rstrip() + "\n" for line in head)
    return comment + "\n" + _tables(tables)


def targets_text(inputs: SettingsInput, comment: str) -> str:
    """Text of a targets file with the given values, without defaults."""
    return f"# {comment}\n\n" + toml_text(_given(inputs))


def _given(model: BaseModel) -> dict[str, Any]:
    """The given values of a model as a table of a file."""
    table: dict[str, Any] = {}
    for key in type(model).model_fields:
        value = getattr(model, key)
        if key not in model.model_fields_set or value is None:
            continue
        if isinstance(value, BaseModel):
            value = _given(value)
        elif isinstance(value, float):
            value = _with_unit(type(model), key, value)
        if value != {}:
            table[key] = value
    return table


def _with_unit(model: type[BaseModel], key: str, value: float) -> Value:
    """A value with a usual unit and ten digits."""
    unit = value_range_of(model, key).unit
    shown, factor, shift = {
        "m": ("mm", 1e3, 0.0) if abs(value) >= 1e-3 else ("um", 1e6, 0.0),
        "rad": ("deg", 180.0 / np.pi, 0.0),
        "rad/s": ("rpm", 30.0 / np.pi, 0.0),
        "K": ("degC", 1.0, -KELVIN),
    }.get(unit, (unit, 1.0, 0.0))
    number = float(f"{value * factor + shift:.10g}")
    return f"{number!r} {shown}" if unit else number
