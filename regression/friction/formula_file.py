"""Formula files on disk: their text, the schema they were written in, and what is wrong with one that is refused."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from typing import Any

from ehl.io.errors import InputError
from ehl.io.validation import validate
from regression.friction.formula import FORMULA_SCHEMA, Formula

_ALLOWED = "a formula file written by `mixed-ehl fit`"


def formula_text(formula: Formula) -> str:
    """JSON with a checksum; numbers keep all their digits, rows of numbers stand on one line."""
    content = formula.model_dump(mode="json", by_alias=True)
    content["checksum"] = _checksum(content)
    text = json.dumps(content, indent=2, allow_nan=False)
    numbers = re.compile(r"\[\s+((?:-?[\d.][\w.+-]*,\s+)*-?[\d.][\w.+-]*)\s+\]")
    return numbers.sub(lambda found: "[" + re.sub(r"\s+", " ", found[1]) + "]", text) + "\n"


def load_formula(path: str | Path) -> Formula:
    """Read a formula file of this or an earlier schema.

    Raises
    ------
    InputError
        The file does not exist, is no formula file, was damaged or edited, or was written with a newer schema.
    """
    path = Path(path)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError("formula file", str(path), _ALLOWED, "The file does not exist.") from None
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        hint = f"It could not be read: {error}. Fit it again with `mixed-ehl fit RUN -o {path.name}`."
        raise InputError("formula file", str(path), _ALLOWED, hint) from None
    if not isinstance(content, dict) or not isinstance(content.get("schema"), int):
        raise InputError("formula file", str(path), _ALLOWED, "It holds no schema number.")
    schema = content["schema"]
    if schema > FORMULA_SCHEMA:
        raise InputError(
            f"{path.name}.schema",
            schema,
            f"at most {FORMULA_SCHEMA}",
            f"It was written by the newer version {content.get('writer', 'unknown')}; update mixed-ehl to read it.",
        )
    if schema < 2:
        return validate(Formula, _from_schema_1(content), path.name)
    stated = content.pop("checksum", None)
    formula = validate(Formula, content, path.name)
    if stated != _checksum(content):
        hint = "It was edited by hand or damaged, and its errors speak for other numbers: fit it again."
        raise InputError(f"{path.name}.checksum", stated, "the checksum of the file's content", hint)
    return formula


def _from_schema_1(content: dict[str, Any]) -> dict[str, Any]:
    """Schema 1 knew one oil, and neither residual, cloud of cases, gear paths nor repeated realisations."""
    oil = content.get("oil")
    named = isinstance(oil, dict) and oil.get("name") is not None
    rest = {name: value for name, value in content.items() if name != "oil"}
    return {**rest, "schema": FORMULA_SCHEMA, "oils": [oil] if named else []}


def _checksum(content: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
