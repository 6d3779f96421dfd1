"""Every reason that the program can give has a sentence."""

import ast
from pathlib import Path

import pytest

from ehl.common.data import _sentences, reason_text
from ehl.common.errors import ConvergenceError

ROOT = Path(__file__).resolve().parents[2]
RAISED = {"ConvergenceError", "NewtonFailure"}
LISTS = {"REASONS", "Reason", "FALLBACKS", "FINAL_REASONS", "TIME_CAP", "WORKER_CRASHED"}


def reasons() -> set[str]:
    """Codes of errors, of the lists of reasons, and of `reason=` arguments."""
    found: set[str] = set()
    for path in (path for package in ("ehl", "regression", "efficiency") for path in (ROOT / package).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            parts: list[ast.expr] = []
            if isinstance(node, ast.Call):
                parts = [keyword.value for keyword in node.keywords if keyword.arg == "reason"]
                parts += node.args[:1] if getattr(node.func, "id", "") in RAISED else []
            elif isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") in LISTS:
                parts = [each for each in ast.walk(node.value) if isinstance(each, ast.Constant)]
            found |= {p.value for p in parts if isinstance(p, ast.Constant) and isinstance(p.value, str)}
    return {text.partition(":")[0] for text in found if text}


def test_every_reason_has_a_sentence() -> None:
    assert len(reasons()) > 50
    assert not reasons() - _sentences().keys()
    assert all(" " in sentence for sentence in _sentences().values())


@pytest.mark.parametrize("detail", ["", ": the coast flank ends"])
def test_a_reason_is_said_in_words(detail: str) -> None:
    said = _sentences()["undercut"]
    assert reason_text(f"undercut{detail}") == said + detail
    assert str(ConvergenceError("undercut", detail[2:])).startswith(said)
    assert reason_text("any other text: 3") == "any other text: 3"
