"""Designs with every number changed: the mirror image, another scale."""

from typing import Any, get_args

from pydantic import BaseModel

from efficiency.design.design import Design
from ehl.common.units import ValueRange


def rebuilt(design: Design, change: Any) -> Design:
    """The design with every number passed through ``change(unit, name, value)``."""

    def walk(model: BaseModel, name: str) -> dict[str, Any]:
        data: dict[str, Any] = {}
        for key, info in type(model).model_fields.items():
            value = getattr(model, key)
            optional = [part for kind in get_args(info.annotation) for part in getattr(kind, "__metadata__", ())]
            unit = next((part.unit for part in (*info.metadata, *optional) if isinstance(part, ValueRange)), None)
            if isinstance(value, BaseModel):
                value = walk(value, f"{name}.{key}")
            elif isinstance(value, float | str) and not isinstance(value, bool):
                value = change(unit, key, value)
            data[key] = value
        return data

    return Design.model_validate(walk(design, "design"))


def mirror(unit: str | None, name: str, value: Any) -> Any:
    if name == "hand":
        return {"left": "right", "right": "left"}[value]
    # of the modified roll the odd terms keep, the even ones change their sign: the cradle turns the other way
    return -value if name in ("cradle_angle", "swivel", "blank_offset", "modified_roll_2c") else value
