"""Commands of one gear pair: `gear`, `map`, `duty`, `geometry`, `compare`, `demo`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import efficiency
from efficiency.cli import options as shared
from ehl import InputError
from ehl.common import console
from ehl.common.console import advanced, check_outputs, fail_unless_converged, is_list, working

LoadFromOption = Annotated[Path | None, advanced(help="CSV file with a load distribution of another program.")]
_GearConditions: Any = shared.group(**shared.CONDITIONS, bulk=shared.BulkOption)
_GearOptions: Any = shared.group(
    uncertainty=shared.switch(
        "--uncertainty", "Contribution of each input to the interval; with ehl from solved contacts (minutes)."
    ),
    strength=shared.switch("--strength", "With --json: include the strength of the teeth."),
    load_from=LoadFromOption,
    save_load=Annotated[Path | None, advanced(help="Write the load distribution as CSV, the format of --load-from.")],
)


def _pair(design: str, misalignment: dict[str, Any]) -> efficiency.GearPair:
    return efficiency.load(design).misaligned(**misalignment)


def gear(
    *,
    design: shared.DesignArgument,
    friction: shared.FrictionOption = None,
    conditions: _GearConditions,
    files: shared.FileOptions,
    misalignment: shared.MisalignmentOptions,
    more: _GearOptions,
    rating: Annotated[
        bool, advanced("--rating", help="Only the load capacity by ISO 10300: stresses, S_H and S_F of both flanks.")
    ] = False,
    spectrum: Annotated[Path | None, advanced(help="With --rating: duty cycle (CSV, XLSX) as load spectrum.")] = None,
) -> None:
    """Efficiency of a gear pair at one operating point: contact, load, friction, power loss, strength."""
    check_outputs({"save_load": more.get("save_load")})
    _refuse_lists(conditions)
    pair = _pair(design, misalignment)
    if rating:
        at = {name: conditions.pop(name) for name in ("torque", "speed") if name in conditions}
        shared.refuse("--rating", {**conditions, "friction": friction, **more, **misalignment})
        shared.present(pair.rating(**at, duty=spectrum), **files)
        return
    if spectrum is not None:
        raise InputError("spectrum", str(spectrum), "only together with --rating")
    if "load_from" in more:
        shared.refuse("--load-from", {"bulk": conditions.get("bulk"), "uncertainty": more.get("uncertainty")})
    [model] = pair.check([friction], **conditions)
    mesh, at = pair.mesh(conditions.pop("side", "drive")), conditions.pop("torque", None)
    with working("gear pair"):
        loaded = mesh.load_from(more["load_from"], at) if "load_from" in more else mesh.load(at)
        result = loaded.efficiency(model, **conditions)
        if "save_load" in more:
            loaded.write_load(more["save_load"], result)
        if "uncertainty" in more and result.status == "converged":
            result = result.with_inputs(result.uncertainty(solved=True))
    content = {}
    if "json_output" in files:
        parts = {"drawing": pair.drawing(), "strength": result.strength if "strength" in more else None}
        content = {name: part.to_dict() for name, part in parts.items() if part is not None}
    shared.present(result, more=content, **files)


_MapOptions: Any = shared.group(
    strength=shared.StrengthOption,
    interval=shared.switch("--interval", "Add columns of the 90 % interval from uncertain inputs."),
    every_point=shared.switch("--every-point", "Solve every point without interpolation."),
)


def map_points(
    *,
    design: shared.DesignArgument,
    friction: shared.FrictionOption = None,
    conditions: shared.ConditionOptions,
    files: shared.FileOptions,
    misalignment: shared.MisalignmentOptions,
    more: _MapOptions,
) -> None:
    """Efficiency of a gear pair over torque, speed and temperature.

    Each quantity is one value, a list '100, 200, 300 N m' or a range '50:200:4 N m'; its default is that of the design.
    """
    pair = _pair(design, misalignment)
    [model] = pair.check([friction], **conditions)
    with working("operating points"):
        grid = pair.mesh(conditions.pop("side", "drive")).map(model, **more, **conditions)
    shared.present(grid, **files)


_RecordingOptions: Any = shared.group(
    tyre_radius=shared.text_option(shared.TYRE, panel=None),
    ratio=Annotated[
        float | None, typer.Option(help="Pinion revolutions per wheel revolution; default: that of the pair.")
    ],
    temperature=shared.text_option("Oil temperature if the file has none.", panel=None),
)


def duty(
    *,
    design: shared.DesignArgument,
    file: Annotated[
        Path, typer.Argument(metavar="DUTY", help="Duty cycle, CSV or XLSX: torque, speed, temperature, hours.")
    ],
    friction: shared.FrictionOption = None,
    conditions: shared.HeldOptions,
    files: shared.TableOptions,
    misalignment: shared.MisalignmentOptions,
    recorded: _RecordingOptions,
) -> None:
    """Energies of a gear pair over a duty cycle, by row and in total."""
    pair = _pair(design, misalignment)
    [model] = pair.check([friction], **conditions)
    with working("duty cycle"):
        cycle = pair.duty(file, model, **recorded, **conditions)
    shared.present(cycle, **files)


def geometry(
    *,
    design: shared.DesignArgument,
    side: Annotated[str, typer.Option(help="Flanks in contact: drive, coast or both.")] = "both",
    marking: shared.MarkingOption = None,
    files: shared.PageOptions,
    misalignment: shared.MisalignmentOptions,
) -> None:
    """Geometry and unloaded contact of a gear pair: ease-off, contact pattern, transmission error, contact ratios."""
    shape = _pair(design, misalignment).geometry(side, marking)
    shared.present(shape, **files)


def _refuse_lists(conditions: dict[str, str]) -> None:
    for name in ("torque", "speed", "temperature"):
        if is_list(text := conditions.get(name, "")):
            raise InputError(name, text, "one value", "Use mixed-ehl map for lists and ranges.")


def compare(
    *,
    design: shared.DesignArgument,
    friction: Annotated[
        list[str] | None,
        typer.Option(help="Friction model; repeat for several. Default: constants, published formulas, ehl."),
    ] = None,
    conditions: shared.ConditionOptions,
    duty: Annotated[Path | None, advanced(help="Duty cycle, CSV or XLSX: energy by model as well.")] = None,
    load_from: LoadFromOption = None,
    files: shared.FigureOptions,
) -> None:
    """Compare friction models, constant mu and closed forms on one gear pair."""
    _refuse_lists(conditions)
    pair = efficiency.load(design)
    models = pair.check(friction or (), **conditions) or None
    side, at = conditions.pop("side", "drive"), conditions.pop("torque", None)
    if load_from is not None:
        shared.refuse("--load-from", {"duty": duty})
    with working("comparison"):
        if load_from is None:
            comparison = pair.compare(models, at, side=side, duty=duty, **conditions)
        else:
            comparison = pair.mesh(side).load_from(load_from, at).compare(models, **conditions)
    shared.present(comparison, **files)


def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the results.")] = Path("mixed-ehl-demo"),
    jobs: console.JobsOption = None,
) -> None:
    """Run a complete example: sweep, fit, gear, compare, one HTML report."""
    kept = f"solved contacts are kept in {output}, the same command resumes"
    with working("demonstration", kept):
        result = efficiency.demo(output, jobs)
    result.comparison.show()
    print(f"report: {output / 'report.html'}")
    fail_unless_converged(result.comparison.status, result.comparison.reason)
