"""Command `optimise`: ease-off and blank with less loss."""

from pathlib import Path
from typing import Annotated, Any

import efficiency
from efficiency.cli import options as shared
from ehl import InputError
from ehl.common.console import advanced, output_folder, pairs, working


@shared.with_groups
def optimise(
    *,
    targets: shared.TargetsArgument,
    output: Annotated[
        Path, shared.output_option("--output", "-o", help="Folder for page, designs, tables and figures.")
    ] = Path("mixed-ehl-optimise"),
    vary: Annotated[
        list[str] | None,
        advanced(
            help="A variable, with bounds or without: 'lengthwise_crowning=20:120 um', 'bias', 'hypoid_offset'; repeat "
            "for several. 'ease_off' (the default) and 'blank' select the usual ones, without the offset."
        ),
    ] = None,
    objective: Annotated[
        list[str] | None,
        advanced(
            help="Quantity to minimise, the most important first; default: power_loss, pressure_hertz_max, "
            "transmission_error_loaded."
        ),
    ] = None,
    limit: Annotated[
        list[str] | None,
        advanced(
            help="Quantity that may not exceed that of the start, or a value: 'pressure_hertz_max=1.4 GPa'; 'none' for "
            "none. Default: pressure, transmission error, edge load, root stresses, not above those of the start."
        ),
    ] = None,
    duty: Annotated[
        Path | None,
        shared.operation(
            metavar="FILE",
            help="Duty cycle, CSV or XLSX: torque, speed, temperature, hours. Default: the targets' operating point.",
        ),
    ] = None,
    friction: Annotated[
        str | None, shared.operation(help="Friction formula; default: the one shipped for the oil.")
    ] = None,
    oil: shared.OilOption = None,
    misalignment: Annotated[
        dict[str, Any],
        shared.misalignment_group(
            "Half width of E in the misalignment box; default '0.05 mm', '0 mm' for none.",
            "Half width of P; default '0.05 mm'.",
            "Half width of G; default none.",
            "Half width of the shaft angle; default none.",
        ),
    ],
    tolerance: Annotated[
        list[str] | None,
        advanced(help="Manufacturing error (half width): 'lengthwise_crowning=5 um'; repeat for several."),
    ] = None,
    over: Annotated[
        str, advanced(help="Loss over the box of misalignments: mean or worst; other quantities: worst.")
    ] = "mean",
    flanks: Annotated[str, advanced(help="Flanks whose ease-off is varied: drive, coast or both.")] = "drive",
    evaluations: Annotated[int, advanced(help="Evaluations of the search.")] = 120,
    batch: Annotated[int, advanced(help="Parallel evaluations.")] = 4,
    check: Annotated[int, advanced(help="Points checked on the full mesh.")] = 4,
    check_friction: Annotated[
        str | None, advanced(help="Check the gain of the best point with solved contacts: 'ehl' (minutes).")
    ] = None,
    seed: Annotated[int, advanced(min=0, help="Seed of the random numbers.")] = 1,
    sized: Annotated[
        bool,
        advanced("--sized", help="First size the start for its torque, as `settings --sized` does."),
    ] = False,
    jobs: shared.JobsOption = None,
    dask: shared.DaskOption = None,
    fresh: shared.FreshOption = False,
    json_output: shared.JsonOption = False,
) -> None:
    """Search ease-off and blank of a pair for less loss within limits of pressure, transmission error, edges and roots.

    Writes the Pareto front, and each checked point as a design file for `gear`. The same command resumes an
    interrupted search. The exit code is 1 if no better point lies within the limits.
    """
    store = shared.started_store(output, fresh)
    box = {"E": "0.05 mm", "P": "0.05 mm"} | misalignment
    chosen: dict[str, Any] = {"objectives": objective, "limits": _limits(limit), "duty": duty, "misalignment": box}
    chosen |= {"tolerance": pairs("tolerance", tolerance), "over": over, "flanks": flanks}
    chosen |= {"friction": friction, "oil": oil}
    chosen |= {"evaluations": evaluations, "batch": batch, "check": check, "solved": check_friction, "seed": seed}
    chosen |= {"sized": sized, "jobs": jobs, "dask": dask, "store": store}
    with output_folder(output), working("optimisation", shared.kept("evaluations", store, fresh)):
        result = efficiency.optimise(targets, _variables(vary), **chosen)
    shared.present_folder(result, json_output, output)


def _parts(texts: list[str]) -> list[tuple[str, str, str]]:
    """Name, equals sign and value of each text ``NAME=VALUE`` or ``NAME``."""
    parts = [text.partition("=") for text in texts]
    return [(name.strip(), equals, value.strip()) for name, equals, value in parts]


def _variables(texts: list[str] | None) -> dict[str, Any] | None:
    return {name: bounds if equals else None for name, equals, bounds in _parts(texts)} if texts else None


def _limits(texts: list[str] | None) -> dict[str, Any] | None:
    if not texts:
        return None
    if "none" in texts:
        if len(texts) > 1:
            raise InputError("limit", "none", "not together with another limit")
        return {}
    return {name: value if equals else "start" for name, equals, value in _parts(texts)}
