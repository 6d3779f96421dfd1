"""Commands of the friction formula: `sweep`, `fit`, `mu`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from ehl.io.errors import InputError
from regression.cli.sweep import sweep_app


def fit(
    runs: Annotated[
        list[Path], typer.Argument(metavar="RUN...", help="Folders or files of results, or shipped datasets.")
    ],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FORMULA.json", help="The formula file.")],
    family: Annotated[str, typer.Option(help="best (by held-out error), or the name of one family.")] = "best",
    gaussian_process: Annotated[
        bool, typer.Option("--gaussian-process", help="Correct what the family leaves by a Gaussian process.")
    ] = False,
    corners: Annotated[bool, typer.Option("--corners", help="Fit the corner points of the plan too.")] = False,
    paths: Annotated[Path | None, typer.Option(help="Run of contacts along gear meshes: checked, not fitted.")] = None,
    noise: Annotated[Path | None, typer.Option(help="Run of repeated roughness realisations: noise floor.")] = None,
    nested: Annotated[bool, typer.Option("--nested", help="Hold the choice of the family out too (minutes).")] = False,
    plot: Annotated[Path | None, typer.Option(help="Write a figure of held-out over computed friction.")] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="FIT.html", help="Write one page on data, formulas, errors and failures.")
    ] = None,
    json_output: Annotated[bool, typer.Option("--json", help="Print the formula file's content.")] = False,
) -> None:
    """Fit a friction formula to the results of one or more sweeps, and say what it is worth."""
    from regression.cli.files import FIGURE, check_outputs
    from regression.data.dataset import load_dataset
    from regression.fitting.cross_validation import process_factors
    from regression.fitting.fit import fit_families, fit_formula
    from regression.friction.families import FAMILIES, family_named
    from regression.view.report import families_table, formula_report

    check_outputs({"--output": output, "--plot": plot, "--report": report}, {"--plot": FIGURE})
    if family != "best":
        family_named(family)
        if nested:
            raise InputError("--nested", family, "--family best", "One family leaves no choice to hold out.")
    dataset = load_dataset(*runs)
    beside: dict[str, Any] = {
        "corners": corners,
        "gaussian_process": gaussian_process,
        "paths": None if paths is None else load_dataset(paths),
        "noise": None if noise is None else load_dataset(noise),
    }
    if family == "best":
        formulas = list(fit_families(dataset, nested=nested, **beside).values())
    else:
        formulas = [fit_formula(dataset, family, **beside)]
    formulas[0].save(output)
    if plot is not None:
        from ehl.view.plots import save_figure
        from regression.view.plots import plot_parity

        save_figure(plot_parity(dataset, formulas), plot)
    if report is not None:
        from regression.view.fit_report import write_fit_report

        write_fit_report(report, dataset, formulas, FAMILIES if family == "best" else [family])
    if json_output:
        typer.echo(formulas[0].to_json(), nl=False)
        return
    families_table(formulas, FAMILIES if family == "best" else [family])
    formula_report(formulas[0], process_factors(dataset, formulas[0]))
    typer.echo(f"written: {output}")


def mu(
    model: Annotated[str, typer.Argument(metavar="FORMULA", help="Formula file, registry name, or constant:VALUE.")],
    pressure: Annotated[str, typer.Option(help='Maximum Hertz pressure, "1.2 GPa".')],
    radius: Annotated[str, typer.Option(help='Equivalent radius, "10 mm".')],
    speed: Annotated[str, typer.Option(help='Entrainment speed (u1 + u2)/2, "5 m/s".')],
    slide_to_roll: Annotated[str, typer.Option(help="Sliding across the contact line over entrainment speed.")],
    temperature: Annotated[str, typer.Option(help='Oil temperature at the inlet, "80 degC".')],
    roughness: Annotated[str, typer.Option(help='Composite Rq of both surfaces, "0.4 um".')] = "0 um",
    lengthwise: Annotated[str, typer.Option(help='Sliding along the contact line, "1 m/s".')] = "0 m/s",
    correlation_length: Annotated[str, typer.Option(help='Of the roughness of either surface, "50 um".')] = "30 um",
    oil: Annotated[str | None, typer.Option(help="Oil card; the formula's own if not given.")] = None,
    boundary_friction: Annotated[
        float | None, typer.Option(help="mu_b of the asperities in place of the formula's own.", min=0.0, max=1.0)
    ] = None,
    refuse: Annotated[bool, typer.Option("--refuse", help="Refuse a point outside the data (exit code 2).")] = False,
    hull: Annotated[
        list[Path] | None, typer.Option(metavar="RUN", help="The formula's data: test their convex hull exactly.")
    ] = None,
    json_output: Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.")] = False,
) -> None:
    """Evaluate a friction formula at one contact point."""
    from ehl.fluid.oil import Oil
    from ehl.material import effective_modulus, load_material
    from ehl.state import ContactState
    from ehl.view.report import print_json
    from regression.cli.values import POINT, check_point, in_hull_of, oil_of, with_options
    from regression.formula import friction_model
    from regression.view.report import friction_content, friction_line

    friction = with_options(friction_model(model), boundary_friction, refuse)
    given = (pressure, radius, speed, slide_to_roll, temperature, roughness, lengthwise, correlation_length)
    values = check_point(dict(zip(POINT, given, strict=True)))
    composite = values.pop("roughness_rms") / 2.0**0.5
    steel = load_material("steel")
    name = oil_of(friction, oil)
    state = ContactState.of(
        **values,
        effective_modulus=effective_modulus(steel, steel),
        roughness_rms_1=composite,
        roughness_rms_2=composite,
    )
    card = Oil.load(name)
    content = friction_content(friction.name, name, friction.evaluate(state, card))
    if hull:
        content["in_convex_hull"] = in_hull_of(friction, hull, state, card)
    if json_output:
        print_json(content)
    else:
        friction_line(content)
    if content["flag"] != "ok":
        typer.echo(f"note: {content['flag'].replace('_', ' ')}", err=True)
    if content["friction_coefficient"] is None:
        raise typer.Exit(1)


def register(app: typer.Typer) -> None:
    """Add the commands of this package to the application."""
    app.add_typer(sweep_app, name="sweep")
    app.command()(fit)
    app.command()(mu)
