"""The field's words: what a tribologist or a gear engineer searches for is found in the code that computes it.

One case-insensitive search for each term, in the folders named beside it. Terms in comments and docstrings count, terms
in docs/ do not: the reader is looking for the place, not for a manual.
"""

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

# term: folders or modules in which it is computed; every one of them holds it
WORDS: dict[str, tuple[str, ...]] = {
    # the lubricated contact
    "Reynolds equation": ("ehl/smooth", "ehl/rough"),
    "Poiseuille": ("ehl/smooth", "ehl/rough"),
    "Couette": ("ehl/smooth", "ehl/rough"),
    "cavitation": ("ehl/smooth", "ehl/rough"),
    "Swift-Stieber": ("ehl/smooth",),
    "JFO": ("ehl/rough",),
    "Elrod-Adams": ("ehl/rough",),
    "side flow": ("ehl/rough",),
    "complementarity": ("ehl/rough",),
    "half-space": ("ehl",),
    "Hertz": ("ehl", "efficiency"),
    "Ree-Eyring": ("ehl/fluid",),
    "Carreau": ("ehl/fluid",),
    "limiting shear stress": ("ehl/fluid",),
    "Roelands": ("ehl/fluid",),
    "Barus": ("ehl/fluid",),
    "Walther": ("ehl/fluid",),
    "pressure-viscosity coefficient": ("ehl/fluid",),
    "Dowson-Higginson": ("ehl/fluid",),
    "Moes": ("ehl/fluid",),
    "load sharing": ("regression",),
    "film ratio": ("ehl", "regression"),
    "boundary friction": ("ehl",),
    "asperity": ("ehl/rough",),
    "correlation length": ("ehl/surface",),
    "Peklenik": ("ehl/surface", "ehl/rough"),
    "flash temperature": ("ehl/heat", "efficiency/loss"),
    "Peclet": ("ehl/heat",),
    "Jaeger": ("ehl/heat",),
    "Blok": ("efficiency/loss",),
    # the formula
    "Sobol": ("regression",),
    "cross-validation": ("regression/fitting",),
    "neural networks": ("regression/friction", "regression/fitting"),
    "conformal": ("regression",),
    "convex hull": ("regression",),
    # the gear pair
    "ease-off": ("efficiency/contact",),
    "Litvin": ("efficiency/contact",),
    "TCA": ("efficiency/contact",),
    "LTCA": ("efficiency/ltca",),
    "contact pattern": ("efficiency/contact",),
    "transmission error": ("efficiency/contact",),
    "undercut": ("efficiency/blanks", "efficiency/cutting"),
    "cradle": ("efficiency/cutting",),
    "tilt": ("efficiency/cutting",),
    "swivel": ("efficiency/cutting",),
    "equation of meshing": ("efficiency/cutting",),
    "hypoid offset": ("efficiency/blanks",),
    "spiral angle": ("efficiency/blanks",),
    "Weber": ("efficiency/ltca",),
    "Coleman": ("efficiency/loss",),
    "Buckingham": ("efficiency/loss",),
}


def text_of(place: str) -> str:
    path = ROOT / place
    files = sorted(path.rglob("*.py")) if path.is_dir() else [path]
    assert files, f"{place} holds no code"
    # a term may be broken over two lines of a docstring
    return " ".join(" ".join(file.read_text(encoding="utf-8") for file in files).lower().split())


@pytest.mark.parametrize("word", [word for word, places in WORDS.items() if places])
def test_word_is_found_where_it_is_computed(word: str) -> None:
    missing = [place for place in WORDS[word] if word.lower() not in text_of(place)]
    assert not missing


def test_the_list_is_long_enough() -> None:
    assert len(WORDS) >= 40
