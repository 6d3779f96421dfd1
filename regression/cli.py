"""Commands of the friction formula: `sweep`, `fit`, `mu`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from regression.cli_sweep import sweep_app


def fit(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder or file of results.")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FORMULA.json", help="The formula file.")],
    family: Annotated[str, typer.Option(help="best (by held-out error), xu, power_law or load_share.")] = "best",
    corners: Annotated[bool, typer.Option("--corners", help="Fit the corner points of the plan too.")] = False,
    plot: Annotated[Path | None, typer.Option(help="Write a figure of fitted over computed friction.")] = None,
    json_output: Annotated[bool, typer.Option("--json", help="Print the formula file's content.")] = False,
) -> None:
    """Fit a friction formula to the results of a sweep, and say what it is worth."""
    from regression.dataset import load_dataset
    from regression.families import FAMILIES
    from regression.fit import fit_families, fit_formula
    from regression.report import families_table, formula_report

    dataset = load_dataset(run)
    if family == "best":
        formulas = list(fit_families(dataset, corners=corners).values())
    else:
        formulas = [fit_formula(dataset, family, corners=corners)]
    formulas[0].save(output)
    if plot is not None:
        from ehl.plots import save_figure
        from regression.plots import plot_parity

        save_figure(plot_parity(dataset, formulas), plot)
    if json_output:
        typer.echo(formulas[0].to_json(), nl=False)
        return
    families_table(formulas, FAMILIES if family == "best" else [family])
    formula_report(formulas[0])
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
    oil: Annotated[str | None, typer.Option(help="Oil card; the formula's own if not given.")] = None,
    json_output: Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.")] = False,
) -> None:
    """Evaluate a friction formula at one contact point."""
    from ehl.material import effective_modulus, load_material
    from ehl.oil import Oil
    from ehl.report import print_json
    from ehl.state import ContactState
    from regression.cli_values import POINT, check_point, oil_of
    from regression.friction_models import friction_model
    from regression.report import friction_content, friction_line

    friction = friction_model(model)
    given = (pressure, radius, speed, slide_to_roll, temperature, roughness, lengthwise)
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
    content = friction_content(friction.name, name, friction.evaluate(state, Oil.load(name)))
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
