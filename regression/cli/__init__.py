"""Commands of the friction formula: `sweep`, `fit`, `mu`."""

from pathlib import Path
from typing import Annotated, Any

import typer

import ehl
import regression
from ehl import InputError
from ehl.common.console import FORMULA, App, JsonOption, advanced, check_outputs, given, print_json, print_text, working
from regression.cli.sweep import sweep_app


def fit(
    runs: Annotated[
        list[Path], typer.Argument(metavar="RUN...", help="Folders or files of results, or shipped datasets.")
    ],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FORMULA.json", help="The formula file.")],
    family: Annotated[str, typer.Option(help="best (by held-out error), network, or the name of one family.")] = "best",
    corners: Annotated[bool, typer.Option("--corners", help="Include the corner points of the plan.")] = False,
    paths: Annotated[Path | None, typer.Option(help="Run of contacts along gear meshes for validation.")] = None,
    noise: Annotated[
        Path | None,
        typer.Option(help="Run with several roughness profiles per point: noise floor, and errors of the means."),
    ] = None,
    oil: Annotated[
        str | None, advanced(help="The oil of the formula, if the data have several; all are used for training.")
    ] = None,
    nested: Annotated[
        bool, typer.Option("--nested", help="Cross-validate the choice of the family as well (minutes).")
    ] = False,
    plot: Annotated[Path | None, typer.Option(help="Write a figure of held-out over computed friction.")] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="FIT.html", help="Write one page on data, formulas, errors and failures.")
    ] = None,
    json_output: Annotated[bool, typer.Option("--json", help="Print the content of the formula file.")] = False,
) -> None:
    """Fit a friction formula to the results of one or more sweeps, with its errors."""
    check_outputs({"output": output, "plot": plot, "report": report}, output=".json")
    with working("fit"):
        formula = regression.fit(runs, family, corners=corners, nested=nested, paths=paths, noise=noise, oil=oil)
    formula.save(output)
    formula.write(plot=plot, report=report)
    if json_output:
        typer.echo(formula.to_json(), nl=False)
        return
    formula.show()
    typer.echo(f"written: {output}")


def mu(
    model: Annotated[str, typer.Argument(metavar="FORMULA", help="Formula file, registry name, or constant:VALUE.")],
    pressure: Annotated[str, typer.Option(help='Maximum Hertz pressure, "1.2 GPa".')],
    radius: Annotated[str, typer.Option(help='Equivalent radius, "10 mm".')],
    speed: Annotated[str, typer.Option(help='Entrainment speed (u1 + u2)/2, "5 m/s".')],
    slide_to_roll: Annotated[str, typer.Option(help="Sliding across the contact line over entrainment speed.")],
    temperature: Annotated[str, typer.Option(help='Oil temperature at the inlet, "80 degC".')],
    roughness_rms: Annotated[str, typer.Option(help='Composite Rq of both surfaces, "0.4 um".')] = "0 um",
    lengthwise: Annotated[str, typer.Option(help='Sliding along the contact line, "1 m/s".')] = "0 m/s",
    correlation_length: Annotated[
        str | None, advanced(help='Correlation length of each surface, "50 um"; default: 40 Rq.')
    ] = None,
    peklenik_number: Annotated[
        str | None, advanced(help="Correlation length along the contact line over that across it; 1 is isotropic.")
    ] = None,
    oil: Annotated[str | None, typer.Option(help="Oil card; default: that of the formula.")] = None,
    boundary_friction: Annotated[
        float | None, advanced(help="mu_b of the asperities, in place of that of the formula.", min=0.0, max=1.0)
    ] = None,
    refuse: Annotated[bool, advanced("--refuse", help="Reject a point outside the data (exit code 2).")] = False,
    hull: Annotated[
        list[Path] | None, advanced(metavar="RUN", help="Data of the formula, for an exact test of their convex hull.")
    ] = None,
    json_output: JsonOption = False,
) -> None:
    """Evaluate a friction formula at one contact point."""
    friction = regression.friction_model(model)
    if isinstance(friction, regression.Formula):
        friction = friction.with_options(boundary_friction, refuse=refuse)
    elif boundary_friction is not None or refuse or hull:
        option = "hull" if hull else "refuse" if boundary_friction is None else "boundary_friction"
        raise InputError(option, friction.name, "a fitted formula: a formula file, or a shipped one")
    name = oil or friction.default_oil()
    point: dict[str, Any] = {
        "pressure_hertz": pressure,
        "radius_equivalent": radius,
        "speed_entrainment": speed,
        "slide_to_roll": slide_to_roll,
        "temperature_oil": temperature,
        "roughness_rms": roughness_rms,
        "speed_sliding_lengthwise": lengthwise,
        **given({"correlation_length": correlation_length, "peklenik_number": peklenik_number}),
    }
    content: dict[str, Any] = friction.mu(oil=name, **point).to_dict()
    other = friction.oil_note(ehl.Oil.load(name)) if isinstance(friction, regression.Formula) else ""
    content |= {"friction_model": friction.name, "oil": name}
    if certainty := getattr(friction, "certainty", None):
        content["certainty"] = certainty
    if hull and isinstance(friction, regression.Formula):
        content["in_convex_hull"] = bool(friction.in_convex_hull(hull, oil=name, **point))
    spread = None if content["friction_coefficient"] is None else friction.uncertainty(oil=name, **point)
    if json_output:
        print_json(content | ({} if spread is None else {"uncertainty": spread.to_dict()}))
    else:
        _print_friction(content, friction.title)
        if spread is not None and spread.low < spread.high:
            print_text(f"inputs: mu = {'; '.join((spread.headline(), *spread.notes))}")
    outside = friction.range_note(oil=name, **point) if isinstance(friction, regression.Formula) else ""
    if outside or content["flag"] != "ok":
        typer.echo(f"note: {outside or content['flag'].replace('_', ' ')}", err=True)
    if other:
        typer.echo(f"note: {other}", err=True)
    if content["friction_coefficient"] is None:
        raise typer.Exit(1)


def _print_friction(content: dict[str, Any], label: str) -> None:
    """Print one friction value."""
    value = content["friction_coefficient"]
    line = "mu = none" if value is None else f"mu = {value:.5f}"
    if content["friction_lower"] is not None:
        line += f"  ({content['friction_lower']:.5f} to {content['friction_upper']:.5f})"
    if "in_convex_hull" in content:
        line += f"  {'inside' if content['in_convex_hull'] else 'outside'} the convex hull of its data"
    mark = "" if content.get("certainty", "found") == "found" else " (M: equation from memory, at least in part)"
    typer.echo(f"{line}  {label}{mark}, {content['oil']}")


def register(app: App) -> None:
    """Add the commands of this package to the application."""
    app.add_typer(sweep_app, name="sweep", rich_help_panel=FORMULA)
    app.command(rich_help_panel=FORMULA)(fit)
    app.command(rich_help_panel=FORMULA)(mu)
