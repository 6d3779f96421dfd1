"""Command `new`: input files from options or from answers at the terminal."""

import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
import typer.core
import typer.main

import efficiency
import ehl
from efficiency.cli import options as shared
from ehl import InputError
from ehl.common import console
from ehl.common.console import App, check_outputs, write_text

# kind: description, and the command that uses the file
_KINDS = {
    "oil": ("An oil card from the base and ISO VG or two viscosities.", "mixed-ehl oil {file}"),
    "contact": ("One lubricated contact.", "mixed-ehl solve {file}"),
    "plan": ("Plan of the contacts to which a friction formula is fitted.", "mixed-ehl sweep {file} --estimate"),
    "design": ("A gear pair with the flanks of a shipped one.", "mixed-ehl gear {file}"),
    "targets": (
        "A new gear pair: blank, cutters and contact targets.",
        "mixed-ehl settings {file} --sized -o design.toml",
    ),
    "axle": ("A whole axle: bearings, seals, sump and housing around a gear pair.", "mixed-ehl axle {file}"),
    "duty": ("A duty cycle (CSV).", "mixed-ehl duty fm_spiral_bevel_14x39_relieved {file}"),
}
_FINISH = (
    "finish",
    "Finish card from a measured trace or map.",
    'mixed-ehl new plan --finish {file}, or finish = "{file}" in [surface], [pinion] or [gear]',
)

OutputOption = Annotated[
    Path | None, typer.Option("--output", "-o", metavar="FILE", help="File to write; default: my_KIND with its suffix.")
]
ForceOption = Annotated[bool, typer.Option("--force", help="Overwrite an existing file.")]


class NewGroup(typer.core.TyperGroup):
    """Commands for the kinds of files, created on demand because they would double the time of `mixed-ehl --help`."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Kinds in the order of the work."""
        return [*_KINDS, _FINISH[0]]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command of a kind; an `InputError` for an unknown kind."""
        app = App(add_completion=False)
        if cmd_name == _FINISH[0]:
            app.command(cmd_name)(new_finish)
        else:
            efficiency.new_questions(cmd_name)
            app.command(cmd_name)(_command(cmd_name))
        return typer.main.get_command(app)


new_app = App(
    cls=NewGroup,
    no_args_is_help=True,
    help="Write a complete input file with comments. Without options, a terminal prompts for the values.",
)


def new_finish(
    file: console.ProfileArgument,
    output: OutputOption = None,
    force: ForceOption = False,
    unit_x: console.UnitXOption = "",
    unit_height: console.UnitHeightOption = "",
    detrend: console.DetrendOption = 2,
    cutoff_long: console.CutoffLongOption = None,
    cutoff_short: console.CutoffShortOption = None,
    new: Annotated[bool, typer.Option("--new", help="The measured surface is new, not run in.")] = False,
    plot: console.ProfilePlotOption = None,
) -> None:
    """A finish card from a measured trace or map: Rq, correlation length, skewness, lay with ranges; power spectrum."""
    path = _target(output, "finish", ".toml", force)
    check_outputs({"plot": plot})
    cutoffs = console.given({"cutoff_long": cutoff_long, "cutoff_short": cutoff_short})
    found = ehl.measured_surface(file, unit_x=unit_x, unit_height=unit_height, detrend=detrend, **cutoffs)
    found.write(plot=plot)
    found.show()
    write_text(path, ehl.Finish.from_profile(found, "new" if new else "run_in").to_toml())
    print(f"written: {path}\nnext: {_FINISH[2].format(file=shlex.quote(str(path)))}")


def _target(output: Path | None, kind: str, suffix: str, force: bool) -> Path:
    """The file to write; an `InputError` if it exists, unless it may be overwritten."""
    path = output or Path(f"my_{kind}{suffix}")
    check_outputs({"output": path}, output=suffix)
    if path.exists() and not force:
        raise InputError("output", str(path), "a file that does not exist yet", "--force overwrites it.")
    return path


def _command(kind: str) -> Callable[..., None]:
    """The command that writes one kind of file, with an option for each of its questions."""
    questions = efficiency.new_questions(kind)

    def write(*, answers: Any, output: OutputOption = None, force: ForceOption = False) -> None:
        path = _target(output, kind, ".csv" if kind == "duty" else ".toml", force)
        if not answers and sys.stdin.isatty():
            answers = _ask(questions)
        write_text(path, efficiency.new_file(kind, path.stem, **answers))
        print(f"written: {path}\nnext: {_KINDS[kind][1].format(file=shlex.quote(str(path)))}")

    options = {
        name: Annotated[str | None, typer.Option(help=text, show_default=default or False)]
        for name, (text, default) in questions.items()
    }
    write.__annotations__["answers"], write.__doc__ = shared.group(**options), _KINDS[kind][0]
    return shared.with_groups(write)


def _ask(questions: dict[str, tuple[str, str]]) -> dict[str, str]:
    """Answers from the terminal; Enter selects the value in brackets."""
    print("Press Enter for the value in brackets.")
    answered = {
        name: str(
            typer.prompt(f"{name.replace('_', ' ')}: {text.rstrip('.')}", default=default, show_default=bool(default))
        )
        for name, (text, default) in questions.items()
    }
    return {name: answer for name, answer in answered.items() if answer != questions[name][1]}


@new_app.callback()
def _new() -> None:
    """Write a complete input file with comments. Without options, a terminal prompts for the values."""
