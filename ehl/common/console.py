"""Common parts of the command lines of the three packages: options in errors, progress bars, files, JSON.

Apart from the public names, a command line imports this module only.
"""

import contextlib
import errno
import gc
import inspect
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
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import IO, Annotated, Any, NoReturn, TypeVar

import typer
import typer.core

from ehl.common.data import reason_text as reason_text
from ehl.common.data import shipped
from ehl.common.errors import InputError, MixedEhlError
from ehl.common.files import FIGURE, PAGE, make_folder, write_file
from ehl.common.progress import Progress, duration, progress_to
from ehl.common.progress import counted as counted
from ehl.common.terminal import print_text as print_text
from ehl.common.terminal import wrapped
from ehl.common.units import is_list as is_list
from ehl.common.units import parse_quantity as parse_quantity
from ehl.common.version import __version__

_Function = TypeVar("_Function", bound=Callable[..., Any])

# keyword or quantity of the Python interface -> option of a different name
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
    "variable": "vary",
    "viscosity_index": "vi",
    "temperature_oil": "temperature",
    "temperatures": "temperature",
}

_ParserError: Any = typer.BadParameter.__base__


def _longest(param: Any) -> str:
    """The long name of an option, the name of an argument."""
    return str(max(param.opts, key=len))


def _behind(option: str, typed: list[str]) -> str | None:
    """The last value of an option as typed."""
    split = [part for text in typed for part in (text.split("=", 1) if text.startswith("--") else [text])]
    return next((after for name, after in reversed(list(pairwise(split))) if name == option), None)


class UsageError(MixedEhlError):
    """A command line that cannot be parsed."""

    exit_code = 2


class Command(typer.core.TyperCommand):
    """A command whose errors name the options instead of the keywords of the Python interface."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        panels = {panel: place for place, panel in enumerate(OPTION_PANELS)}
        self.params.sort(key=lambda param: panels.get(str(getattr(param, "rich_help_panel", None)), -1))

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the options; errors of the parser become `UsageError`."""
        typed = list(args)
        try:
            rest = super().parse_args(ctx, args)
        except _ParserError as error:
            option = max(getattr(getattr(error, "param", None), "opts", None) or [""], key=len)
            value = _behind(option, typed)
            stated = error.format_message() if value is None else f"{option} = {value!r:.300}: {error.message}"
            raise UsageError(f"{stated.rstrip('.')}. See `{ctx.command_path} --help`.") from None
        names = {name: param for param in self.params for name in param.opts if name.startswith("-")}
        for name, param in names.items():
            value = _behind(name, typed)
            # an empty value, for example of an unset shell variable, would be the current folder
            if value in ("", *names) and isinstance(ctx.params.get(param.name), Path):
                raise InputError(name, value, "a file or folder", "'.' is the current folder.")
        return rest

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except InputError as error:
            raise error.changed(lambda problem: self._as_typed(ctx, problem)) from None
        except KeyboardInterrupt:  # which typer would turn into an exit without a word
            stop()

    def _as_typed(self, ctx: Any, problem: InputError) -> InputError:
        """The problem with the option as typed; without a hint it refers to the help."""
        field = ", ".join(self._option(ctx, part, problem.value) for part in problem.field.split(", "))
        hint = problem.hint or f"See `{ctx.command_path} --help`."
        return InputError(field, problem.value, problem.allowed, hint)

    def _option(self, ctx: Any, field: str, value: object) -> str:
        """The option of a field, or else the only one with this value; the field itself if the value is from a file."""
        options = [param for param in self.params if param.param_type_name == "option"]
        given = [p for p in options if getattr(ctx.get_parameter_source(p.name), "name", "") == "COMMANDLINE"]
        for name in (field, _OPTIONS.get(field, field)):
            for param in options if value is None else given:
                if name == param.name or f"--{name}" in param.opts:
                    return _longest(param)
        same = [param for param in given if isinstance(value, str) and value in _texts(ctx.params[str(param.name)])]
        return _longest(same[0]) if len(same) == 1 else field


def _texts(value: object) -> list[str]:
    """The value of an option that is no flag, or each of its values, as text."""
    return [str(one) for one in (value if isinstance(value, list | tuple) else [value]) if not isinstance(one, bool)]


@contextmanager
def output_folder(folder: Path) -> Iterator[None]:
    """A working folder; if an input is invalid, the empty folder is removed."""
    check_outputs({"output": folder}, ["output"])
    made = [path for path in (folder, *folder.parents) if not os.path.exists(path)]
    make_folder(folder, "output")
    try:
        yield
    except InputError:
        for path in made:
            with contextlib.suppress(OSError):
                path.rmdir()
        raise


# panels of the options of a command, in this order after the unnamed one; at most ten options are not advanced
OPERATION, OUTPUT, ADVANCED = OPTION_PANELS = ("Operating point", "Output", "Advanced")
advanced: Any = partial(typer.Option, rich_help_panel=ADVANCED)
"""`typer.Option` in the advanced panel."""


class App(typer.Typer):
    """An application, or a group of commands, of `Command`."""

    def command(self, name: str | None = None, **settings: Any) -> Callable[[_Function], _Function]:
        """Decorator for a command; its help is the docstring with each paragraph on one line."""

        def add(function: _Function) -> _Function:
            text = re.sub(r"(?<!\n)\n(?!\n)", " ", inspect.getdoc(function) or "")
            super(App, self).command(name, cls=Command, **({"help": text} | settings))(function)
            return function

        return add


STOPPED = 130  # exit code after a stop by the user, as in shells
SOFTWARE_FAULT = 70  # exit code of a program error, EX_SOFTWARE of sysexits.h
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EPIPE)
_COLLECT = 50_000  # new objects between two garbage collections (this work)
OUTPUT_FAULT = 74  # exit code if standard output cannot be written, EX_IOERR


def run(command: Callable[[], object]) -> None:
    """Run a command and exit with its code; every error is printed as one sentence.

    command: parses the command line and runs it.
    Raises `SystemExit`: 0; 1 if a result is missing or not converged, or the memory does not suffice; 2 for an invalid
        input; 70 for a program error with a log file; 74 if standard output cannot be written; 130 after a stop.
    """
    # with the usual 700 objects the imports start hundreds of collections, a tenth of the time of a point
    gc.set_threshold(_COLLECT)
    os.environ.pop("MPLBACKEND", None)  # figures are written only; an unknown name in the environment would be an error
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:  # closed by the shell: `>&-`
            setattr(sys, name, os.fdopen(null := os.open(os.devnull, os.O_RDWR), mode))
            os.set_inheritable(null, True)  # else pipes of worker processes take its number, and the workers crash
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
            try:
                sys.stdout.flush()  # an error if the disk is full
            except OSError as error:
                _stop_output(error)
    except MixedEhlError as error:
        print(f"mixed-ehl: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        stop()
    except MemoryError:
        hint = "What is finished is kept: fewer worker processes (--jobs), or a machine with more memory."
        print(f"mixed-ehl: the memory does not suffice. {hint}", file=sys.stderr)
        sys.exit(1)
    except OSError as error:
        if error.errno not in _FULL or error.filename is not None:
            _last_resort(error)
        _stop_output(error)
    except Exception as error:
        _last_resort(error)


def stop() -> NoReturn:
    """Report a stop by the user and exit."""
    print("mixed-ehl: stopped", file=sys.stderr)
    sys.exit(STOPPED)


def _stop_output(error: OSError) -> NoReturn:
    """Report an error of standard output and exit."""
    with contextlib.suppress(OSError, ValueError):
        # prevents a second attempt and message at the end of the interpreter
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if isinstance(error, BrokenPipeError):  # for example `| head`
        sys.exit(1)
    print(f"mixed-ehl: standard output cannot be written: {error.strerror}.", file=sys.stderr)
    sys.exit(OUTPUT_FAULT)


def _last_resort(error: Exception) -> NoReturn:
    """Print one sentence and write a log file with the details."""
    text = " ".join(f"{type(error).__name__}: {error}".split())
    text = text if len(text) <= 200 else text[:200] + "..."
    print(f"mixed-ehl: program error ({text}). {_write_log()}", file=sys.stderr)
    sys.exit(SOFTWARE_FAULT)


def _write_log() -> str:
    """Write the details of the current error into a file; returns the sentence with its path."""
    lines = [f"mixed-ehl {__version__}, Python {platform.python_version()}, {platform.platform()}"]
    lines += [f"arguments: {sys.argv[1:]!r}", "", traceback.format_exc()]
    with contextlib.suppress(OSError):  # the working folder may have been deleted
        lines.insert(2, f"folder: {os.getcwd()}")
    start = f"mixed-ehl-fault-{time.strftime('%Y%m%d-%H%M%S')}-"
    for folder in (tempfile.gettempdir, os.getcwd):
        with contextlib.suppress(OSError, InputError):
            handle, path = tempfile.mkstemp(".log", start, folder())  # readable for this user only
            os.close(handle)
            write_file(Path(path), "\n".join(lines).encode("utf-8", "backslashreplace"))
            return f"Details: {path}. Please send this file with your input."
    return "No log could be written."


JobsOption = Annotated[int | None, typer.Option(min=1, help="Worker processes; default: all processors.")]
DaskOption = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="A dask scheduler (tcp://..., file.json), or local:N.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.")]
# how a measured profile is read
ProfileArgument = Annotated[
    Path, typer.Argument(metavar="FILE", help="Trace or map: text, or a file of an instrument.")
]
UnitXOption = Annotated[str, typer.Option(help="Unit of the positions if the file has none.")]
UnitHeightOption = Annotated[str, typer.Option(help="Unit of the heights if the file has none.")]
DetrendOption = Annotated[int, typer.Option(help="Order of the polynomial that is removed as form.")]
CutoffLongOption = Annotated[str | None, typer.Option(help="lambda_c, e.g. '0.8 mm'; by ISO 4288 if not given.")]
CutoffShortOption = Annotated[str | None, typer.Option(help="lambda_s, e.g. '2.5 um'.")]
ProfilePlotOption = Annotated[Path | None, typer.Option(help="Write a figure of the trace, its form, and the profile.")]


def shipped_argument(metavar: str, kind: str, what: str) -> Any:
    """Annotation of an argument: a file, or the name of a shipped one of a kind (see `ehl.shipped`)."""
    text = f"{what}, or the name of a shipped one."
    return Annotated[str, typer.Argument(metavar=metavar, help=text, autocompletion=names_of(kind))]


def names_of(kind: str) -> Callable[[], list[str]]:
    """Completion of an argument in the shell: the shipped names of a kind (see `ehl.shipped`)."""
    return lambda: list(shipped(kind))


def given(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options that have a value."""
    return {name: value for name, value in options.items() if value is not None}


def pairs(field: str, texts: list[str] | None) -> dict[str, str]:
    """Texts ``NAME=VALUE`` as a mapping; `InputError` for `field` if one has another form."""
    found = {}
    for text in texts or ():
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals:
            raise InputError(field, text, "NAME=VALUE")
        found[name] = value
    return found


_SUFFIXES = {"report": PAGE, "plot": FIGURE, "xlsx": (".xlsx",), "csv": (".csv",)}


def check_outputs(outputs: Mapping[str, Path | None], folders: Collection[str] = (), **suffixes: str) -> None:
    """Raise an `InputError` for files that cannot be written; called before a computation.

    Missing folders are no error: they are created when a file is written.

    outputs: option to file; None if the option was not given.
    folders: options of folders; with the suffix of a table or figure they are files.
    **suffixes: suffix of an option; those of pages, figures and workbooks are known.
    Raises `InputError`: a file cannot be written, or two options have the same file.
    """
    files = given(outputs)
    folders = [field for field in folders if field in files and files[field].suffix not in _SUFFIXES.get(field, ())]
    for field, path in files.items():
        endings = (suffixes[field],) if field in suffixes else _SUFFIXES.get(field, ())
        if field not in folders and endings and path.suffix.lower() not in endings:
            raise InputError(field, str(path), "a file name ending in " + " or ".join(endings))
        kind = "folder" if field in folders else "file"
        if os.path.exists(path) and os.path.isdir(path) != (kind == "folder"):  # Path.is_dir may raise an error
            raise InputError(field, str(path), f"a {kind}", f"This is a {'file' if kind == 'folder' else 'folder'}.")
        if any(len(os.fsencode(part)) > 255 for part in path.parts):
            raise InputError(field, str(path), "a file name of at most 255 bytes")
        folder = path.parent
        while not os.path.lexists(folder):
            folder = folder.parent
        if os.path.exists(path) and not os.access(path, os.W_OK):
            raise InputError(field, str(path), f"a {kind} that can be written", "Check its permissions.")
        if os.path.lexists(path):  # a new file is made next to an old one, in an old folder
            folder = path if kind == "folder" else Path(os.path.realpath(path)).parent
        if not os.path.exists(path) or os.path.isfile(path) or kind == "folder":  # no device or pipe
            try:
                tempfile.TemporaryFile(dir=folder).close()
            except OSError as error:
                hint = f"Nothing can be written into {folder}: {error.strerror}."
                raise InputError(field, str(path), f"a {kind} that can be written", hint) from None
    resolved = [os.path.realpath(path) for field, path in files.items() if field not in folders]
    for field, path in files.items():
        if resolved.count(os.path.realpath(path)) > 1:
            raise InputError(field, str(path), "a different file for each option")


def write_text(path: Path, text: str) -> None:
    """Write the file of ``--output``; `InputError` if that is not possible."""
    write_file(path, text, "output")


def print_json(content: dict[str, Any]) -> None:
    """One JSON object on standard output, strict (no NaN)."""
    print(json.dumps(content, allow_nan=False))


def print_result(
    result: Any, json_output: bool, more: Mapping[str, Any] | None = None, *, cite: bool | None = False, **options: Any
) -> None:
    """Print a result with `options` of its `show`, or as one JSON object with `more` content; `cite`: references."""
    citation = result.citation() if cite else None
    if json_output:
        bibtex = {} if citation is None else {"bibtex": citation.bibtex}
        print_json(result.to_dict() | dict(more or {}) | bibtex)
        return
    result.show(**options)
    if citation is not None:
        print_text(f"\nReferences\n{citation}")


def fail_unless_converged(status: str, reason: str, label: str = "not converged") -> None:
    """Exit code 1 with the reason on standard error if a result is not converged."""
    if status != "converged":
        if reason:
            typer.echo(f"{label}: {reason_text(reason)}", err=True)
        raise typer.Exit(1)


FIRST_DISPLAY, LINE_EVERY = 3.0, 30.0  # time of the first display, interval of lines in a log [s]
_AT_ONCE = 0.1  # time between two reports of items that were not computed [s]
NOTHING_KEPT = "no results are stored; the same command starts again"


class ProgressDisplay:
    """Display of the elapsed time of a computation, its progress and the estimated time left.

    A terminal has one line (rich) that is updated; other streams get a line after `FIRST_DISPLAY` and then
    every `LINE_EVERY`.

    what: name of the computation.
    clock: returns the time [s].
    """

    def __init__(self, what: str, stream: IO[str], clock: Callable[[], float] = time.monotonic) -> None:
        self.what, self.stream, self.clock = what, stream, clock
        self.begin = clock()
        self.begins: dict[str, tuple[float, int]] = {}  # time and finished items at the begin of each step
        self.next = self.begin + FIRST_DISPLAY
        self.state, self.reported = Progress("", 0, 0), self.begin
        self.finished = False  # whether any item is
        self._line: Any = None

    def update(self, state: Progress) -> None:
        """Set the state of the computation."""
        self.reported = self.clock()
        if state.done == 0 and state.seconds_left:
            self.next = self.reported  # an expected time is shown at once
        # nested steps alternate and have separate rates; items reported at once are those of an earlier run
        begin = self.reported, state.done
        if state.done == 0 or self.reported - self.begins.setdefault(state.step, begin)[0] < _AT_ONCE:
            self.begins[state.step] = begin
        self.finished = self.finished or state.done > 0
        self.state = state

    def text(self) -> str:
        """State as text."""
        now, state = self.clock(), self.state
        parts = [self.what]
        if state.total:
            parts.append(f"{state.step} {state.done} of {state.total}".lstrip())
        parts.append(f"{duration(now - self.begin)} elapsed")
        left = state.seconds_left
        if left is not None:
            left = max(left - (now - self.reported), 0.0)
        elif state.done < state.total and state.done > self.begins[state.step][1]:
            begin, done = self.begins[state.step]
            left = (now - begin) * (state.total - state.done) / (state.done - done)
        if left and state.done < state.total:
            parts.append(f"about {duration(left)} left")
        return ", ".join(parts)

    def refresh(self) -> None:
        """Show the state if the interval has passed."""
        if self.clock() < self.next:
            return
        if self.stream.isatty():
            if self._line is None:
                from rich.console import Console

                self._line = Console(file=self.stream).status("")
                self._line.start()
            self._line.update(wrapped(self.text()))
        else:
            self.stream.write(f"mixed-ehl: {self.text()}\n")
            self.stream.flush()
            self.next = self.clock() + LINE_EVERY

    def clear(self) -> None:
        """Remove the line from a terminal."""
        if self._line is not None:
            self._line.stop()


@contextmanager
def working(what: str, kept: str = NOTHING_KEPT) -> Iterator[ProgressDisplay]:
    """Show the progress of a computation on standard error; after Ctrl-C, state which results are kept.

    what: name of the computation, such as "comparison".
    kept: sentence on stored results and how to continue, printed after Ctrl-C.
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
        when = f"stopped after {duration(display.clock() - display.begin)}"
        early = "" if display.finished or kept == NOTHING_KEPT else ", before the first new result"
        print(f"mixed-ehl: {when}{early}; {kept}", file=sys.stderr)
        raise SystemExit(STOPPED) from None
    finally:
        over.set()
        thread.join()
        display.clear()
