"""The design file of a cylindrical pair (`kind = "cylindrical"`): teeth, relief, finish, oil and operating point."""

import math
from functools import cached_property
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from efficiency.contact.gear_flanks import MEMBERS
from efficiency.cutting.blank import Depth, Length
from efficiency.cylindrical_gears.involute import InvolutePair
from efficiency.design.design import EdgeRounding, MemberSurface, PairDesign
from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.units import ValueRange

Factor = Annotated[float, ValueRange("", gt=0.0, le=3.0)]
# radius of the tip edges over the module, as for bevel gears
_EDGE_ROUNDING = 0.05


class CylindricalMember(MemberSurface):
    """One member of a cylindrical pair."""

    teeth: Annotated[int, Field(ge=5, le=400)]
    profile_shift: Annotated[float, ValueRange("", ge=-2.0, le=3.0)] = 0.0  # x of the basic rack [-]
    # of the basic rack over the module [-]
    addendum_factor: Factor = 1.0
    dedendum_factor: Factor = 1.25
    tip_diameter: Length | None = None  # [m]; from addendum, profile shift and centre distance if not given
    tip_relief: Depth = 0.0  # material removed at the tip, normal to the flank [m]
    # along the path of contact, from the tip down [m]; the relief grows linearly along it
    tip_relief_length: Depth = 0.0

    @model_validator(mode="after")
    def _relieved(self) -> Self:
        if (self.tip_relief > 0.0) != (self.tip_relief_length > 0.0):
            raise InputError("tip_relief_length", self.tip_relief_length, "given together with tip_relief")
        return self


class CylindricalDesign(PairDesign):
    """A cylindrical pair: the content of a design file with `kind = "cylindrical"`."""

    kind: Literal["cylindrical"] = "cylindrical"
    module_normal: Annotated[float, ValueRange("m", ge=1e-4, le=0.1)]  # m_n [m]
    # normal, and at the reference cylinder [rad]; helix 0 is a spur pair
    pressure_angle_normal: Annotated[float, ValueRange("rad", ge=0.2, le=0.6)] = math.radians(20.0)
    helix_angle: Annotated[float, ValueRange("rad", ge=0.0, le=0.8)] = 0.0
    face_width: Length  # in common [m]
    centre_distance: Length | None = None  # [m]; without backlash if not given
    # elastic teeth, or a load in proportion to the length of the contact lines
    load_share: Literal["elastic", "rigid"] = "elastic"
    edge_rounding: EdgeRounding | None = None  # radius of the tip edges [m]
    pinion: CylindricalMember
    gear: CylindricalMember

    @model_validator(mode="after")
    def _pair(self) -> Self:
        if self.pinion.teeth > self.gear.teeth:
            raise InputError("pinion.teeth", self.pinion.teeth, f"at most the {self.gear.teeth} teeth of the gear")
        pair = self.involute
        if pair.contact_ratio + pair.overlap_ratio < 1.0:
            total = f"a contact ratio of {pair.contact_ratio + pair.overlap_ratio:.3g}"
            raise InputError("centre_distance", total, "1 or more of tips and face together")
        for name, tip in zip(MEMBERS, pair.tip, strict=True):
            if pair.half_angle(MEMBERS.index(name), tip) <= 0.0:
                raise InputError(f"{name}.tip_diameter", f"{2e3 * tip:.6g} mm", "teeth that are not pointed")
        for member in (self.pinion, self.gear):
            if member.tip_relief_length > pair.path[1] - pair.path[0]:
                allowed = f"at most the path of contact, {1e3 * (pair.path[1] - pair.path[0]):.4g} mm"
                raise InputError("tip_relief_length", f"{1e3 * member.tip_relief_length:.4g} mm", allowed)
        return self

    @cached_property
    def involute(self) -> InvolutePair:
        """Geometry of the pair."""
        one, two = self.pinion, self.gear
        return InvolutePair(
            (one.teeth, two.teeth),
            self.module_normal,
            self.pressure_angle_normal,
            self.helix_angle,
            (one.profile_shift, two.profile_shift),
            self.face_width,
            self.centre_distance,
            (one.addendum_factor, two.addendum_factor),
            (one.dedendum_factor, two.dedendum_factor),
            (one.tip_diameter, two.tip_diameter),
        )

    @property
    def ratio(self) -> float:
        """Speed of the gear over that of the pinion [-]."""
        return self.pinion.teeth / self.gear.teeth

    @property
    def common_face_width(self) -> float:
        """Face width [m]."""
        return self.face_width

    @property
    def rounding(self) -> float:
        """Radius of the tip edges [m]."""
        return _EDGE_ROUNDING * self.module_normal if self.edge_rounding is None else self.edge_rounding

    def relief(self, place: FloatArray) -> FloatArray:
        """Gap from the tip relief of both members over the place on the path of contact [m]."""
        start, end = self.involute.path
        gap = np.zeros_like(place)
        for member, from_tip in ((self.pinion, end - place), (self.gear, place - start)):
            if member.tip_relief > 0.0:
                gap += member.tip_relief * np.clip(1.0 - from_tip / member.tip_relief_length, 0.0, None)
        return gap

    def rows(self) -> list[tuple[str, str]]:
        """Name and value of the figures of the pair, for tables."""
        pair, one, two = self.involute, self.pinion, self.gear

        def both(values: tuple[float, float], factor: float = 1e3, unit: str = " mm") -> str:
            return " / ".join(f"{factor * value:.5g}" for value in values) + unit

        return [
            ("teeth", f"{one.teeth} / {two.teeth}"),
            ("normal module", f"{1e3 * self.module_normal:.4g} mm"),
            ("helix angle", f"{math.degrees(self.helix_angle):.4g} deg"),
            ("profile shift", both((one.profile_shift, two.profile_shift), 1.0, "")),
            ("face width", f"{1e3 * self.face_width:.5g} mm"),
            ("centre distance", f"{1e3 * pair.centre:.5g} mm"),
            ("working pressure angle, transverse", f"{math.degrees(pair.working_angle):.4g} deg"),
            ("tip diameter", both((2.0 * pair.tip[0], 2.0 * pair.tip[1]))),
            ("tip relief", both((one.tip_relief, two.tip_relief), 1e6, " um")),
            ("contact ratio, transverse / overlap", both((pair.contact_ratio, pair.overlap_ratio), 1.0, "")),
            ("loss factor of Ohlendorf", f"{pair.loss_factor:.4f}"),
            ("load share", self.load_share),
            ("roughness Rq", both((one.roughness_rms, two.roughness_rms), 1e6, " um")),
        ]
