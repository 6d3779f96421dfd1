"""JSON on the terminal."""

from __future__ import annotations

import json
from typing import Any


def print_json(content: dict[str, Any]) -> None:
    """One JSON object on standard output, strict (no NaN)."""
    print(json.dumps(content, allow_nan=False))
