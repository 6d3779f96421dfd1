"""Input: the body under the teeth of a member, how thick it is and where it is held."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from efficiency.blanks.cones import Blank
from efficiency.design.flank_input import Length
from ehl.io.errors import InputError
from ehl.io.units import ValueRange
from ehl.io.validation import InputModel

Surface = Literal["base", "toe", "heel"]
Modulus = Annotated[float, ValueRange("Pa", gt=0.0, le=1e15)]

# rim over whole depth where the design does not say: from this backup ratio on AGMA 2001 (from memory) counts no rim
# as thin
BACKUP_RATIO = 1.2
# at most this share of the way from the root to the axis, so that a slender pinion keeps a core
_TO_AXIS, _MOST_TO_AXIS = 0.5, 0.9


class BodyInput(InputModel):
    """Body under the teeth: from the root cone down to its base, between the end faces of the teeth.

    The base is the surface `rim_thickness` below the root cone, square to the pitch cone: the seat of a ring gear, the
    bore or core of a pinion. `held` names the surfaces that do not move against the shaft: the base, the toe or the
    heel face of the body. A very large `youngs_modulus` makes the body rigid, a small one stands for a web.
    """

    rim_thickness: Length | None = None
    held: Annotated[tuple[Surface, ...], Field(min_length=1)] = ("base",)
    youngs_modulus: Modulus | None = None

    def thickness(self, blank: Blank) -> float:
        """Rim thickness for a blank [m].

        Raises
        ------
        InputError
            The rim would reach the axis.
        """
        ends = np.array([-0.5, 0.5]) * blank.face_width
        to_axis = float(blank.axial(ends, blank.root(ends))[0].min()) / math.cos(blank.pitch_angle)
        if self.rim_thickness is None:
            return min(BACKUP_RATIO * (blank.mean_addendum + blank.mean_dedendum), _TO_AXIS * to_axis)
        if self.rim_thickness > _MOST_TO_AXIS * to_axis:
            raise InputError(
                "body.rim_thickness",
                f"{self.rim_thickness * 1e3:.6g} mm",
                f"at most {_MOST_TO_AXIS * to_axis * 1e3:.6g} mm, {_MOST_TO_AXIS:g} of the way from root to axis",
            )
        return self.rim_thickness
