"""Templates of input files: complete commented texts, adapted by a few answers.

The texts are in ``data/templates``. Lines ``#? word = default | text`` of a template are its questions; ``#? word ->
key = ...`` names the key of an answer that the template does not contain literally. ``<word>`` in the text is replaced
by the answer; a line with an empty answer is omitted.
"""

import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from ehl.common.data import data_names, data_path
from ehl.common.errors import InputError, check_choice, near
from ehl.common.units import KELVIN, ValueRange

_QUESTION = re.compile(r"#\? (\w+)(?: -> (\w+))? = (.*?) *\| (.*)")


@dataclass(frozen=True)
class _Template:
    """Questions with their default answers, the key of the file for each word, and the text."""

    questions: dict[str, tuple[str, str]]
    keys: dict[str, str]
    text: str


@cache
def _template(kind: str) -> _Template:
    check_choice("kind", kind, data_names("templates", ".txt"))
    head, _, text = data_path("templates", f"{kind}.txt").read_text(encoding="utf-8").partition("\n\n")
    questions = [match for match in map(_QUESTION.fullmatch, head.splitlines()) if match]
    first = {word: key for key, word in reversed(re.findall(r"^(\w+) = <(\w+)>", text, flags=re.M))}
    return _Template(
        {question[1]: (question[4], question[3]) for question in questions},
        {question[1]: str(question[2] or first.get(question[1], question[1])) for question in questions},
        text,
    )


def new_questions(kind: str) -> dict[str, tuple[str, str]]:
    """Keywords of `new_file` for a kind of file.

    Parameters
    ----------
    kind : {"oil", "contact", "plan", "design", "targets", "axle", "duty"}
        Kind of file.

    Returns
    -------
    dict of str to (str, str)
        Explanation and default answer of each keyword.

    Raises
    ------
    InputError
        An unknown kind.

    Examples
    --------
    >>> import efficiency
    >>> efficiency.new_questions("contact")["pressure"]
    ('Hertz pressure.', '1.2 GPa')
    """
    return dict(_template(kind).questions)


def new_file(kind: str, name: str = "", **answers: float | str) -> str:
    """Text of a complete commented input file.

    Parameters
    ----------
    kind : {"oil", "contact", "plan", "design", "targets", "axle", "duty"}
        Kind of file: TOML, for "duty" CSV.
    name : str
        Name of the oil, plan, design, targets or axle; default: ``my_`` and the kind.
    **answers : float or str
        Keywords of `new_questions`; texts have a unit.

    Returns
    -------
    str

    Raises
    ------
    InputError
        An unknown keyword or an invalid value.

    Examples
    --------
    >>> import tomllib
    >>> import efficiency
    >>> import ehl
    >>> text = efficiency.new_file("contact", oil="fva3", pressure="1 GPa")
    >>> ehl.Contact(**tomllib.loads(text)).contact.pressure_hertz
    1000000000.0
    """
    template = _template(kind)
    known = template.questions
    for word, answer in answers.items():
        if word not in known:
            raise InputError(word, answer, "one of " + ", ".join(known), near(word, known))
    given = {word: str(answer) for word, answer in answers.items() if str(answer)}
    chosen = {word: default for word, (_, default) in known.items()} | given
    try:
        return _WRITERS[kind](template.text, name or f"my_{kind}", chosen, given)
    except InputError as error:
        words = {key: word for word, key in template.keys.items()}

        def of_answer(problem: InputError) -> InputError:
            """The problem of the file, related to the answer that caused it."""
            field = problem.field.rpartition(".")[2]
            return InputError(words.get(field, field), problem.value, problem.allowed, problem.hint)

        raise error.changed(of_answer) from None


def _value(text: str) -> str:
    """A number, or any other value as a TOML string."""
    if re.fullmatch(r"[+-]?\d+(\.\d+)?([eE][+-]?\d+)?", text):
        return text if not re.fullmatch(r"[+-]?0\d+.*", text) else str(float(text))
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _filled(text: str, name: str, answers: Mapping[str, str]) -> str:
    """A template with its ``<answer>`` replaced; each answer must be one printable line."""
    for word, answer in {"name": name, **answers}.items():
        if not answer.isprintable() or len(answer) > 200:
            raise InputError(word, answer, "one line of at most 200 characters without control characters")
        if not answer:
            text = re.sub(rf"^.*<{word}>.*\n", "", text, flags=re.M)
        text = text.replace(f"<{word}>", _value(answer) if word != "name" else '"' + _value(answer).strip('"') + '"')
    return text


def _oil(text: str, name: str, answers: Mapping[str, str], given: Mapping[str, str]) -> str:
    from ehl.fluid.oil import Oil
    from ehl.fluid.oil_sheet import card_text

    grade: dict[str, Any] = {f"nu_{at}": given[f"nu{at}"] for at in (40, 100) if f"nu{at}" in given}
    if "vg" in given or not grade:
        grade["iso_vg"] = ValueRange("").check(answers["vg"], "vg")
    card = Oil.generic(answers["base"], **grade, density_15=answers["density"] or None, name=name)
    head = text.replace("FILE", f"{name}.toml").replace("<name>", name).removeprefix("# ").rstrip()
    made = card_text(card, head)
    for key, value in (("40", card.viscosity_kinematic_40), ("100", card.viscosity_kinematic_100)):
        # in the unit of a data sheet
        made = made.replace(
            f"viscosity_kinematic_{key} = {value!r}", f'viscosity_kinematic_{key} = "{value * 1e6:.6g} cSt"'
        )
    return made


def _contact(text: str, name: str, answers: Mapping[str, str], given: Mapping[str, str]) -> str:
    from ehl.contact import Contact

    own = "finish" in given and "roughness" not in given  # the finish has its own Rq
    text = _filled(text, name, {**answers, "roughness": ""} if own else answers)
    Contact(**tomllib.loads(text))
    return text


def _plan(text: str, name: str, answers: Mapping[str, str], given: Mapping[str, str]) -> str:
    from regression.plan.plan import Plan

    Plan.from_dict(tomllib.loads(text := _filled(text, name, answers)))
    return text


def _design(text: str, name: str, answers: Mapping[str, str], given: Mapping[str, str]) -> str:
    from efficiency.design.design import Design
    from efficiency.pairs import cylindrical_design, is_cylindrical
    from ehl.common.validation import validate

    like = answers["like"]
    head, begin, operation = text.replace("<like>", like).partition("[operation]\n")
    shipped = _shipped("designs", like)
    cylindrical = is_cylindrical(tomllib.loads(shipped))
    if cylindrical:
        head = data_path("templates", "cylindrical.head").read_text(encoding="utf-8").replace("<like>", like)
    # keys without an answer keep the value of the design
    kept = {word: str(value) for word, value in tomllib.loads(shipped)["operation"].items()}
    made = re.sub(r"^name = .*$", lambda _: "name = <name>", shipped, count=1, flags=re.M)
    block = f"{begin}{operation}\n"
    made = re.sub(r"^\[operation\]\n(?:(?!\[).*\n)*", lambda _: block, made, count=1, flags=re.M)
    made = _filled(head + made, name, kept | {word: given[word] for word in kept if word in given})
    content = tomllib.loads(made)
    cylindrical_design(content, name) if cylindrical else validate(Design, content)
    return made


def _shipped(folder: str, like: str) -> str:
    """Text of a shipped file."""
    check_choice("like", like, data_names(folder))
    return data_path(folder, f"{like}.toml").read_text(encoding="utf-8")


def _axle(text: str, name: str, answers: Mapping[str, str], given: Mapping[str, str]) -> str:
    from efficiency.axle.axle_input import AxleInput
    from efficiency.design.design import Design
    from efficiency.pairs import load
    from ehl.common.validation import validate

    design = load(given["pair"]).design if "pair" in given else None
    cylindrical = design is not None and not isinstance(design, Design)
    like = given.get("like") or ("eaxle_helical" if cylindrical else answers["like"])
    made = re.sub(r"\A(?:#.*\n|\n)*name = .*$", "name = <name>", _shipped("axles", like), count=1, flags=re.M)
    made = re.sub(r"^source = .*$", f'source = "bearings, sump and housing of {like}"', made, count=1, flags=re.M)
    if design is not None:
        own = load(tomllib.loads(_shipped("axles", like))["pair"]).design
        if cylindrical == isinstance(own, Design):  # bearings of bevel gears are placed from the crossing of the axes
            raise InputError("like", like, f"an axle with a {'cylindrical' if cylindrical else 'bevel or hypoid'} pair")
        made = re.sub(r"^pair = .*$", "pair = <pair>", made, count=1, flags=re.M)
        made = re.sub(r"\n^\[operation\].*\n(?:(?!\[).*\n)*", "", made, count=1, flags=re.M)  # that of the pair instead
        if isinstance(design, Design):
            height = f'height = "{1e3 * (0.0 - design.assembly.hypoid_offset):.6g} mm"'
            made = re.sub(r'^height = ".*"', height, made, count=1, flags=re.M)
    made = _filled(text.replace("<like>", like) + made, name, given)
    validate(AxleInput, tomllib.loads(made))
    return made


def _targets(text: str, name: str, answers: Mapping[str, str], given: Mapping[str, str]) -> str:
    from efficiency.blanks.inputs import PairBlankInput
    from efficiency.cutting.process import PROCESSES, FaceMilling
    from efficiency.machine_settings.inputs import SettingsInput
    from efficiency.optimisation.load_sizing import ENDS, TIP
    from ehl.common.units import parse_quantity
    from ehl.common.validation import validate, value_range_of

    process = PROCESSES.get(answers["process"], FaceMilling())
    offset = value_range_of(PairBlankInput, "hypoid_offset").check(answers["offset"], "offset", bare=False)
    width, diameter = (parse_quantity(answers[n], "m", field=n) for n in ("face_width", "diameter"))
    spiral = parse_quantity(answers["spiral_angle"], "rad", field="spiral_angle")
    # mean normal module of a gear whose mean diameter is 0.85 of the outer one
    module = 0.85 * diameter * math.cos(spiral) / float(answers["teeth_gear"])
    values = {**answers, **process.usual, **given} | {
        "method": "2" if offset else "0",
        # own choice: 40 um for a face width of 26 to 30 mm, in proportion to it; profile crowning is a third of it
        "crowning": f"{min(max(40.0 * width / 0.028, 5.0), 200.0):.0f} um",
        "relief": f"{min(max(12.0 * width / 0.028, 2.0), 60.0):.0f} um",
        "tip_amount": f"{1e6 * TIP[0] * module:.0f} um",
        "tip_length": f"{1e3 * TIP[1] * module:.2g} mm",
        "end_amount": f"{1e6 * ENDS[0] * module:.0f} um",
        "end_length": f"{1e3 * ENDS[1] * width:.2g} mm",
    }
    text = _filled(text, name, values)
    validate(SettingsInput, tomllib.loads(text))
    return text


def _duty(text: str, name: str, answers: Mapping[str, str], given: Mapping[str, str]) -> str:
    from efficiency.conditions.duty import COLUMNS

    ranges = {word: limits for word, limits in COLUMNS.items() if limits is not None}
    hours = answers["hours"] if not re.fullmatch(r"[\d.]+", answers["hours"]) else f"{answers['hours']} h"
    answered = {**answers, "hours": hours}
    torque, speed, temperature, duration = (
        ranges[word].check(answered[word], word, bare=False) for word in ("torque", "speed", "temperature", "hours")
    )
    for word, value in (("torque", torque), ("speed", speed), ("hours", duration)):
        if value <= 0.0:
            raise InputError(word, answers[word], "above 0", "The last row of the file is coast with negative torque.")
    columns, *fractions = text.splitlines()
    lines = [columns]
    for of_torque, of_speed, share in (map(float, row.split(",")) for row in fractions):
        note = "coast flanks: negative torque" if of_torque < 0.0 else f"{100 * of_torque:.0f} % of the torque"
        numbers = (of_torque * torque, of_speed * speed * 30.0 / 3.141592653589793, temperature - KELVIN)
        lines.append(",".join(f"{number:.6g}" for number in (*numbers, share * duration)) + f",{note}")
    return "\n".join(lines) + "\n"


_WRITERS = {
    "oil": _oil,
    "contact": _contact,
    "plan": _plan,
    "design": _design,
    "targets": _targets,
    "axle": _axle,
    "duty": _duty,
}
