"""The field's words: what a tribologist or a gear engineer searches for is found in the code that computes it.

One case-insensitive search for each term, in the folders named beside it. Terms in comments and docstrings count, terms
in docs/ do not: the reader is looking for the place, not for a manual.
"""

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

# folders: terms of what is computed there; every one of the folders holds them
WORDS = {
    "ehl/smooth ehl/rough": "Reynolds equation, Poiseuille, Couette, cavitation",
    "ehl/smooth": "Swift-Stieber",
    "ehl/rough": "JFO, Elrod-Adams, side flow, complementarity, asperity",
    "ehl": "half-space, boundary friction, Moes",
    "ehl efficiency": "Hertz",
    "ehl/fluid": (
        "Ree-Eyring, Carreau, limiting shear stress, Roelands, Barus, Walther, pressure-viscosity "
        "coefficient, Dowson-Higginson"
    ),
    "regression": "load sharing, Sobol, conformal, convex hull",
    "ehl regression": "film ratio",
    "ehl/surface": "correlation length",
    "ehl/surface ehl/rough": "Peklenik",
    "ehl/heat efficiency/loss": "flash temperature",
    "ehl/heat": "Peclet, Jaeger",
    "efficiency/loss": "Blok, Coleman, Buckingham",
    "regression/fitting": "cross-validation",
    "regression/friction regression/fitting": "neural networks",
    "efficiency/contact": "ease-off, Litvin, TCA, contact pattern, transmission error",
    "efficiency/ltca": "LTCA, Weber",
    "efficiency/blanks efficiency/cutting": "undercut",
    "efficiency/cutting": "cradle, tilt, swivel, equation of meshing",
    "efficiency/blanks": "hypoid offset, spiral angle",
}


@pytest.mark.parametrize("places", WORDS)
def test_words_are_found_where_it_is_computed(places: str) -> None:
    for place in places.split():
        # a term may be broken over two lines of a docstring
        files = sorted((ROOT / place).rglob("*.py"))
        text = " ".join(" ".join(file.read_text(encoding="utf-8") for file in files).lower().split())
        assert [word for word in WORDS[places].split(", ") if word.lower() not in text] == [], place
