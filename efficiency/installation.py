"""Check of the installation (`mixed-ehl doctor`)."""

from __future__ import annotations

import importlib
import importlib.metadata
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from ehl.common.errors import InputError

PACKAGES = ("ehl", "regression", "efficiency")


@dataclass(frozen=True)
class Check:
    """One line of the report."""

    name: str
    passed: bool
    detail: str


def check_one_installation() -> Check:
    """Check that all three packages are in one folder and have the same version.

    `regression` and `efficiency` are also names of other distributions, and with ``python -c`` a folder of that name in
    the working directory takes precedence.
    """
    modules: dict[str, ModuleType] = {name: importlib.import_module(name) for name in PACKAGES}
    homes = {name: Path(module.__file__ or "").parent.parent for name, module in modules.items()}
    versions = {name: getattr(module, "__version__", "none") for name, module in modules.items()}
    passed = len(set(homes.values())) == 1 and len(set(versions.values())) == 1
    if passed:
        return Check("one installation", True, f"version {versions['ehl']} in {homes['ehl']}")
    found = ", ".join(f"{name} {versions[name]} in {homes[name]}" for name in PACKAGES)
    return Check("one installation", False, f"the packages come from different installations: {found}")


def _dependencies() -> list[Check]:
    from packaging.requirements import Requirement

    checks = []
    try:
        lines = importlib.metadata.requires("mixed-ehl") or []
    except importlib.metadata.PackageNotFoundError:
        return [Check("dependencies", False, "mixed-ehl is not installed: run pip install")]
    for line in lines:
        requirement = Requirement(line)
        if requirement.marker is not None and not requirement.marker.evaluate({"extra": ""}):
            continue
        try:
            version = importlib.metadata.version(requirement.name)
            passed = version in requirement.specifier
            checks.append(Check(requirement.name, passed, f"{version} (required: {requirement.specifier})"))
        except importlib.metadata.PackageNotFoundError:
            checks.append(Check(requirement.name, False, f"not installed (required: {requirement.specifier})"))
    return checks


def _data() -> Check:
    from ehl.common.data import data_names, data_path
    from ehl.fluid.oil import Oil

    oils = data_names("oils")
    for name in oils:
        Oil.load(name)
    return Check("data", len(oils) > 0, f"{len(oils)} oils, {len(data_names('designs'))} designs in {data_path()}")


def _cache() -> Check:
    from ehl.compile.sources import kernel_folder

    try:
        return Check("compile cache", True, f"{kernel_folder()} belongs to this user alone")
    except OSError as error:
        return Check("compile cache", True, f"no cache, each process compiles its own kernels: {error}")


def _kernels() -> Check:
    from ehl.compile.carried import why_not

    reason = why_not()
    if reason is None:
        return Check("compiled kernels", True, "included")
    return Check("compiled kernels", True, f"compiled on this machine at first use: {reason}")


def _solver() -> Check:
    from ehl.fluid.lubricant import Lubricant
    from ehl.line_contact import LineContact
    from ehl.smooth.solver import solve_steady

    # case g01 of data/reference/ehl_smooth_cases.json
    expected = 7.796405e-07
    contact = LineContact(0.01, 226.4e9, 277525.85279061773, 5.0, 0.3)
    lubricant = Lubricant(0.04, 18e-9, rheology="eyring", eyring_stress=5e6)
    result = solve_steady(contact, lubricant)
    deviation = abs(result.film_central / expected - 1.0)
    return Check(
        "solver",
        result.status == "converged" and deviation < 5e-3,
        f"central film {result.film_central * 1e9:.2f} nm, reference {expected * 1e9:.2f} nm",
    )


def examine(*, installation_only: bool = False) -> list[Check]:
    """Check the installation: packages, versions, data, compile cache, and one solution against its reference value.

    Parameters
    ----------
    installation_only : bool
        Only check whether the three packages belong together; raises an `InputError` if they do not.

    Returns
    -------
    list of Check
        Checks; an exception inside a check is reported as its failure.

    Examples
    --------
    >>> import efficiency
    >>> all(check.passed for check in efficiency.doctor(installation_only=True))
    True
    """
    together = check_one_installation()
    if installation_only and not together.passed:
        allowed = "ehl, regression and efficiency of the same mixed-ehl version in one place"
        hint = "Install mixed-ehl in an environment of its own, and run the mixed-ehl script."
        raise InputError("installation", together.detail, allowed, hint)
    if installation_only:
        return [together]
    python = Check("Python", sys.version_info >= (3, 11), f"{sys.version.split()[0]} (required: 3.11 or newer)")
    checks = [python, together, *_dependencies()]
    for check in (_data, _cache, _kernels, _solver):
        try:
            checks.append(check())
        except Exception as error:  # any exception is reported as a failed check
            checks.append(Check(check.__name__.strip("_"), False, f"{type(error).__name__}: {error}"))
    return checks
