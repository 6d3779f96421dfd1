"""Pages on gears show the commands, no command of the tour writes over another, options stand in their table."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import typer

from efficiency.cli import app

ROOT = Path(__file__).resolve().parents[3]
PAGES = ("README.md", "docs/tour.md", "docs/study.md", "docs/gear_output.md")
COMMAND = typer.main.get_command(app)


def printed() -> list[tuple[str, list[str]]]:
    """(page, words after mixed-ehl) of each line of a code block."""
    found = []
    for page in PAGES:
        for block in re.findall(r"```[a-z]*\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), flags=re.DOTALL):
            for line in block.splitlines():
                for part in line.split("&&"):
                    words = shlex.split(part) if part.strip().startswith("mixed-ehl ") else []
                    if words:
                        found.append((page, words[1:]))
    return found


def test_pages_show_the_commands_of_this_stage() -> None:
    shown = {words[0] for page, words in printed()}
    assert {"gear", "compare", "study", "misalignment", "export", "settings", "blank"} <= shown


def test_no_command_of_the_tour_writes_over_another() -> None:
    written = [
        Path(words[number + 1])
        for page, words in printed()
        for number, word in enumerate(words)
        if page == "docs/tour.md" and word in ("-o", "--plot", "--report", "--xlsx", "--csv", "--animate")
    ]
    assert len(written) > 10
    # a folder and a file of one name are told apart, two folders or two files are not
    assert sorted(set(written)) == sorted(written)


def test_every_option_of_the_study_is_in_its_table() -> None:
    page = (ROOT / "docs" / "study.md").read_text(encoding="utf-8")
    command = COMMAND.commands["study"]  # type: ignore[attr-defined]
    for parameter in command.params:
        for option in parameter.opts:
            if option.startswith("--") and option not in ("--help", "--output"):
                assert f"`{option}`" in page, option
