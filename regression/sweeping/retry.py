"""The next safer setting for a case the solver gave up: a finer mesh first, then nothing left out."""

from __future__ import annotations

from typing import get_args

from ehl.contact import Contact
from ehl.inputs import Accuracy

# the case itself is at fault, or the formula has no value there: no setting helps
FINAL_REASONS = frozenset({"too_hot", "shear_strength", "undefined"})
_LEVELS: tuple[str, ...] = get_args(Accuracy)


def safer_setting(case: Contact, step: int) -> tuple[Contact, str] | None:
    """The case with its settings made safer by so many steps, and what was changed; None beyond the safest.

    Parameters
    ----------
    case : Contact
        As planned.
    step : int
        0 is the case itself; each further step takes the next accuracy, the last one switches off the shortcuts.
    """
    if step == 0:
        return case, ""
    level = _LEVELS.index(case.model.accuracy)
    finer = min(level + step, len(_LEVELS) - 1)
    changes: dict[str, object] = {}
    if finer > level:
        # a tolerance of its own would decide on the mesh in place of the accuracy
        changes |= {"accuracy": _LEVELS[finer], "friction_tolerance": None}
    beyond = step - (finer - level)
    if beyond == 1 and case.model.shortcuts != "off":
        changes["shortcuts"] = "off"
    elif beyond > 0:
        return None
    words = " ".join(f"{name}={value}" for name, value in changes.items() if value is not None)
    return case.model_copy(update={"model": case.model.model_copy(update=changes)}), words
