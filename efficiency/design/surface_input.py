"""Input: texture of the flanks, beside the Rq of each member."""

from __future__ import annotations

from ehl.inputs import Length, PeklenikNumber
from ehl.io.validation import InputModel


class FlankSurfaceInput(InputModel):
    """Table [surface]: what the roughness of both flanks has in common, as [surface] of a contact file.

    `correlation_length` is that across the contact line, `peklenik_number` its ratio along over across the line.
    """

    correlation_length: Length = 30e-6
    peklenik_number: PeklenikNumber = 1.0
