"""Relief of tip, toe and heel in a design file."""

from __future__ import annotations

import math
from typing import Annotated, Self

from pydantic import model_validator

from efficiency.contact.relief import EdgeRelief, MemberRelief, ReliefForm
from efficiency.cutting.blank import Blank
from ehl.common.errors import InputError
from ehl.common.units import ValueRange
from ehl.common.validation import InputModel

ReliefAmount = Annotated[
    float, ValueRange("m", gt=0.0, le=1e-3, hint="Relief takes material off; leave the table out for none.")
]
ReliefLength = Annotated[float, ValueRange("m", gt=0.0, le=0.1)]

# of the mean transverse tooth thickness: relief of both flanks then leaves half of the tooth (ours)
_MAX_SHARE = 0.25


class EdgeReliefInput(InputModel):
    """Relief next to one edge of both flanks of a member.

    Attributes
    ----------
    amount : float
        Depth at the edge, square to the flank [m].
    length : float
        From the edge to where it begins: down the tooth for the tip, along the face for toe and heel [m].
    form : {"linear", "parabolic", "circular"}
        A flat chamfer, a parabola, or an arc.
    """

    amount: ReliefAmount
    length: ReliefLength
    form: ReliefForm = "parabolic"

    @model_validator(mode="after")
    def _flatter_than_half_a_right_angle(self) -> Self:
        if self.amount > self.length:
            raise InputError(
                "amount",
                f"{self.amount * 1e3:.6g} mm",
                f"at most its length of {self.length * 1e3:.6g} mm",
                "Relief is flatter than 45 deg: lower the amount or lengthen it.",
            )
        return self

    def relief(self) -> EdgeRelief:
        """Numbers of the relief."""
        return EdgeRelief(self.amount, self.length, self.form)


class MemberReliefInput(InputModel):
    """Relief of a member, the same on both flanks.

    Attributes
    ----------
    tip, toe, heel : EdgeReliefInput, optional
        Relief next to each edge; none where left out.
    """

    tip: EdgeReliefInput | None = None
    toe: EdgeReliefInput | None = None
    heel: EdgeReliefInput | None = None

    def check(self, blank: Blank) -> None:
        """Refuse relief larger than the tooth, naming the key of this table."""
        half = 0.5 * blank.face_width
        taper = math.tan(blank.addendum_angle) + math.tan(blank.dedendum_angle)
        depth = blank.mean_addendum + blank.mean_dedendum - half * abs(taper)
        if self.tip is not None and self.tip.length >= depth:
            raise InputError(
                "tip.length",
                f"{self.tip.length * 1e3:.6g} mm",
                f"below the least whole depth of the tooth, {depth * 1e3:.4g} mm",
                "Usual is a tenth to a third of the depth.",
            )
        ends = [end for end in (self.toe, self.heel) if end is not None]
        along = sum(end.length for end in ends)
        if ends and along >= blank.face_width:
            raise InputError(
                "toe.length" if self.toe is not None else "heel.length",
                f"{along * 1e3:.6g} mm at toe and heel together",
                f"below the face width, {blank.face_width * 1e3:.4g} mm",
                "Usual is a twentieth to a fifth of the face at each end.",
            )
        thickness = math.pi * blank.mean_cone_distance * math.sin(blank.pitch_angle) / blank.teeth
        for name in ("tip", "toe", "heel"):
            given: EdgeReliefInput | None = getattr(self, name)
            if given is not None and given.amount > _MAX_SHARE * thickness:
                raise InputError(
                    f"{name}.amount",
                    f"{given.amount * 1e3:.6g} mm",
                    f"at most {_MAX_SHARE * thickness * 1e3:.4g} mm, a quarter of the tooth's thickness",
                    "Usual are 10 to 60 um; a larger chamfer belongs into addendum or face width.",
                )

    def relief(self) -> MemberRelief:
        """Numbers of the relief."""
        parts = {name: getattr(self, name) for name in ("tip", "toe", "heel")}
        return MemberRelief(**{name: None if part is None else part.relief() for name, part in parts.items()})
