#!/usr/bin/env -S uv run
# /// script
# dependencies = ["nox>=2025.2.9"]
# ///
"""Tasks of a checkout, each in an environment of its own: ``nox`` runs lint, types, docs and tests as the gate does.

``nox -s gate`` is `.ci/run` itself: the same, and the wheel on the lowest and the newest versions of the dependencies.
"""

from __future__ import annotations

import nox

nox.needs_version = ">=2025.2.9"
nox.options.default_venv_backend = "uv|virtualenv"
nox.options.reuse_existing_virtualenvs = True


@nox.session
def lint(session: nox.Session) -> None:
    """Style and faults a reader would see."""
    session.install("ruff>=0.6")
    session.run("ruff", "check", ".")
    session.run("ruff", "format", "--check", ".")


@nox.session
def types(session: nox.Session) -> None:
    """Types, strictly."""
    session.install("-e", ".[dev]")
    session.run("mypy")


@nox.session
def docs(session: nox.Session) -> None:
    """The pages, warnings as errors."""
    session.install("-e", ".[docs]")
    site = f"{session.create_tmp()}/site"
    session.run(
        "python", "-m", "sphinx", "-q", "-W", "--keep-going", "-D", "plot_gallery=0", "-b", "html", "docs", site
    )


@nox.session
def tests(session: nox.Session) -> None:
    """All tests, or those named: ``nox -s tests -- tests/unit/ehl/test_contact.py``."""
    session.install("-e", ".[test]")
    session.run("pytest", *session.posargs)


@nox.session(default=False)
def kernels(session: nox.Session) -> None:
    """A wheel for the Python of this session and all processors of level x86-64-v3, in dist."""
    session.install("build>=1.2")
    session.run("python", "-m", "build", "--wheel", env={"MIXED_EHL_KERNELS": "portable"})


@nox.session(default=False, venv_backend="none")
def gate(session: nox.Session) -> None:
    """The gate, in the fresh environment that it makes itself."""
    session.run(".ci/run", external=True)


if __name__ == "__main__":
    nox.main()
