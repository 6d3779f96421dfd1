"""Input files: TOML text to a validated model, with errors a user can act on."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from ehl.errors import InputError


class InputModel(BaseModel):
    """Base of all input models: frozen, and an unknown key is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)


Model = TypeVar("Model", bound=BaseModel)

_UNION_TAGS = {"card", "direct", "table", "gold", "modulus", "roelands", "barus", "face_milling", "generated"}

_WORDS = {
    "missing": "this key is required",
    "extra_forbidden": "only the documented keys of this table",
}


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
    # pydantic puts the tag of a union into the path; the user never wrote it
    parts = [str(part) for part in first["loc"] if str(part) not in _UNION_TAGS]
    field = ".".join(([where] if where else []) + parts) or model.__name__
    kind = first["type"]
    value = None if kind == "missing" else first["input"]
    if isinstance(value, dict):
        value = "table with " + ", ".join(sorted(map(str, value))[:8])
    hint = f"({len(complaints) - 1} more problem(s) in this input.)" if len(complaints) > 1 else ""
    context = first.get("ctx") or {}
    if kind.startswith("quantity"):
        return InputError(field, value, str(context["allowed"]), " ".join(filter(None, [context["hint"], hint])))
    if kind == "value_error" and isinstance(context.get("error"), InputError):
        inner: InputError = context["error"]
        inner_field = ".".join([*([where] if where else []), *parts, inner.field])
        return InputError(inner_field, inner.value, inner.allowed, " ".join(filter(None, [inner.hint, hint])))
    if kind == "extra_forbidden":
        known = ", ".join(sorted(_known_keys(model, parts[:-1])))
        hint = " ".join(filter(None, [f"Known keys: {known}." if known else "", hint]))
    if kind == "literal_error":
        return InputError(field, value, str(context.get("expected", first["msg"])), hint)
    return InputError(field, value, _WORDS.get(kind, first["msg"]), hint)


def _known_keys(model: type[BaseModel], path: list[str]) -> set[str]:
    current: Any = model
    for part in path:
        info = getattr(current, "model_fields", {}).get(part)
        current = getattr(info, "annotation", None)
        if not (isinstance(current, type) and issubclass(current, BaseModel)):
            return set()
    return set(current.model_fields)
