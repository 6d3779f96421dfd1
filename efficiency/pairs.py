"""Gear pairs from files and from data; a cylindrical pair provides meshes, results and pages like a bevel pair."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TypedDict, Unpack

from efficiency.conditions.conditions import Value
from efficiency.contact.gear_flanks import Side
from efficiency.design.design import load_design
from efficiency.loss.closed_form import PitchGeometry
from efficiency.loss.kinematics import OperatingPoint
from efficiency.ltca.load_distribution import TeethElasticity
from efficiency.ltca.mesh_grids import MeshGrids, both_cycles
from efficiency.mesh import Mesh
from efficiency.pair import GearPair
from ehl.common.data import named_file
from ehl.common.errors import InputError
from ehl.common.table import Table
from ehl.common.threads import one_thread
from ehl.common.validation import read_toml, validate

if TYPE_CHECKING:
    from efficiency.cylindrical_gears.design import CylindricalDesign

NO_MISALIGNMENT = "no misalignment, because cylindrical pairs are computed aligned"


class CylindricalKeywords(TypedDict, total=False):
    """Keywords of `cylindrical`; the first of two values is that of the pinion."""

    name: str
    pressure_angle_normal: Value
    helix_angle: Value
    centre_distance: Value
    load_share: str
    profile_shift: Sequence[float]
    tip_diameter: Sequence[Value]
    tip_relief: Sequence[Value]
    tip_relief_length: Sequence[Value]
    finish: str | Sequence[str]
    finish_state: str | Sequence[str]
    roughness_rms: Value | Sequence[Value]
    material: str | Sequence[str]
    torque: Value
    speed: Value
    temperature: Value
    oil: str
    driver: str


def load(name: str | Path) -> GearPair:
    """A gear pair from a design file or the name of a shipped design.

    Parameters
    ----------
    name : str or Path
        Design file (TOML) or name of a shipped design (`ehl.shipped`).

    Returns
    -------
    GearPair

    Raises
    ------
    InputError
        An invalid field.

    Examples
    --------
    >>> import efficiency
    >>> efficiency.load("fm_spiral_bevel_14x39")
    GearPair(fm_spiral_bevel_14x39: 14x39, offset 0 mm, 300 N m, 125.7 rad/s, 75w90 at 363.15 K)
    """
    path = named_file("design", "designs", name)
    content = read_toml(path, "design")
    if is_cylindrical(content):
        return CylindricalPair(cylindrical_design(content, path.name))
    return GearPair(load_design(path), keep=True)


def is_cylindrical(content: Mapping[str, Any]) -> bool:
    """Whether the content of a design file is a cylindrical pair."""
    return content.get("kind") == "cylindrical"


def cylindrical_design(content: dict[str, Any], source: str) -> CylindricalDesign:
    """The design of a cylindrical pair; `InputError` for an invalid field, with the name of the `source`."""
    from efficiency.cylindrical_gears.design import CylindricalDesign

    return validate(CylindricalDesign, content, source)


def cylindrical(
    teeth: tuple[int, int], module: Value, face_width: Value, **given: Unpack[CylindricalKeywords]
) -> CylindricalPair:
    """A spur or helical pair from its data; `load` reads one from a design file with ``kind = "cylindrical"``.

    Parameters
    ----------
    teeth : (int, int)
        Number of teeth of pinion and gear.
    module : float or str
        Normal module [m].
    face_width : float or str
        Face width [m].
    **given : value, or one value each for pinion and gear
        Fields of `efficiency.cylindrical_gears.design.CylindricalDesign`, of its members and of its operating point:
        `profile_shift`, `helix_angle`, `centre_distance`, `tip_relief`, `finish`, `torque`, `speed`, `oil`...

    Returns
    -------
    CylindricalPair

    Raises
    ------
    InputError
        An invalid field.

    Examples
    --------
    >>> import efficiency
    >>> pair = efficiency.cylindrical(
    ...     (16, 24), "4.5 mm", "14 mm", profile_shift=(0.1817, 0.1715), torque="183 N m", speed="2250 rpm",
    ...     temperature="90 degC", oil="fva3",
    ... )
    >>> pair
    CylindricalPair(cylindrical_16x24: 16x24, helix 0 deg, 183 N m, 235.6 rad/s, fva3 at 363.15 K)
    """
    from efficiency.cylindrical_gears.design import CylindricalMember

    content: dict[str, Any] = {"name": f"cylindrical_{teeth[0]}x{teeth[1]}", "kind": "cylindrical"}
    content |= {"module_normal": module, "face_width": face_width}
    members: list[dict[str, Any]] = [{"teeth": count} for count in teeth]
    content |= {"pinion": members[0], "gear": members[1], "operation": {}}
    for name, value in given.items():
        if name in CylindricalMember.model_fields:
            single = isinstance(value, str | int | float)
            for member, own in zip(members, (value, value) if single else value, strict=True):  # type: ignore[call-overload]
                member[name] = own
        elif name in OperatingPoint.model_fields:
            content["operation"][name] = value
        else:
            content[name] = value
    return CylindricalPair(cylindrical_design(content, "cylindrical pair"))


class CylindricalPair(GearPair):
    """A spur or helical pair: its design and operating point.

    Methods for bevel gears only (machine settings, misalignment, ease-off, strength) raise an `InputError`.

    design: content of the design file.
    """

    design: CylindricalDesign  # type: ignore[assignment]

    def __init__(self, design: CylindricalDesign, *, keep: bool = False) -> None:
        super().__init__(design, keep=keep)  # type: ignore[arg-type]

    @cached_property
    def _teeth(self) -> TeethElasticity:
        from efficiency.cylindrical_gears.contact_lines import elastic_pair

        design = self.design
        materials = design.pinion.elastic_material(), design.gear.elastic_material()
        return elastic_pair(design.involute, materials, design.rounding, rigid=design.load_share == "rigid")

    @one_thread
    def _mesh(self, side: Side, positions: int, points: int, misalignment: tuple[tuple[str, float], ...]) -> Mesh:
        from efficiency.cylindrical_gears.contact_lines import axes_of, mesh_cycle

        design, pair = self.design, self.design.involute
        # the lines span the whole flanks, so that they do not depend on the load
        fine, coarse = both_cycles(
            lambda count, line, _reach: mesh_cycle(pair, count, line, design.relief), positions, points
        )
        grids = MeshGrids(design.name, side, fine, coarse, self._teeth, points, axes_of(pair))
        pitch = PitchGeometry(
            pressure_angle=math.atan(math.tan(pair.working_angle) * math.cos(pair.helix_angle)),
            spiral_angle=(pair.helix_angle, pair.helix_angle),
            pitch_angle=(0.0, 0.0),
            radius=pair.pitch,
            module_normal=pair.module,
            contact_ratio_profile=pair.contact_ratio,
        )
        return Mesh(design, side, None, grids, pitch)

    def _placed(self, given: Mapping[str, Value]) -> dict[str, float]:
        for name, value in given.items():
            raise InputError(name, value, NO_MISALIGNMENT)
        return {}

    def _bevel_only(self, *_args: Any, **_given: Any) -> NoReturn:
        raise InputError("design", self.design.name, "a bevel or hypoid pair", "The design is of a cylindrical pair.")

    geometry = misalignment = plot_contact = export = _bevel_only

    def _teeth_text(self) -> str:
        teeth = f"{self.design.pinion.teeth}x{self.design.gear.teeth}"
        return f"{teeth}, helix {math.degrees(self.design.helix_angle):.4g} deg"

    def _repr_html_(self) -> str:
        return Table(("quantity", "pinion / gear"), self.design.rows(), title=self.design.name).html()
