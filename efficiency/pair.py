"""The geometry of one gear pair and one flank pair in mesh: what stages 1 and 2 of the method leave behind."""

from __future__ import annotations

from dataclasses import dataclass

from efficiency.blank import ToothShape


@dataclass(frozen=True)
class GearPair:
    """Geometry of a pair, for one side (drive or coast) and one set of misalignments.

    Attributes
    ----------
    name : str
        Name of the design.
    side : str
        ``"drive"`` or ``"coast"``: which flank pair is in contact.
    teeth_pinion, teeth_gear : int
        Numbers of teeth.
    shape_pinion, shape_gear : ToothShape
        Depth and thickness of one tooth of each member along its face.
    """

    name: str
    side: str
    teeth_pinion: int
    teeth_gear: int
    shape_pinion: ToothShape
    shape_gear: ToothShape
