"""What the command lines of the three packages share: options in errors, progress bars, files, JSON.

The one module beside the public names that a command line imports.
"""

from __future__ import annotations

import contextlib
import errno
import json
import logging
import os
import platform
import re
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import IO, TYPE_CHECKING, Annotated, Any, NoReturn, TypeVar

import typer
import typer.core

from ehl.common.data import shipped
from ehl.common.duration import duration
from ehl.common.errors import InputError, MixedEhlError, near
from ehl.common.files import FIGURE, PAGE, make_folder, write_file
from ehl.common.progress import Progress, progress_to
from ehl.common.version import __version__

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_Function = TypeVar("_Function", bound=Callable[..., Any])

# keyword or quantity of the Python interface -> option, where they are not the same word
_OPTIONS = {
    "density_15": "density",
    "folder": "output",
    "friction model": "friction",
    "iso_vg": "vg",
    "nu_100": "nu100",
    "nu_40": "nu40",
    "parameters": "fit",
    "path": "output",
    "pressure_hertz": "pressure",
    "radius_equivalent": "radius",
    "roughness_rms": "roughness",
    "roughness_rms_each": "roughness_each",
    "roughness_rms_gear": "roughness_gear",
    "roughness_rms_pinion": "roughness_pinion",
    "speed_entrainment": "speed",
    "speed_sliding_lengthwise": "lengthwise",
    "store": "output",
    "tasks": "slurm",
    "temperature_oil": "temperature",
    "temperatures": "temperature",
}


_UsageError: Any = typer.BadParameter.__base__


def _longest(param: Any) -> str:
    """The long name of an option, the name of an argument."""
    return str(max(param.opts, key=len))


def _behind(option: str, typed: list[str]) -> str | None:
    """The last value given to an option, as typed."""
    split = [part for text in typed for part in (text.split("=", 1) if text.startswith("--") else [text])]
    return next((after for name, after in reversed(list(pairwise(split))) if name == option), None)


class Command(typer.core.TyperCommand):
    """A command whose errors name the option where the Python interface names its keyword."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the options; what cannot be read is refused in the words of all other errors."""
        typed = list(args)
        try:
            rest = super().parse_args(ctx, args)
        except _UsageError as error:
            refused = self._refused(ctx, error, typed)
            if refused is None:
                raise
            raise refused from None
        names = {name: param for param in self.params for name in param.opts if name.startswith("-")}
        for name, param in names.items():
            value = _behind(name, typed)
            # nothing behind it, as of an unset shell variable: this folder, or one named as an option, would be filled
            if value in ("", *names) and isinstance(ctx.params.get(param.name), Path):
                raise InputError(name, value, "a file or folder", "'.' is the folder you are in.")
        return rest

    def _refused(self, ctx: Any, error: Any, typed: list[str]) -> InputError | None:
        """What the parser found, as an `InputError`; its classes are told apart by name, as they have moved."""
        see, kind = f"See `{ctx.command_path} --help`.", type(error).__name__
        if kind == "NoSuchOption":
            known = sorted(_longest(param) for param in self.params if param.param_type_name == "option")
            hint = near(error.option_name, known) or see
            return InputError("option", error.option_name, "one of " + ", ".join(known), hint)
        if kind == "BadOptionUsage":
            return InputError(error.option_name, None, "a value behind it", see)
        if kind == "MissingParameter":
            param = error.param
            what = " ".join((getattr(param, "help", "") or "a value").split()).rstrip(".")
            return InputError(_longest(param), None, what, see)
        if found := re.search(r"unexpected extra argument\S* \((.*)\)", error.message):
            taken = [_longest(param) for param in self.params if param.param_type_name == "argument"]
            allowed = f"no more than {' '.join(taken)}" if taken else "options alone"
            return InputError("argument", found[1], allowed, see)
        if isinstance(error, typer.BadParameter):
            option = max(getattr(error.param, "opts", None) or [""], key=len)
            value = _behind(option, typed)
            if value is not None and option.startswith("-"):
                return InputError(option, value, _kind(error.message), see)
        return None

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except InputError as error:
            raise error.changed(lambda problem: self._as_typed(ctx, problem)) from None

    def _as_typed(self, ctx: Any, problem: InputError) -> InputError:
        """The problem of the option as typed, and where to look if it does not say what to do."""
        field = ", ".join(self._option(ctx, part, problem.value) for part in problem.field.split(", "))
        hint = problem.hint or f"See `{ctx.command_path} --help`."
        return InputError(field, problem.value, problem.allowed, hint)

    def _option(self, ctx: Any, field: str, value: object) -> str:
        """The option of a field, if it was given or nothing was; else the value comes from a file."""
        for name in (field, _OPTIONS.get(field, field)):
            for param in self.params:
                if param.param_type_name != "option" or (name != param.name and f"--{name}" not in param.opts):
                    continue
                source = ctx.get_parameter_source(param.name)
                if value is None or (source is not None and source.name == "COMMANDLINE"):
                    return _longest(param)
        return field


@contextmanager
def output_folder(folder: Path) -> Iterator[None]:
    """A folder to work in; taken away again, empty as it is, where an input is refused."""
    made = [path for path in (folder, *folder.parents) if not os.path.exists(path)]
    make_folder(folder, "output")
    try:
        yield
    except InputError:
        for path in made:
            with contextlib.suppress(OSError):
                path.rmdir()
        raise


def _kind(message: str) -> str:
    """What an option takes, of the sentence of the parser: old and new versions of it word that in two ways."""
    if found := re.search(r"is not in the range (.+?)\.?$", message):
        return f"a number x with {found[1]}"
    if found := re.search(r"(greater|less) than or equal to (\S+)", message):
        return f"a number of at {'least' if found[1] == 'greater' else 'most'} {found[2]}"
    return "a whole number" if "integer" in message else "a number" if re.search("float|number", message) else message


# panels of the commands in `mixed-ehl --help`, in the order of the work
CONTACT, FORMULA, GEAR, PROGRAM = "Contact", "Friction formula", "Gear pair", "Program"
ADVANCED = "Advanced"  # panel of the options of a command that few need; at most ten are outside of it
advanced: Any = partial(typer.Option, rich_help_panel=ADVANCED)
"""`typer.Option` in the advanced panel."""


class App(typer.Typer):
    """An application, or a group of commands, of `Command`."""

    def command(self, name: str | None = None, **settings: Any) -> Callable[[_Function], _Function]:
        """As of `typer.Typer`."""
        return super().command(name, cls=Command, **settings)


STOPPED = 130  # exit code where the user stopped it, as of a shell
SOFTWARE_FAULT = 70  # exit code of a fault of the program, EX_SOFTWARE of sysexits.h
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EPIPE)
OUTPUT_FAULT = 74  # exit code where standard output takes no more, EX_IOERR


def run(command: Callable[[], object]) -> None:
    """Run a command to its exit code: whatever goes wrong becomes one sentence.

    Parameters
    ----------
    command : callable
        Parses the command line and runs it.

    Raises
    ------
    SystemExit
        0; 1 where something has no answer; 2 for an input that cannot be used; 70 for a fault of the program, which a
        log file describes; 74 where standard output takes no more; 130 where the user stopped it.
    """
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # a terminal without Greek letters shows question marks
            stream.reconfigure(errors="replace")
    notes, log = logging.StreamHandler(), logging.getLogger("mixed_ehl")
    notes.setFormatter(logging.Formatter("note     %(message)s"))
    log.addHandler(notes)
    log.setLevel(logging.INFO)
    try:
        try:
            command()
        finally:
            log.removeHandler(notes)
            _flush()
    except MixedEhlError as error:
        print(f"mixed-ehl: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        print("mixed-ehl: stopped", file=sys.stderr)
        sys.exit(STOPPED)
    except OSError as error:
        if error.errno not in _FULL or error.filename is not None:
            _last_resort(error)
        _stop_output(error)
    except Exception as error:
        _last_resort(error)


def _flush() -> None:
    """Put on standard output what waits for it; a full disk shows here."""
    try:
        sys.stdout.flush()
    except OSError as error:
        _stop_output(error)


def _stop_output(error: OSError) -> NoReturn:
    """Leave standard output as it is, say why, and exit."""
    with contextlib.suppress(OSError, ValueError):
        # the interpreter would try again when it ends, and complain
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if isinstance(error, BrokenPipeError):  # `| head` has seen enough
        sys.exit(1)
    print(f"mixed-ehl: standard output cannot be written: {error.strerror}.", file=sys.stderr)
    sys.exit(OUTPUT_FAULT)


def _last_resort(error: Exception) -> NoReturn:
    """One sentence, and a log file with the rest."""
    where = _write_log()
    print(f"mixed-ehl: fault of the program ({_in_a_line(error)}). {where}", file=sys.stderr)
    sys.exit(SOFTWARE_FAULT)


def _in_a_line(error: Exception) -> str:
    text = " ".join(f"{type(error).__name__}: {error}".split())
    return text if len(text) <= 200 else text[:200] + "..."


def _write_log() -> str:
    """Write what is known of the fault at hand into a file; the sentence that names it."""
    lines = [f"mixed-ehl {__version__}, Python {platform.python_version()}, {platform.platform()}"]
    lines += [f"arguments: {sys.argv[1:]!r}", f"folder: {os.getcwd()}", "", traceback.format_exc()]
    start = f"mixed-ehl-fault-{time.strftime('%Y%m%d-%H%M%S')}-"
    for folder in (tempfile.gettempdir, os.getcwd):
        with contextlib.suppress(OSError, InputError):
            handle, path = tempfile.mkstemp(".log", start, folder())  # readable for this user alone
            os.close(handle)
            write_file(Path(path), "\n".join(lines).encode("utf-8", "backslashreplace"))
            return f"Details: {path}. Please send this file with your input."
    return "No log could be written."


JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.")]
# how a measured profile is read
ProfileArgument = Annotated[
    Path, typer.Argument(metavar="FILE", help="Trace or map: text, or a file of an instrument.")
]
UnitXOption = Annotated[str, typer.Option(help="Unit of the positions where the file has none.")]
UnitHeightOption = Annotated[str, typer.Option(help="Unit of the heights where the file has none.")]
DetrendOption = Annotated[int, typer.Option(help="Order of the polynomial that is removed as form.")]
CutoffLongOption = Annotated[str | None, typer.Option(help="lambda_c, e.g. '0.8 mm'; by ISO 4288 if not given.")]
CutoffShortOption = Annotated[str | None, typer.Option(help="lambda_s, e.g. '2.5 um'.")]
ProfilePlotOption = Annotated[Path | None, typer.Option(help="Write a figure: as read, form, and the profile used.")]


def names_of(kind: str) -> Callable[[], list[str]]:
    """What the shell completes an argument to: the shipped names of a kind, as of `ehl.shipped`."""
    return lambda: list(shipped(kind))


def given(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options that have a value."""
    return {name: value for name, value in options.items() if value is not None}


def is_list(text: str) -> bool:
    """Whether a text is a list ``a, b, c unit`` or a range ``from:to:number unit``."""
    return any(sign in re.sub(r"\d,\d", "", text) for sign in ",;:")  # a comma within a number is refused later


def pairs(field: str, texts: list[str] | None) -> dict[str, str]:
    """Texts ``NAME=VALUE`` as a mapping; `InputError` naming `field` where one is something else."""
    found = {}
    for text in texts or ():
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals:
            raise InputError(field, text, "NAME=VALUE")
        found[name] = value
    return found


_SUFFIXES = {"report": PAGE, "plot": FIGURE, "xlsx": (".xlsx",)}


def check_suffix(path: Path, field: str, suffix: str = "") -> None:
    """Refuse a file of another kind than will be written; suffixes of pages, figures and workbooks are known."""
    suffixes = (suffix,) if suffix else _SUFFIXES[field]
    if path.suffix.lower() not in suffixes:
        raise InputError(field, str(path), "a file name ending in " + " or ".join(suffixes))


def check_outputs(outputs: Mapping[str, Path | None], **suffixes: str) -> None:
    """Refuse files that cannot be written, before anything is computed.

    outputs: option to file; None where the option was not given.
    **suffixes: suffix of an option; those of pages, figures and workbooks are known.
    Raises `InputError`: naming option and file; or two options name the same file.
    """
    files = given(outputs)
    for field, path in files.items():
        if field in suffixes or field in _SUFFIXES:
            check_suffix(path, field, suffixes.get(field, ""))
        if os.path.isdir(path):  # and not Path.is_dir, which raises where the name is too long
            raise InputError(field, str(path), "a file", "This is a folder.")
        folder = path.parent
        if not os.path.isdir(folder):
            raise InputError(field, str(path), "a file in a folder that exists", f"There is no folder {folder}.")
        if len(os.fsencode(path.name)) > 255:
            raise InputError(field, str(path), "a file name of at most 255 bytes")
        if not os.access(path if os.path.exists(path) else folder, os.W_OK):
            raise InputError(field, str(path), "a file that can be written", "Check its permissions.")
    resolved = [path.resolve() for path in files.values()]
    for field, path in files.items():
        if resolved.count(path.resolve()) > 1:
            raise InputError(field, str(path), "a file of its own for each option")


def write_text(path: Path, text: str) -> None:
    """Write the file of ``--output``; `InputError` where that is not possible."""
    write_file(path, text, "output", folder=True)


def write_figure(axes: Axes, path: Path) -> None:
    """Write the figure of ``--plot``; the suffix chooses the format."""
    from ehl.common.figures import save_figure

    save_figure(axes, path)


def print_json(content: dict[str, Any]) -> None:
    """One JSON object on standard output, strict (no NaN)."""
    print(json.dumps(content, allow_nan=False))


def fail_unless_converged(status: str, reason: str) -> None:
    """Exit code 1 with the reason on standard error where a result is not what was asked for."""
    if status != "converged":
        if reason:
            typer.echo(f"not converged: {reason}", err=True)
        raise typer.Exit(1)


FIRST_DISPLAY, LINE_EVERY = 3.0, 30.0  # when progress is first shown, and the interval of lines in a log [s]
NOTHING_KEPT = "nothing of it is kept; the same command begins again"


class ProgressDisplay:
    """Shows on a stream the elapsed time of a computation, its progress and the estimated time left.

    A terminal has one line with a bar (rich) that is renewed; elsewhere a line is written after `FIRST_DISPLAY` and
    then every `LINE_EVERY`.

    what: the computation.
    stream: where it is shown.
    clock: seconds.
    """

    def __init__(self, what: str, stream: IO[str], clock: Callable[[], float] = time.monotonic) -> None:
        self.what, self.stream, self.clock = what, stream, clock
        self.begin = clock()
        self.begins: dict[str, float] = {}
        self.next = self.begin + FIRST_DISPLAY
        self.state = Progress("", 0, 0)
        self._bar: Any = None

    def update(self, state: Progress) -> None:
        """Take the state that the computation reports."""
        if state.done == 0:
            self.begins[state.step] = self.clock()
        # steps within each other alternate: each has its own pace
        self.begins.setdefault(state.step, self.clock() if self.begins else self.begin)
        self.state = state

    def text(self) -> str:
        """The state in words."""
        now, state = self.clock(), self.state
        parts = [self.what]
        if state.total:
            parts.append(f"{state.step} {state.done} of {state.total}".lstrip())
        parts.append(f"{duration(now - self.begin)} elapsed")
        left = state.seconds_left
        if left is None and 0 < state.done < state.total:
            left = (now - self.begins[state.step]) * (state.total - state.done) / state.done
        if left is not None and state.done < state.total:
            parts.append(f"about {duration(left)} left")
        return ", ".join(parts)

    def refresh(self) -> None:
        """Show the state where it is time to."""
        if self.clock() < self.next:
            return
        if self.stream.isatty():
            if self._bar is None:
                from rich.console import Console
                from rich.progress import BarColumn, TextColumn
                from rich.progress import Progress as Bar

                columns = (TextColumn("{task.description}", markup=False), BarColumn())
                self._bar = Bar(*columns, console=Console(file=self.stream), transient=True)
                self._bar.add_task(self.what, total=None)
                self._bar.start()
            self._bar.update(
                self._bar.task_ids[0],
                description=self.text(),
                completed=self.state.done,
                total=self.state.total or None,
            )
        else:
            self.stream.write(f"mixed-ehl: {self.text()}\n")
            self.stream.flush()
            self.next = self.clock() + LINE_EVERY

    def clear(self) -> None:
        """Remove the line from a terminal."""
        if self._bar is not None:
            self._bar.stop()


@contextmanager
def working(what: str, kept: str = NOTHING_KEPT) -> Iterator[ProgressDisplay]:
    """Show the progress of a computation on standard error; Ctrl-C states what is kept.

    what: the computation, as "comparison".
    kept: what remains of it where the user stops it, and how to go on.
    """
    display, over = ProgressDisplay(what, sys.stderr), threading.Event()

    def refresh() -> None:
        while not over.wait(0.5):
            with contextlib.suppress(OSError, ValueError):  # standard error is closed
                display.refresh()

    thread = threading.Thread(target=refresh, daemon=True)
    thread.start()
    try:
        with progress_to(display.update):
            yield display
    except KeyboardInterrupt:
        over.set()
        thread.join()
        display.clear()
        print(f"mixed-ehl: stopped after {duration(display.clock() - display.begin)}; {kept}", file=sys.stderr)
        raise SystemExit(STOPPED) from None
    finally:
        over.set()
        thread.join()
        display.clear()
