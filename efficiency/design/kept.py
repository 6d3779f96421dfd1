"""Storage of elastic bodies, roots and geometry on disk, identified by the content of the design."""

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Literal, TypeVar

import numpy as np

from efficiency.contact.gear_flanks import MEMBERS
from efficiency.cutting.cutter import FLANK_SIDES
from efficiency.design.design import Design
from ehl.common.private_files import kept
from ehl.common.version import __version__

T = TypeVar("T")
Kind = Literal["bodies", "roots", "mesh"]

_PACKAGE = Path(__file__).resolve().parents[1]
# sources that affect the results
_SOURCES = ("blanks", "contact", "cutting", "design", "geometry", "ltca", "strength")
_FOLDER = "designs"


def kept_of_design(kind: Kind, design: Design, what: tuple[object, ...], make: Callable[[], T]) -> T:
    """A result of a design from disk; if it is not found, it is computed and stored.

    kind: bodies and roots depend on the members, the mesh also on their position.
    design: the pair, including the content of files of its flanks.
    what: further inputs of the result: side, positions...
    make: function that computes the result.
    """
    try:
        key = _key(kind, design, what)
    except OSError:  # sources in an archive
        return make()
    return kept(_FOLDER, key, make)


def _key(kind: Kind, design: Design, what: tuple[object, ...]) -> str:
    moved = None if kind == "mesh" else {"assembly": {"misalignment", "deflection", "stiffness"}}
    members = design.model_dump_json(include={"name", "pinion", "gear", "assembly"}, exclude=moved)
    materials = [(b.material, b.rim_thickness, sorted(b.held), b.youngs_modulus) for b in design.tooth_bodies()]
    digest = hashlib.sha256(repr((kind, what, members, materials)).encode())
    digest.update(_version())
    for member in MEMBERS:
        for side in FLANK_SIDES:
            flank = getattr(getattr(design, member), side)
            for name in ("grid", "map"):
                if path := getattr(flank, name, None):
                    digest.update(hashlib.sha256(Path(path).read_bytes()).digest())
    return digest.hexdigest()


@cache
def _version() -> bytes:
    """Hash of the sources, of the NumPy version and of its instruction sets, which affect the last digits."""
    used = np.show_config(mode="dicts")["SIMD Extensions"]["found"]
    digest = hashlib.sha256(repr((__version__, np.__version__, used)).encode())
    files = [file for name in _SOURCES for file in sorted((_PACKAGE / name).glob("*.py"))]
    for file in (*files, _PACKAGE / "mesh.py"):
        digest.update(hashlib.sha256(file.read_bytes()).digest())
    return digest.digest()
