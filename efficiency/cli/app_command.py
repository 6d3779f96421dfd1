"""Command `app`: the pair in a browser, on this machine alone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import efficiency
from ehl.common.console import PROGRAM, App


def app(
    design: Annotated[
        Path | None, typer.Argument(metavar="DESIGN", help="Design file to offer beside the shipped pairs.")
    ] = None,
    port: Annotated[int, typer.Option(help="Port on the loopback address.", min=1024, max=65535)] = 8642,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open a browser.")] = True,
) -> None:
    """Show a pair in the browser: pattern, loss, map, friction models, misalignment; on this machine only."""
    efficiency.serve_app(design, port=port, browser=browser)


def register(commands: App) -> None:
    """Add the command."""
    commands.command(rich_help_panel=PROGRAM)(app)
