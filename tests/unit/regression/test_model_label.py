"""Friction models are named on pages and in figures as an engineer writes them."""

from __future__ import annotations

import pytest

from regression.friction.published_registry import PUBLISHED, model_label


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("constant:0.05", "constant 0.05"),
        ("constant:0.0277647, fitted to ehl", "constant 0.0278, fitted to solved contacts"),
        ("xu_kahraman_2007", "Xu & Kahraman 2007"),
        ("odonoghue_cameron_1966", "O'Donoghue & Cameron 1966"),
        ("iso_tr_14179_2", "ISO/TR 14179-2"),
        ("ehl", "solved contacts"),
        ("ehl:smooth:all", "solved contacts, smooth, all"),
        ("75w90", "formula 75w90"),
        ("oils/formula_iso_220.json", "formula iso_220"),
        ("formula.json", "formula"),
    ],
)
def test_label(name: str, label: str) -> None:
    assert model_label(name) == label


def test_no_published_label_is_a_code_name() -> None:
    assert all("_" not in formula.label for formula in PUBLISHED.values())
    assert len({formula.label for formula in PUBLISHED.values()}) == len(PUBLISHED)
