"""A function in C as a Functional Mock-up Unit (FMI 2.0.4, model exchange and co-simulation), without states or Python.

The unit contains its C sources; a library for the exporting machine is added if it has a C compiler.
"""

import hashlib
import io
import logging
import platform
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as Xml

from ehl import __version__
from regression.export.c_text import c_text
from regression.export.printer import flag_meanings
from regression.export.program import MEANING, OUTPUTS, Program
from regression.friction.conditions import UNITS

# exponents of SI base units, of the units of inputs and outputs
_UNITS: dict[str, dict[str, int]] = {
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "K": {"K": 1},
    "rad/s": {"rad": 1, "s": -1},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Pa.s": {"kg": 1, "m": -1, "s": -1},
    "m2/s": {"m": 2, "s": -1},
    "1/Pa": {"kg": -1, "m": 1, "s": 2},
    "1/K": {"K": -1},
    "W/(m.K)": {"kg": 1, "m": 1, "s": -3, "K": -1},
}
_SIGNS = str.maketrans("* ", "..", "^")  # from units of the program
# folder and suffix of libraries by system and processor
_PLATFORMS = {
    ("Linux", "x86_64"): ("linux64", ".so"),
    ("Windows", "AMD64"): ("win64", ".dll"),
    ("Darwin", "x86_64"): ("darwin64", ".dylib"),
}
_log = logging.getLogger("mixed_ehl")
_FLAGS = ("-std=c99", "-O3", "-fno-math-errno", "-shared", "-fPIC", "-fvisibility=hidden")
_START = {
    "pressure_hertz": 1e9,
    "radius_equivalent": 0.015,
    "effective_modulus": 2.26e11,
    "speed_entrainment": 5.0,
    "slide_to_roll": 0.2,
    "temperature_oil": 353.15,
    "correlation_length": 16e-6,
    "peklenik_number": 1.0,
    "roughness_rms": 0.4e-6,
}


@dataclass(frozen=True)
class Variable:
    """An input or output, a real number."""

    name: str
    unit: str  # empty, or one of `_UNITS`
    description: str
    start: float | None = None  # of inputs


def friction_fmu(program: Program, name: str) -> bytes:
    """The unit of the friction of one contact: arguments of the function in, `OUTPUTS` out.

    Raises `InputError`: its oil is not written into the program.
    """
    inputs = [Variable(n, UNITS[n].translate(_SIGNS), MEANING[n], _START.get(n, 0.0)) for n in program.arguments]
    meaning = ("friction coefficient", "lower end of its interval", "upper end of its interval", flag_meanings(program))
    outputs = [Variable(output, "", text) for output, text in zip(OUTPUTS, meaning, strict=True)]
    arguments = ", ".join(f"u[{k}]" for k in range(len(inputs)))
    body = f"    const {name}_result r = {name}({arguments});"
    body += "".join(f"\n    y[{k}] = r.{output};" for k, output in enumerate(OUTPUTS))
    about = f"Friction of a lubricated line contact, {program.formula.label}, oil {program.oil or 'by its properties'}"
    return fmu(name, about, inputs, outputs, c_text(program, name), body)


def fmu(
    name: str, about: str, inputs: Sequence[Variable], outputs: Sequence[Variable], source: str, body: str
) -> bytes:
    """The content of a file .fmu.

    name: of the unit, an identifier of C.
    source: C text in front of the function that fills y (outputs) from u (inputs).
    body: statements of that function.
    """
    starts = ", ".join(repr(float(variable.start or 0.0)) for variable in inputs)
    guid = "{" + hashlib.sha256(f"{source}{body}{starts}".encode()).hexdigest()[:32] + "}"
    text = f"""{source}
enum {{ INPUTS = {len(inputs)}, OUTPUTS = {len(outputs)} }};
#define GUID "{guid}"
static const double starts[INPUTS] = {{{starts}}};

static void outputs(const double u[], double y[])
{{
{body}
}}

{Path(__file__).with_name("fmi2.c").read_text(encoding="utf-8")}"""
    members = {
        "modelDescription.xml": _model_description(name, about, guid, inputs, outputs),
        f"sources/{name}.c": text.encode(),
        **_library(name, text),
    }
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as unit:
        for member, content in members.items():
            # the same content gives the same file
            unit.writestr(zipfile.ZipInfo(member), content, zipfile.ZIP_DEFLATED)
    return file.getvalue()


def _model_description(
    name: str, about: str, guid: str, inputs: Sequence[Variable], outputs: Sequence[Variable]
) -> bytes:
    root = Xml.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=name,
        guid=guid,
        description=about,
        generationTool=f"mixed-ehl {__version__}",
        variableNamingConvention="flat",
        numberOfEventIndicators="0",
    )
    common = {"modelIdentifier": name, "canNotUseMemoryManagementFunctions": "true"}
    for tag, more in (("ModelExchange", {}), ("CoSimulation", {"canHandleVariableCommunicationStepSize": "true"})):
        sources = Xml.SubElement(Xml.SubElement(root, tag, common | more), "SourceFiles")
        Xml.SubElement(sources, "File", name=f"{name}.c")
    variables = [*inputs, *outputs]
    if used := dict.fromkeys(variable.unit for variable in variables if variable.unit):
        units = Xml.SubElement(root, "UnitDefinitions")
        for unit in used:
            base = {symbol: str(exponent) for symbol, exponent in _UNITS[unit].items()}
            Xml.SubElement(Xml.SubElement(units, "Unit", name=unit), "BaseUnit", base)
    listed, structure = Xml.SubElement(root, "ModelVariables"), Xml.SubElement(root, "ModelStructure")
    for number, variable in enumerate(variables):
        causality = {"causality": "input"} if number < len(inputs) else {"causality": "output", "initial": "calculated"}
        scalar = Xml.SubElement(
            listed,
            "ScalarVariable",
            name=variable.name,
            valueReference=str(number),
            description=variable.description,
            variability="continuous",
            attrib=causality,
        )
        real = {"unit": variable.unit} if variable.unit else {}
        Xml.SubElement(
            scalar, "Real", real | ({} if variable.start is None else {"start": repr(float(variable.start))})
        )
    for part in ("Outputs", "InitialUnknowns"):
        unknowns = Xml.SubElement(structure, part)
        for number in range(len(inputs), len(variables)):
            Xml.SubElement(unknowns, "Unknown", index=str(number + 1))
    Xml.indent(root)
    text: bytes = Xml.tostring(root, encoding="utf-8", xml_declaration=True)
    return text


def _library(name: str, text: str) -> dict[str, bytes]:
    """The compiled library by its path in the unit; empty, with a warning, if compilation is impossible."""
    compiler = next(filter(None, map(shutil.which, ("gcc", "cc", "clang"))), None)
    place = _PLATFORMS.get((platform.system(), platform.machine()))
    if compiler is None or place is None:
        lacking = "no C compiler was found" if place else f"FMI 2.0 has no name for {platform.machine()}"
        _log.warning("%s: the FMU contains C sources without a library", lacking)
        return {}
    folder, suffix = place
    with tempfile.TemporaryDirectory() as work:
        source, library = Path(work, f"{name}.c"), Path(work, f"{name}{suffix}")
        source.write_text(text, encoding="utf-8")
        try:
            subprocess.run([compiler, *_FLAGS, source, "-o", library, "-lm"], check=True, capture_output=True)
        except (OSError, subprocess.CalledProcessError) as error:
            _log.warning("%s failed (%s): the FMU contains C sources without a library", compiler, error)
            return {}
        return {f"binaries/{folder}/{name}{suffix}": library.read_bytes()}
