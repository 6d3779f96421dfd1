"""Plans of a few cases that tests of the sweep and the fit share."""

import tomllib
from pathlib import Path
from typing import Any

import regression
from regression.data.dataset import Dataset

# the command line in a process of its own, whose networks are hardly trained: how jobs follow each other is in question
PROGRAM = "import regression.fitting.coefficients as t; t._STEPS = (5, 5); from efficiency.cli import main; main()"

# one point for the command `mu`
POINT = {"--pressure": "1 GPa", "--radius": "12 mm", "--speed": "5 m/s", "--slide-to-roll": "0.3"}
POINT |= {"--temperature": "80 degC", "--roughness-rms": "0.4 um"}

# ranges of a spiral bevel pair in the middle of its duty, in which every published formula has a value
GEAR_VARIABLES = """[variables]
pressure_hertz = { low = "0.4 GPa", high = "1.6 GPa" }
radius_equivalent = { low = "8 mm", high = "40 mm", scale = "log" }
speed_entrainment = { low = "1 m/s", high = "15 m/s", scale = "log" }
slide_to_roll = { low = 0.02, high = 1.2, scale = "log" }
temperature_oil = { low = "60 degC", high = "120 degC" }
roughness_rms = { low = "0.2 um", high = "0.6 um", scale = "log" }
[lubricant]
oil = "fva3"
"""


def point_options(**changes: str) -> list[str]:
    """Options of `POINT`, some of them put in place or added."""
    options = POINT | {f"--{name.replace('_', '-')}": value for name, value in changes.items()}
    return [part for option in options.items() for part in option]


def gear_plan(name: str, sampling: dict[str, Any], **variables: Any) -> dict[str, Any]:
    """Content of a plan with the ranges of `GEAR_VARIABLES`, some of them put in place."""
    content = tomllib.loads(GEAR_VARIABLES)
    return {"name": name, "sampling": sampling, **content, "variables": content["variables"] | variables}


def sweep_plan(name: str, **model: Any) -> dict[str, Any]:
    """Content of a plan of 16 cases that differ in pressure and sliding, for tests of how they are computed."""
    return {
        "name": name,
        "sampling": {"size": 16},
        "variables": {
            "pressure_hertz": {"low": "0.4 GPa", "high": "1.6 GPa"}, "radius_equivalent": "10 mm",
            "speed_entrainment": "5 m/s", "slide_to_roll": {"low": 0.02, "high": 1.0}, "temperature_oil": "80 degC",
            "roughness_rms": "0.4 um",
        },
        "lubricant": {"oil": "fva3"},
        "model": model,
    }  # fmt: skip


def swept(folder: Path, content: dict[str, Any], formula: str = "arana_2019") -> Dataset:
    """Friction of a published formula at the cases of a plan."""
    return regression.sweep(regression.Plan.from_dict(content), folder, formula=formula, jobs=1).dataset()
