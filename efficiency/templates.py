"""Input files to begin with: commented texts that work as they are, from a few answers."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ehl.common.data import data_names, data_path
from ehl.common.errors import InputError, near


@dataclass(frozen=True)
class Question:
    """One thing a new file asks for.

    Parameters
    ----------
    text : str
        What is asked.
    default : str
        Answer where none is given; empty where the file does without.
    key : str
        Key of the file it becomes, where that has another name.
    """

    text: str
    default: str
    key: str = ""


_OPERATION = {
    "torque": Question("Torque of the pinion.", "250 N m"),
    "speed": Question("Speed of the pinion.", "1500 rpm"),
    "temperature": Question("Temperature of the oil.", "90 degC"),
    "oil": Question("Oil: shipped, a card.toml, 'pao 97.5/13.3' or 'mineral vg 220'.", "75w90"),
}
_ROUGHNESS = Question("Rough contacts: deterministic (seconds) or load_sharing (milliseconds).", "deterministic")
_QUESTIONS = {
    "oil": {
        "base": Question("mineral, hydrocracked, pao, ester or polyglycol.", "mineral"),
        "vg": Question("ISO VG, if no viscosities are given.", "220", "iso_vg"),
        "nu40": Question("Viscosity at 40 degC: '97.5 cSt'.", "", "nu_40"),
        "nu100": Question("Viscosity at 100 degC: '13.3 cSt'.", "", "nu_100"),
        "density": Question("Density at 15 degC: '880 kg/m^3'; typical of the base if not given.", "", "density_15"),
    },
    "contact": {
        "oil": _OPERATION["oil"],
        "temperature": replace(_OPERATION["temperature"], key="temperature_oil"),
        "pressure": Question("Hertz pressure.", "1.2 GPa", "pressure_hertz"),
        "radius": Question("Equivalent radius of both bodies.", "15 mm", "radius_equivalent"),
        "speed": Question("Entrainment speed, the mean of both surfaces.", "5 m/s", "speed_entrainment"),
        "slide_to_roll": Question("Sliding speed over entrainment speed.", "0.2"),
        "roughness": Question("Rq of each surface, run in.", "0.3 um", "roughness_rms_1"),
        "model": Question(_ROUGHNESS.text, _ROUGHNESS.default, "roughness"),
    },
    "plan": {
        "oil": _OPERATION["oil"],
        "size": Question("Number of contacts.", "256"),
        "model": Question(_ROUGHNESS.text, _ROUGHNESS.default, "roughness"),
    },
    "design": {
        "like": Question("Shipped design that gives the flanks.", "fm_spiral_bevel_14x39"),
        **_OPERATION,
    },
    "targets": {
        "teeth_pinion": Question("Teeth of the pinion.", "13"),
        "teeth_gear": Question("Teeth of the gear.", "42"),
        "offset": Question("Hypoid offset; 0 mm for a spiral bevel pair.", "15 mm", "hypoid_offset"),
        "diameter": Question("Outer pitch diameter of the gear.", "170 mm", "outer_pitch_diameter_gear"),
        "face_width": Question("Face width of the gear.", "30 mm", "face_width_gear"),
        "spiral_angle": Question("Mean spiral angle of the gear.", "34 deg", "mean_spiral_angle_gear"),
        "pressure_angle": Question("Pressure angle of both flanks.", "20 deg", "drive"),
        "process": Question("face_milling or face_hobbing.", "face_milling"),
        "cutter_radius": Question("Radius of the cutter.", "76 mm"),
        "blade_groups": Question("Blade groups of the head, face hobbing only.", "13"),
        "finish": Question("How the flanks are finished: ground, lapped, honed, milled, superfinished.", "ground"),
        **_OPERATION,
    },
    "duty": {
        "torque": Question("Largest torque of the pinion.", "300 N m"),
        "speed": Question("Largest speed of the pinion.", "3000 rpm"),
        "temperature": Question("Temperature of the oil.", "90 degC"),
        "hours": Question("Hours of the whole cycle.", "1000"),
    },
}


def new_questions(kind: str) -> dict[str, tuple[str, str]]:
    """What `new_file` can be told for a kind of file.

    Parameters
    ----------
    kind : {"oil", "contact", "plan", "design", "targets", "duty"}
        Of file.

    Returns
    -------
    dict of str to (str, str)
        Keyword to what is asked and the answer taken where none is given.

    Raises
    ------
    InputError
        There is no such kind.

    Examples
    --------
    >>> import efficiency
    >>> efficiency.new_questions("contact")["pressure"]
    ('Hertz pressure.', '1.2 GPa')
    """
    if kind not in _QUESTIONS:
        raise InputError("kind", kind, "one of " + ", ".join(_QUESTIONS), near(kind, _QUESTIONS))
    return {name: (question.text, question.default) for name, question in _QUESTIONS[kind].items()}


def new_file(kind: str, name: str = "", **answers: float | str) -> str:
    """Text of a commented input file that works as it is.

    Parameters
    ----------
    kind : {"oil", "contact", "plan", "design", "targets", "duty"}
        Of file: TOML, for "duty" CSV.
    name : str
        Of oil, plan, design or targets; ``my_`` and the kind where not given.
    **answers : float or str
        Keywords of `new_questions`, texts with their unit.

    Returns
    -------
    str

    Raises
    ------
    InputError
        Naming keyword, value and what is allowed.

    Examples
    --------
    >>> import tomllib
    >>> import efficiency
    >>> import ehl
    >>> text = efficiency.new_file("contact", oil="fva3", pressure="1 GPa")
    >>> ehl.Contact.from_dict(tomllib.loads(text)).contact.pressure_hertz
    1000000000.0
    """
    known = new_questions(kind)
    for word, answer in answers.items():
        if word not in known:
            raise InputError(word, answer, "one of " + ", ".join(known), near(word, known))
    given = {word: str(answer) for word, answer in answers.items() if str(answer)}
    chosen = {word: default for word, (_, default) in known.items()} | given
    try:
        return _TEXTS[kind](name or f"my_{kind}", chosen, given)
    except InputError as error:
        raise error.changed(lambda problem: _of_answer(kind, problem)) from None


def _of_answer(kind: str, problem: InputError) -> InputError:
    """The problem of the file as one of the answer that went into it."""
    field = problem.field.rpartition(".")[2]
    words = {question.key or word: word for word, question in _QUESTIONS[kind].items()}
    return InputError(words.get(field, field), problem.value, problem.allowed, problem.hint)


def _value(text: str) -> str:
    """A number as it is, anything else as a text of TOML."""
    if re.fullmatch(r"[+-]?\d+(\.\d+)?([eE][+-]?\d+)?", text):
        return text if not re.fullmatch(r"[+-]?0\d+.*", text) else str(float(text))
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _filled(text: str, name: str, answers: Mapping[str, str]) -> str:
    """A template with its ``<answer>`` replaced; what a user typed must be one printable line."""
    for word, answer in {"name": name, **answers}.items():
        if not answer.isprintable() or len(answer) > 200:
            raise InputError(word, answer, "one line of at most 200 signs without control characters")
        text = text.replace(f"<{word}>", _value(answer) if word != "name" else '"' + _value(answer).strip('"') + '"')
    return text


def _oil(name: str, answers: Mapping[str, str], given: Mapping[str, str]) -> str:
    from ehl.fluid.oil import Oil
    from ehl.fluid.oil_sheet import card_text

    viscosities = {"nu40", "nu100"} & set(given)
    if viscosities and "vg" in given:
        raise InputError("vg", given["vg"], "either vg, or nu40 and nu100", "Leave one of them out.")
    if len(viscosities) == 1:
        missing = "nu100" if "nu40" in viscosities else "nu40"
        raise InputError(missing, None, "the viscosities at 40 and 100 degC, or vg alone")
    if not viscosities and not answers["vg"].isdigit():
        raise InputError("vg", answers["vg"], "a whole number such as 220")
    grade: dict[str, Any] = {"nu_40": given["nu40"], "nu_100": given["nu100"]} if viscosities else {}
    card = Oil.generic(
        answers["base"],
        **grade or {"iso_vg": int(answers["vg"][:9])},
        density_15=answers["density"] or None,
        name=name,
    )
    head = (
        f"Oil card {name}. Show it: mixed-ehl oil {name}.toml. Use it: oil = \"{name}.toml\" in any other file.\n"
        '# Put in what your data sheet says, with its unit: "97.5 cSt". The rest is typical of the base oil, and\n'
        "# [uncertainty] says how well it is known. viscosity_kinematic: m^2/s, density: kg/m^3, stress: Pa"
    )  # fmt: skip
    text = card_text(card, head)
    for key, value in (("40", card.viscosity_kinematic_40), ("100", card.viscosity_kinematic_100)):
        # as a data sheet has it
        text = text.replace(
            f"viscosity_kinematic_{key} = {value!r}", f'viscosity_kinematic_{key} = "{value * 1e6:.6g} cSt"'
        )
    return text


_CONTACT = """\
# One lubricated contact. Solve it: mixed-ehl solve FILE
# Numbers are SI; a text carries its unit. Every key: the page "nomenclature" of the documentation.

[contact]
radius_equivalent = <radius>           # 1/R = 1/R1 + 1/R2
pressure_hertz = <pressure>            # or load_per_length = "400 N/mm"
speed_entrainment = <speed>            # mean of both surface speeds, normal to the contact line
slide_to_roll = <slide_to_roll>        # sliding over entrainment speed, with its sign
speed_sliding_lengthwise = "0 m/s"     # sliding along the contact line: large in hypoid gears

[lubricant]
oil = <oil>                            # shipped name, card.toml, "pao 97.5/13.3" or "mineral vg 220"
temperature_oil = <temperature>        # at the inlet

[solid_1]
material = "steel"
# temperature_bulk = "95 degC"         # of the body; that of the oil where left out

[solid_2]
material = "steel"

[surface]
roughness_rms_1 = <roughness>          # Rq of either surface; 0 is smooth
roughness_rms_2 = <roughness>
# finish = "ground"                    # lapped, honed, milled, superfinished: gives Rq and shape in their place
additive = "EP"                        # base, ZDDP: film and friction of touching asperities

[model]
roughness = <model>                    # deterministic: both surfaces roll through; load_sharing: a published share
accuracy = "standard"                  # fast, reference
thermal = "auto"                       # off, on
"""


def _contact(name: str, answers: Mapping[str, str], given: Mapping[str, str]) -> str:
    from ehl.contact import Contact

    text = _filled(_CONTACT, name, answers)
    Contact.from_dict(tomllib.loads(text))
    return text


_PLAN = """\
# Plan of a sweep: which contacts are solved for a friction formula. Cost: mixed-ehl sweep FILE --estimate
# Run or resume: mixed-ehl sweep FILE -o run   Then: mixed-ehl fit run -o formula.json --report fit.html
# The ranges are those of car axles with margin; `mixed-ehl plan` derives them from your own designs.

name = <name>

[sampling]
size = <size>                          # contacts, spread evenly over the ranges (Sobol)
seed = 1

[variables]                            # a range, a list of values, or one value
pressure_hertz = { low = "0.3 GPa", high = "2.0 GPa" }
radius_equivalent = { low = "5 mm", high = "60 mm", scale = "log" }
speed_entrainment = { low = "0.5 m/s", high = "15 m/s", scale = "log" }
slide_to_roll = { low = 0.01, high = 1.2, scale = "log" }
lengthwise_to_roll = { low = 0.0, high = 2.0 }   # sliding along the contact line; 0.0 for spiral bevel pairs
temperature_oil = { low = "40 degC", high = "120 degC" }
roughness_rms = { low = "0.2 um", high = "1.0 um", scale = "log" }   # composite Rq

[constraints]                          # what no gear has is left out
load_per_length = { high = "3000 N/mm" }
speed_sliding = { high = "20 m/s" }
film_ratio = { low = 0.02, high = 20.0 }
temperature_flash = { high = "450 degC" }

[lubricant]
oil = <oil>                            # shipped name, card.toml, "pao 97.5/13.3" or "mineral vg 220"

[model]
roughness = <model>                    # load_sharing: milliseconds a contact, less physics
accuracy = "fast"                      # standard, reference
"""


def _plan(name: str, answers: Mapping[str, str], given: Mapping[str, str]) -> str:
    from regression.plan.plan import Plan

    text = _filled(_PLAN, name, answers)
    Plan.from_dict(tomllib.loads(text))
    return text


_OPERATING_POINT = """\
[operation]
torque = <torque>                      # of the pinion
speed = <speed>
temperature = <temperature>
oil = <oil>                            # shipped name, card.toml, "pao 97.5/13.3" or "mineral vg 220"
"""

_DESIGN = """\
# Gear pair: blank, machine settings, assembly, operating point. Answer: mixed-ehl gear FILE --friction 75w90
# The flanks are those of <like>. For a blank of your own: mixed-ehl new targets, then mixed-ehl settings.
#
# [operation]      what it runs at                     [assembly]         shaft angle, offset, misalignment
# [pinion], [gear] finish ("ground", "lapped", ...)    [pinion.blank]     cones, depths, teeth
# [pinion.cutter], [pinion.machine] and the same by flank: settings from which the flanks are cut
#
# Of the design it was taken from:
"""


def _design(name: str, answers: Mapping[str, str], given: Mapping[str, str]) -> str:
    from efficiency.design.design import Design
    from ehl.common.validation import validate

    like, names = answers["like"], data_names("designs")
    if like not in names:
        raise InputError("like", like, "one of " + ", ".join(names), near(like, names))
    text = data_path("designs", f"{like}.toml").read_text(encoding="utf-8")
    kept = tomllib.loads(text)["operation"]
    operation = {
        word: given.get(word, str(kept[_OPERATION[word].key or word])) for word in _OPERATION
    }  # what is not asked for stays as in the design
    text = re.sub(r"^name = .*$", lambda _: "name = <name>", text, count=1, flags=re.M)
    text = re.sub(r"^\[operation\]\n(?:(?!\[).*\n)*", lambda _: _OPERATING_POINT + "\n", text, count=1, flags=re.M)
    text = _filled(_DESIGN.replace("<like>", like) + text, name, operation)
    validate(Design, tomllib.loads(text))
    return text


_TARGETS = """\
# A gear pair from its blank: machine settings are found from blank, way of cutting and the contact wanted.
# Look at the blank's consequences and write the design: mixed-ehl settings FILE -o design.toml
# Then: mixed-ehl gear design.toml --friction 75w90

name = <name>
source = "made by mixed-ehl new targets"

[blank]                                # ISO 23509; or blank = "FILE" of a blank that `mixed-ehl blank FILE` shows
name = <name>
<method>
process = <process>
teeth_pinion = <teeth_pinion>
teeth_gear = <teeth_gear>
shaft_angle = "90 deg"
hand_pinion = "left"
outer_pitch_diameter_gear = <diameter>
face_width_gear = <face_width>         # usually up to 0.3 of the cone distance
mean_spiral_angle_gear = <spiral_angle>
cutter_radius = <cutter_radius>
<hob>
[blank.pressure_angle]
drive = <pressure_angle>
coast = <pressure_angle>

[blank.depth]
data_type = "II"                       # depth and thickness factors: as the standard recommends where left out

[blank.taper]
type = <taper>                         # of the tooth depth along the face

[blank.backlash]
type = "outer_transverse"
value = "0.2 mm"

[cutting]
gear = <gear_cutting>                  # generated, or formate: not generated
pinion = <pinion_cutting>              # each_flank: a setting per flank; both_flanks: one for both

[targets.drive]                        # how far the flanks fall away from conjugate ones; concave pinion flank
crowning_toe = <crowning>              # at the ends of the face
crowning_heel = <crowning>
relief_root = <relief>                 # at root and tip of the gear's working depth
relief_tip = <relief>

[targets.coast]                        # convex pinion flank
crowning_toe = <crowning>
crowning_heel = <crowning>
relief_root = <relief>
relief_tip = <relief>

[pinion]
material = "steel"
finish = <finish>                      # or roughness_rms = "0.4 um"

[gear]
material = "steel"
finish = <finish>

"""


def _targets(name: str, answers: Mapping[str, str], given: Mapping[str, str]) -> str:
    from efficiency.blanks.inputs import PairBlankInput
    from efficiency.machine_settings.inputs import SettingsInput
    from ehl.common.units import parse_quantity
    from ehl.common.validation import validate, value_range_of

    hobbed = answers["process"] == "face_hobbing"
    if not hobbed and "blade_groups" in given:
        raise InputError("blade_groups", given["blade_groups"], "no value: a face mill has no blade groups")
    offset = value_range_of(PairBlankInput, "hypoid_offset").check(answers["offset"], "offset", bare=False)
    width = parse_quantity(answers["face_width"], "m", field="face_width")
    values = {**answers} | {
        "taper": "uniform" if hobbed else "tilted_root",
        "gear_cutting": "formate" if hobbed else "generated",
        "pinion_cutting": "both_flanks" if hobbed else "each_flank",
        # ours: 40 um for a face of 26 to 30 mm, in proportion, a third of it over the depth
        "crowning": f"{min(max(40.0 * width / 0.028, 5.0), 200.0):.0f} um",
        "relief": f"{min(max(12.0 * width / 0.028, 2.0), 60.0):.0f} um",
    }
    method = f"method = 2\nhypoid_offset = {_value(answers['offset'])}" if offset > 0.0 else "method = 0"
    hob = "blade_groups = <blade_groups>         # of the face-hobbing head\n" if hobbed else ""
    text = (_TARGETS + _OPERATING_POINT).replace("<method>", method).replace("<hob>\n", hob + "\n")
    text = _filled(text, name, values)
    validate(SettingsInput, tomllib.loads(text))
    return text


# share of the time, of the torque and of the speed; ours, to be replaced by what was measured
_CYCLE = (
    (0.30, 0.10, 0.35), (0.25, 0.20, 0.50), (0.20, 0.30, 0.65), (0.10, 0.45, 0.50),
    (0.05, 0.70, 0.35), (0.02, 1.00, 0.20), (0.08, -0.10, 0.60),
)  # fmt: skip


def _duty(name: str, answers: Mapping[str, str], given: Mapping[str, str]) -> str:
    from efficiency.conditions.duty import COLUMNS

    ranges = {word: limits for word, limits in COLUMNS.items() if limits is not None}
    hours = answers["hours"] if not re.fullmatch(r"[\d.]+", answers["hours"]) else f"{answers['hours']} h"
    answered = {**answers, "hours": hours}
    torque, speed, temperature, duration = (
        ranges[word].check(answered[word], word, bare=False) for word in ("torque", "speed", "temperature", "hours")
    )
    for word, value in (("torque", torque), ("speed", speed), ("hours", duration)):
        if value <= 0.0:
            raise InputError(word, answers[word], "above 0", "Coast is in the last row, with a torque below zero.")
    lines = ["torque [N m],speed [rpm],temperature [degC],hours [h],# note"]
    for share, of_torque, of_speed in _CYCLE:
        note = "coast flanks: torque below zero" if of_torque < 0.0 else f"{100 * of_torque:.0f} % of the torque"
        numbers = (of_torque * torque, of_speed * speed * 30.0 / 3.141592653589793, temperature - 273.15)
        lines.append(",".join(f"{number:.6g}" for number in (*numbers, share * duration)) + f",{note}")
    return "\n".join(lines) + "\n"


_TEXTS = {
    "oil": _oil,
    "contact": _contact,
    "plan": _plan,
    "design": _design,
    "targets": _targets,
    "duty": _duty,
}
