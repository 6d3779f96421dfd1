"""Commands of one contact, its oil and its roughness: `solve`, `oil`, `profile`."""

from pathlib import Path
from typing import Annotated, Any

import typer

import ehl
from ehl.common import console as shared


def solve(
    case_file: Annotated[Path, typer.Argument(metavar="CASE.toml", help="Input file of one contact.")],
    json_output: shared.JsonOption = False,
    plot: Annotated[Path | None, typer.Option(help="Write a figure of the solution (PNG, SVG, PDF).")] = None,
    report: Annotated[Path | None, typer.Option(help="Write one HTML page with results, notes and figure.")] = None,
    uncertainty: Annotated[
        bool, typer.Option("--uncertainty", help="Uncertainty of mu from the inputs (about twenty solutions).")
    ] = False,
    cite: Annotated[
        bool, typer.Option("--cite", help="References of the laws and methods used; BibTeX with --json.")
    ] = False,
) -> None:
    """Solve one lubricated contact.

    The exit code is 1 if there is no result, otherwise 0, even if the error exceeds the tolerance (status unsettled).
    """
    shared.check_outputs({"plot": plot, "report": report})
    contact = ehl.Contact.from_file(case_file)
    result = contact.solve()
    # a page contains the input uncertainty if it takes only seconds
    quick = report is not None and result.seconds < _QUICK
    spread = None
    if (uncertainty or quick) and result.status != "failed":
        typer.echo("uncertainty from the inputs: about twenty further solutions", err=True)
        spread = contact.uncertainty()
    try:  # files first, as standard output may be closed
        result.write(report=report, plot=plot if result.status != "failed" else None, uncertainty=spread)
    finally:
        more = {} if spread is None else {"uncertainty": spread.to_dict()}
        shared.print_result(result, json_output, more, cite=cite, uncertainty=spread)
    if result.status != "converged":
        typer.echo(result.outcome, err=True)
    if result.status == "failed":
        raise typer.Exit(1)


_QUICK = 1.0  # largest wall time of one solution for which a page includes the input uncertainty [s]


def _oil_list() -> ehl.Table:
    """The shipped oils."""
    cards = [ehl.Oil.load(name) for name in ehl.shipped("oils")]
    names = ("viscosity_kinematic_40", "viscosity_kinematic_100")
    rows = [
        [card.name, card.base, *(getattr(card, name) for name in names), card.at(373.15).alpha,
         f"{100.0 * card.uncertainty.pressure_viscosity:.3g} %", card.description]
        for card in cards
    ]  # fmt: skip
    alpha = ehl.quantity("pressure_viscosity_slope")
    heads = ["oil", "base", *names, alpha.name, "ln(eta/eta0) +-", "description"]
    note = (
        "alpha is at 100 degC. Describe other oils by base and viscosity: cSt at 40/100 degC ('pao 97.5/13.3'), "
        "cSt at 40 degC and viscosity index ('pao 97.5 vi 145'), or ISO VG ('mineral vg 220')."
    )
    return ehl.Table(heads, rows, title="Oils", notes=[note])


def oil(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME",
            help="Shipped oil, card.toml, 'pao 97.5/13.3', 'pao 97.5 vi 145' or 'mineral vg 220'.",
            autocompletion=shared.names_of("oils"),
        ),
    ] = None,
    temperature: Annotated[
        str | None, typer.Option("--temperature", "-T", help="Temperatures, e.g. '40, 80, 120 degC'.")
    ] = None,
    base: Annotated[
        str | None, typer.Option(help="Generic oil: mineral, hydrocracked, pao, ester or polyglycol.")
    ] = None,
    nu40: Annotated[str | None, typer.Option(help="Viscosity of the generic oil at 40 degC, e.g. '97.5 cSt'.")] = None,
    nu100: Annotated[str | None, typer.Option(help="Viscosity of the generic oil at 100 degC.")] = None,
    vg: Annotated[int | None, typer.Option(help="ISO VG of the generic oil, instead of both viscosities.")] = None,
    vi: Annotated[float | None, typer.Option(help="Viscosity index, instead of one of the viscosities.")] = None,
    density: Annotated[str | None, typer.Option(help="Density of the generic oil at 15 degC.")] = None,
    json_output: shared.JsonOption = False,
    plot: Annotated[Path | None, typer.Option(help="Write a figure of viscosity over pressure.")] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Write the oil card as a TOML file.")] = None,
) -> None:
    """Show the properties of an oil with their uncertainty, or list the shipped oils if no NAME is given."""
    shared.check_outputs({"plot": plot, "output": output})
    generic: dict[str, Any] = shared.given(
        {"nu_40": nu40, "nu_100": nu100, "iso_vg": vg, "viscosity_index": vi, "density_15": density}
    )
    for field, unit in (("nu_40", "m^2/s"), ("nu_100", "m^2/s"), ("density_15", "kg/m^3")):
        if field in generic:
            shared.parse_quantity(generic[field], unit, field=field, bare=False)
    if base is not None or generic:
        if base is None or name is not None:
            hint = "Give NAME, or --base with --vg or two of --nu40, --nu100 and --vi."
            raise ehl.InputError("base", base, "mineral, hydrocracked, pao, ester or polyglycol, without NAME", hint)
        card = ehl.Oil.generic(base, **generic, name=None if output is None else output.stem)
    elif name is None:
        table = _oil_list()
        shared.print_json({"oils": table.records()}) if json_output else table.print()
        return
    else:
        card = ehl.Oil.load(name)
    card.write(plot=plot, temperatures=temperature)
    if output is not None:
        card.save(output)
    if json_output:
        shared.print_json(card.to_dict(temperature))
        return
    card.show(temperatures=temperature)


def profile(
    file: shared.ProfileArgument,
    unit_x: shared.UnitXOption = "",
    unit_height: shared.UnitHeightOption = "",
    detrend: shared.DetrendOption = 2,
    cutoff_long: shared.CutoffLongOption = None,
    cutoff_short: shared.CutoffShortOption = None,
    json_output: shared.JsonOption = False,
    plot: shared.ProfilePlotOption = None,
) -> None:
    """Evaluate a measured profile: Rq, RSm, slope, correlation length, lay, interpolated points, removed form."""
    shared.check_outputs({"plot": plot})
    cutoffs = shared.given({"cutoff_long": cutoff_long, "cutoff_short": cutoff_short})
    for field, text in cutoffs.items():
        shared.parse_quantity(text, "m", field=field, bare=False)
    found = ehl.measured_surface(file, unit_x=unit_x, unit_height=unit_height, detrend=detrend, **cutoffs)
    found.write(plot=plot)
    shared.print_result(found, json_output)
