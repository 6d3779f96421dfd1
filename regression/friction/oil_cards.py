"""Identity of the oil cards of data: hash of their values."""

import hashlib
from collections.abc import Container
from functools import lru_cache
from typing import Any

from pydantic_core import to_json

from ehl.common.errors import InputError
from ehl.common.validation import InputModel
from ehl.fluid.oil import Oil

# origin, range and uncertainty do not change the values of a card. Scuffing stage and permissible film have no effect
# on friction, and the shear modulus none at the slip of fitted formulas. Formulas that were fitted with a constant
# Eyring stress remain valid for a rising one, and those of an oil for its `varied` cards
_NOT_HASHED = {
    *("description", "source", "pressure_valid", "calibration", "uncertainty", "fzg_stage", "film_permissible"),
    *("shear_modulus", "eyring_stress_pressure", "factors"),
}


@lru_cache(maxsize=64)
def card_hash(oil: Oil) -> str:
    """Hash of the values of an oil card that determine friction."""
    content = _given(oil.model_dump(exclude=_NOT_HASHED), {"density_pressure", "conductivity_pressure"})
    law = content["pressure_viscosity"]
    own = {"alpha_definition"} if law["law"] in ("table", "gold") else law
    return hashlib.sha256(to_json(content | {"pressure_viscosity": _given(law, own)})).hexdigest()


def _given(table: dict[str, Any], optional: Container[str]) -> dict[str, Any]:
    """A table without its optional keys that have no value."""
    return {name: value for name, value in table.items() if value is not None or name not in optional}


class OilIdentity(InputModel):
    """Oil of computed data: name or path of its card, and hash of the card (None if unknown)."""

    name: str | None = None
    card_hash: str | None = None

    def compared(self, oil: Oil) -> bool | None:
        """Whether the data were computed with the same card of this oil; None for another oil."""
        if not self._names(oil):
            return None
        return self.card_hash in (None, card_hash(oil))

    def _names(self, oil: Oil) -> bool:
        if self.name is None or self.name == oil.name or self.card_hash == card_hash(oil):
            return self.name is not None
        if not self.name.endswith(".toml"):
            return False
        try:
            return Oil.load(self.name).name == oil.name
        except InputError:  # the file has been moved or changed
            return False


def cards_hash(hashes: list[str]) -> str:
    """One hash for the oil cards of a run; that of the card if there is only one."""
    if len(hashes) <= 1:
        return hashes[0] if hashes else ""
    return hashlib.sha256("\n".join(hashes).encode()).hexdigest()


def hashes_of_cards(names: tuple[str, ...], together: str) -> dict[str, str | None]:
    """Hash of each oil card of a run from the hash of the run; None for all if one of several cards has changed."""
    if len(names) <= 1:
        return dict.fromkeys(names, together)
    try:
        found = [card_hash(Oil.load(name)) for name in names]
    except InputError:
        return dict.fromkeys(names)
    if cards_hash(found) != together:
        return dict.fromkeys(names)
    return dict(zip(names, found, strict=True))
