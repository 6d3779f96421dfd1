"""Validation of input files against models, with errors that name field, value, allowed range and remedy.

Kinds of input files, recognised by their keys, so that errors can name the kind of a wrong file.
"""

import re
import tomllib
import types
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import accumulate
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar, Union, get_args, get_origin

from pydantic import AfterValidator, AliasChoices, BaseModel, ConfigDict, Field, Tag, ValidationError, model_validator
from pydantic.fields import FieldInfo

from ehl.common.data import data_names, data_path
from ehl.common.errors import InputError, near, remedy, same_name
from ehl.common.files import parse_toml, read_text
from ehl.common.units import ValueRange


@dataclass(frozen=True)
class Kind:
    """A kind of input file."""

    words: str  # name with article
    signs: tuple[tuple[str, ...], ...]  # tuples of keys of the first level; all keys of one tuple identify the kind
    use: str  # what reads it


# the first kind with matching keys is used
KINDS = {
    "contact": Kind("a contact file", (("contact",),), "mixed-ehl solve FILE"),
    "oil": Kind(
        "an oil card",
        (("viscosity_kinematic_40",), ("viscosity_kinematic_100",)),
        'mixed-ehl oil FILE, and oil = "FILE" in other files',
    ),
    "plan": Kind("a plan", (("variables",), ("sampling",)), "mixed-ehl sweep FILE"),
    "setup": Kind("the setup of a calibration", (("conditions",), ("specimens",)), "mixed-ehl calibrate --setup FILE"),
    "blank": Kind(
        "a blank",
        (("teeth_pinion",), ("face_width_gear",)),
        'mixed-ehl blank FILE, and blank = "FILE" in targets',
    ),
    "targets": Kind("a targets file", (("targets",), ("cutting",), ("blank", "operation")), "mixed-ehl settings FILE"),
    "axle": Kind("an axle", (("pinion_shaft",), ("gear_shaft",)), "mixed-ehl axle FILE"),
    "design": Kind("a design", (("assembly",), ("pinion", "gear")), "mixed-ehl gear FILE"),
    "finish": Kind("a finish", (("new", "name"), ("run_in", "name")), 'finish = "FILE" in other files'),
}  # fmt: skip
_NEW = ("oil", "contact", "plan", "design", "targets")


def kind_of(content: Mapping[str, Any]) -> str:
    """Kind of the content of a file (a key of `KINDS`); empty if its keys are ambiguous."""
    for name, kind in KINDS.items():
        if any(all(key in content for key in keys) for keys in kind.signs):
            return name
    return ""


def looks_like(text: str) -> str:
    """Sentence with the format of a text that is not TOML; empty if the format is unknown."""
    start = text.lstrip()[:1]
    lines = [line for line in text.splitlines() if line.strip()][:3]
    if start in ("{",):
        return "It is JSON, such as a formula, for mixed-ehl mu, export and gear --friction."
    if start == "<":
        return "It is HTML or XML, such as a report."
    if lines and all("," in line and "=" not in line for line in lines):
        return (
            "It is a table (CSV), such as a duty cycle for mixed-ehl duty, or merged results, which a fit reads as .h5."
        )
    return ""


def kind_sentence(text: str) -> str:
    """Sentence with the kind of a text file; empty if the kind is unknown."""
    try:
        kind = KINDS.get(kind_of(tomllib.loads(text)))
    except tomllib.TOMLDecodeError:
        return looks_like(text)
    return f"It is {kind.words}, for {kind.use}." if kind else ""


def _write(kind: str) -> str:
    return f"`mixed-ehl new {kind}` writes a valid one." if kind in _NEW else ""


def _name(text: str) -> str:
    if not text.isprintable():
        raise InputError("", text, "one line without control characters")
    return text


# used in titles, file names, comments of exported code and columns of tables
Name = Annotated[str, Field(min_length=1, max_length=100), AfterValidator(_name)]


def in_any_case(folder: str) -> AfterValidator:
    """Validator of a field with the name of a shipped file of one data folder or another value."""
    return AfterValidator(lambda name: same_name(name, data_names(folder)) if isinstance(name, str) else name)


class InputModel(BaseModel):
    """Base of all input models: frozen, finite numbers, no unknown keys, words in any case."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True, defer_build=True, allow_inf_nan=False)
    # words for quantities that have no key, without "_1", "_2" or "1", "2" at the end, and what to give instead
    instead: ClassVar[Mapping[str, str]] = {}

    @model_validator(mode="wrap")
    @classmethod
    def _in_any_case(cls, values: Any, handler: Callable[[Any], Self]) -> Self:
        try:
            found = handler(values)
        except ValidationError as error:
            corrected = _with_exact_words(values, error)
            if corrected is values:
                raise
            found = handler(corrected)
        # pydantic reads true as the number 1
        for name, value in values.items() if isinstance(values, dict) else ():
            if not isinstance(value, (float, str)) and _boolean_as_number(value, getattr(found, name, None)):
                raise InputError(name, value, locate_field(cls, (name,)).expected or "a number")
        return found


def _boolean_as_number(given: Any, read: Any) -> bool:
    """Whether ``true`` or ``false``, also inside a list or table, was read as a number."""
    if isinstance(given, dict):
        return isinstance(read, dict) and any(_boolean_as_number(value, read.get(key)) for key, value in given.items())
    if isinstance(given, (list, tuple)):
        return isinstance(read, (list, tuple)) and any(map(_boolean_as_number, given, read))
    return isinstance(given, bool) and isinstance(read, (int, float)) and not isinstance(read, bool)


Model = TypeVar("Model", bound=BaseModel)
_QUOTED = re.compile("'([^']*)'")  # the allowed words in an error of pydantic


def _with_exact_words(values: Any, error: ValidationError) -> Any:
    """The values with words in their exact case, also those that select the member of a union, where they were not."""
    for complaint in error.errors(include_url=False) if isinstance(values, dict) else ():
        name, context = complaint["loc"][0] if complaint["loc"] else "", complaint.get("ctx", {})
        value = corrected = values.get(name)
        if complaint["type"] == "literal_error" and isinstance(value, str):
            corrected = same_name(value, _QUOTED.findall(context["expected"]))
        elif complaint["type"] == "union_tag_invalid" and isinstance(value, dict):
            key = context["discriminator"].strip("'")
            if isinstance(tag := value.get(key), str):
                corrected = value | {key: same_name(tag, _QUOTED.findall(context["expected_tags"]))}
        if corrected != value:
            values = {**values, name: corrected}
    return values


def read_toml(path: str | Path, kind: str = "") -> dict[str, Any]:
    """Read a TOML file.

    kind: expected key of `ehl.common.validation.KINDS`; empty for any kind.
    Raises `InputError`: the file does not exist, cannot be read, is not TOML, or is of another kind.
    """
    text = read_text(path, "file", "an existing TOML file")
    try:
        content = parse_toml(text, "file", str(path))
    except InputError as error:
        if not (hint := looks_like(text)):
            raise
        allowed = KINDS[kind].words + " (TOML)" if kind else error.allowed
        raise InputError("file", str(path), allowed, f"{hint} {_write(kind)}".strip()) from None
    found = KINDS.get(kind_of(content))
    if kind and found not in (None, KINDS[kind]):
        hint = f"It is {found.words}, for {found.use}. {_write(kind)}"
        raise InputError("file", str(path), KINDS[kind].words, hint)
    return content


@cache
def _load_shipped(model: Any, folder: str, name: str, field: str, also: str) -> Any:
    names = data_names(folder)
    name = same_name(name, names)
    if name not in names:
        raise InputError(field, name, "one of " + ", ".join(names) + also, near(name, names))
    return validate(model, read_toml(data_path(folder, f"{name}.toml")), f"{folder}/{name}.toml")


def load_shipped(model: type[Model], folder: str, name: str, field: str, also: str = "") -> Model:
    """The model of a shipped file, by its name in any case; `InputError` for `field` if there is none.

    also: what is allowed besides the names of the shipped files, for the error.
    """
    found: Model = _load_shipped(model, folder, name, field, also)
    return found


def validate(model: type[Model], content: dict[str, Any], where: str = "") -> Model:
    """Build a pydantic model; all validation errors are combined into one `InputError`.

    content: content of the file.
    where: prefix of the field names (file name or table).
    """
    try:
        return model.model_validate(content)
    except ValidationError as error:
        raise input_error(error, model, where) from None


def input_error(error: ValidationError, model: type[BaseModel], where: str = "") -> InputError:
    """The `InputError` for the errors of pydantic, one per place."""
    found: list[InputError] = []
    stated, above = set[str](), set[str]()  # places of the problems, and these with all tables around them
    for complaint in error.errors(include_url=False):
        problem = _problem(complaint, model, where)
        # every member of a union reports errors, for the place itself and for its content
        places = (".".join(filter(None, (where, *locate_field(model, complaint["loc"]).path))), problem.field)
        if not any(place in above or not stated.isdisjoint(_around(place)) for place in places):
            found.append(problem)
            stated.add(places[0])
            above.update(_around(places[0]))
    meant = {_meant(problem) for problem in found}
    return InputError.of(
        [problem for problem in found if problem.value is not None or problem.field not in meant] or found
    )


def _around(place: str) -> Iterator[str]:
    """A place and all tables around it."""
    return accumulate(place.split("."), "{}.{}".format)


def _meant(problem: InputError) -> str:
    """The correct spelling of a misspelt key, which is not reported as missing."""
    _, suggested, rest = problem.hint.partition("Did you mean '")
    parent, _, _ = problem.field.rpartition(".")
    return ".".join(filter(None, (parent, rest.partition("'")[0]))) if suggested else ""


def _problem(complaint: Any, model: type[BaseModel], where: str) -> InputError:
    place = locate_field(model, complaint["loc"])
    parts = ([where] if where else []) + list(place.path)
    field = ".".join(parts) or model.__name__
    kind = complaint["type"]
    value = None if kind == "missing" else complaint["input"]
    if isinstance(value, dict):
        value = "table with " + ", ".join(sorted(map(str, value))[:8])
    context = complaint.get("ctx") or {}
    if kind.startswith("quantity"):
        return InputError(field, value, str(context["allowed"]), str(context["hint"]))
    if kind == "value_error" and isinstance(context.get("error"), InputError):
        stated: InputError = context["error"]

        def placed(inner: InputError) -> InputError:
            return InputError(".".join(filter(None, [*parts, inner.field])), inner.value, inner.allowed, inner.hint)

        return stated.changed(placed)
    if kind == "extra_forbidden":
        known = sorted(info.alias or name for name, info in place.owner.model_fields.items())
        hint = remedy(place.path[-1], getattr(place.owner, "instead", {})) or near(place.path[-1], known)
        hint = f"{hint} Known keys: {', '.join(known)}.".strip()
        return InputError(field, value, "only the documented keys of this table", hint)
    if kind.startswith("union_tag"):
        key = str(context["discriminator"]).strip("'")
        return InputError(".".join([*parts, key]), context.get("tag"), _tags(place.annotation, key))
    choices = get_args(place.annotation) if get_origin(place.annotation) is Literal else ()
    hint = "" if value is None else near(value, map(str, choices))
    return InputError(field, value, place.expected or complaint["msg"], hint)


def _tags(annotation: Any, key: str) -> str:
    """Values of the key that selects the member of a union."""
    members = (part for part in get_args(annotation) if isinstance(part, type) and issubclass(part, BaseModel))
    return "one of " + ", ".join(
        repr(tag) for member in members for tag in get_args(member.model_fields[key].annotation)
    )


@dataclass(frozen=True)
class FieldLocation:
    """A place in the tree of input models."""

    path: tuple[str, ...]  # keys as the user wrote them
    owner: type[BaseModel]  # the innermost model that contains the place
    annotation: Any  # type of what belongs there; None where nothing does
    metadata: tuple[Any, ...] = ()  # its units and bounds

    @property
    def expected(self) -> str:
        """Allowed values as text; empty if unknown."""
        for part in self.metadata:
            if isinstance(part, ValueRange):
                return part.expected()
        kind, table = self.annotation, f"a table [{'.'.join(self.path)}]"
        if _is_model(kind):
            needed = [info.alias or name for name, info in kind.model_fields.items() if info.is_required()]
            return table + (f" with {', '.join(needed)}" if needed else "")
        if get_origin(kind) is Literal:
            return "one of " + ", ".join(map(repr, get_args(kind)))
        if _is_union(kind):
            parts = (FieldLocation(self.path, self.owner, *_bare(member, ())).expected for member in get_args(kind))
            return " or ".join(dict.fromkeys(filter(None, parts)))
        words = {int: "a whole number", str: "a text in quotes", bool: "true or false", float: "a number"}
        if kind in words:
            return words[kind] + _bounds(self.metadata)
        if kind is dict or get_origin(kind) is dict:
            return table
        if get_origin(kind) in (list, tuple):
            items = get_args(kind)
            fixed = get_origin(kind) is tuple and ... not in items
            return f"a list of {len(items)} entries" if fixed else "a list"
        return ""


def locate_field(model: type[BaseModel], loc: Sequence[int | str]) -> FieldLocation:
    """The place of `loc` of pydantic, without its entries for members of unions."""
    owner, annotation, metadata = model, model, ()  # type: type[BaseModel], Any, tuple[Any, ...]
    path: list[str] = []
    for part in map(str, loc):
        annotation, metadata = _bare(annotation, metadata)
        if _is_model(annotation):
            owner = annotation
            info = _field(owner, part)
            path.append(part)
            annotation, metadata = (None, ()) if info is None else (info.annotation, tuple(info.metadata))
        elif _is_union(annotation):
            # the user never wrote the name of the member
            annotation, metadata = _member(annotation, part), ()
        else:
            path.append(part)
            annotation, metadata = _item(annotation, part), ()
    annotation, metadata = _bare(annotation, metadata)
    return FieldLocation(tuple(path), annotation if _is_model(annotation) else owner, annotation, metadata)


def value_range_of(model: type[BaseModel], name: str) -> ValueRange:
    """Unit and range of a field of a model."""
    return next(part for part in locate_field(model, (name,)).metadata if isinstance(part, ValueRange))


def _bounds(metadata: tuple[Any, ...]) -> str:
    words = {"gt": "above", "ge": "of at least", "lt": "below", "le": "of at most"}
    found = [
        f"{word} {getattr(part, name)}" for part in metadata for name, word in words.items() if hasattr(part, name)
    ]
    return " " + " and ".join(found) if found else ""


def _bare(annotation: Any, metadata: tuple[Any, ...]) -> tuple[Any, tuple[Any, ...]]:
    """The type inside ``Annotated[...]`` and ``... | None``, and its annotations."""
    while True:
        if get_origin(annotation) is Annotated:
            notes = (n.metadata if isinstance(n, FieldInfo) else [n] for n in annotation.__metadata__)
            metadata = (*metadata, *(note for part in notes for note in part))
            annotation = get_args(annotation)[0]
            continue
        members = [part for part in get_args(annotation) if part is not types.NoneType]
        if not (_is_union(annotation) and len(members) == 1):
            return annotation, metadata
        annotation = members[0]


def _is_model(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def _is_union(annotation: Any) -> bool:
    return get_origin(annotation) in (Union, types.UnionType)


def _field(model: type[BaseModel], key: str) -> FieldInfo | None:
    for name, info in model.model_fields.items():
        alias = info.validation_alias
        others = alias.choices if isinstance(alias, AliasChoices) else [alias]
        if key == name or key in others:
            return info
    return None


def _member(union: Any, label: str) -> Any:
    """The member of a union with a tag or name of pydantic."""
    for member in get_args(union):
        bare, notes = _bare(member, ())
        if label in (getattr(bare, "__name__", ""), *(note.tag for note in notes if isinstance(note, Tag))):
            return member
        kinds = [info.annotation for info in bare.model_fields.values()] if _is_model(bare) else []
        if any(get_origin(kind) is Literal and label in get_args(kind) for kind in kinds):
            return member
    return None


def _item(annotation: Any, key: str) -> Any:
    """Type of the entries of a list or of a table with arbitrary keys."""
    arguments = get_args(annotation)
    if not arguments:
        return None
    if get_origin(annotation) is dict:
        return arguments[1]
    if get_origin(annotation) is tuple and ... not in arguments:
        return arguments[int(key)] if key.isdecimal() and int(key) < len(arguments) else None
    return arguments[0]
