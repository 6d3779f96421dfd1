"""Input files: TOML text to a validated model, with errors a user can act on."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, ValidationError

from ehl.io.errors import InputError
from ehl.io.expectation import expectation, find_place


class InputModel(BaseModel):
    """Base of all input models: frozen, and an unknown key is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True, defer_build=True)


Model = TypeVar("Model", bound=BaseModel)


def read_toml(path: str | Path) -> dict[str, Any]:
    """Read a TOML file.

    Raises
    ------
    InputError
        The file does not exist, cannot be read or is not TOML.
    """
    path = Path(path)
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError("file", str(path), "an existing TOML file", "Check the path.") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError("file", str(path), "a readable UTF-8 TOML file", f"It could not be read: {error}.") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError("file", str(path), "valid TOML", f"{error}.") from None


def validate(model: type[Model], content: dict[str, Any], where: str = "") -> Model:
    """Build a model, turning the first of pydantic's complaints into one `InputError`.

    Parameters
    ----------
    model : type
        The pydantic model.
    content : dict
        What the file holds.
    where : str
        Name put before the field (file name or table).
    """
    try:
        return model.model_validate(content)
    except ValidationError as error:
        raise input_error(error, model, where) from None


def input_error(error: ValidationError, model: type[BaseModel], where: str = "") -> InputError:
    """The `InputError` that says the same as pydantic's first complaint."""
    complaints = error.errors(include_url=False)
    first = complaints[0]
    place = find_place(model, first["loc"])
    parts = ([where] if where else []) + list(place.path)
    field = ".".join(parts) or model.__name__
    kind = first["type"]
    value = None if kind == "missing" else first["input"]
    if isinstance(value, dict):
        value = "table with " + ", ".join(sorted(map(str, value))[:8])
    more = f"({len(complaints) - 1} more problem(s) in this input.)" if len(complaints) > 1 else ""
    context = first.get("ctx") or {}
    if kind.startswith("quantity"):
        return InputError(field, value, str(context["allowed"]), _join(context["hint"], more))
    if kind == "value_error" and isinstance(context.get("error"), InputError):
        inner: InputError = context["error"]
        return InputError(".".join([*parts, inner.field]), inner.value, inner.allowed, _join(inner.hint, more))
    if kind == "extra_forbidden":
        known = ", ".join(sorted(_keys(place.owner)))
        return InputError(field, value, "only the documented keys of this table", _join(f"Known keys: {known}.", more))
    if kind.startswith("union_tag"):
        key = str(context["discriminator"]).strip("'")
        return InputError(".".join([*parts, key]), context.get("tag"), _tags(place.annotation, key), more)
    return InputError(field, value, expectation(place, ".".join(place.path)) or first["msg"], more)


def _join(*texts: str) -> str:
    return " ".join(filter(None, texts))


def _keys(owner: type[BaseModel]) -> set[str]:
    return {info.alias or name for name, info in owner.model_fields.items()}


def _tags(annotation: Any, key: str) -> str:
    """Values of the key that chooses between the members of a union."""
    members = (part for part in get_args(annotation) if isinstance(part, type) and issubclass(part, BaseModel))
    return "one of " + ", ".join(
        repr(tag) for member in members for tag in get_args(member.model_fields[key].annotation)
    )
