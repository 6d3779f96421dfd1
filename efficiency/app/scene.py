"""Content of the page: the settings of the user as texts, and their result.

The mesh is kept while the alignment stays, the load while the torque stays: oil, finish, speed and temperature need
the friction formula alone.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, cast

import numpy as np

from efficiency.axle.axle import BALANCE, Axle
from efficiency.axle.result import SOURCES, AxleResult
from efficiency.conditions.conditions import checked, default_friction
from efficiency.design.design import MISALIGNMENTS, Design, bevel_names
from efficiency.loss.efficiency_result import EfficiencyResult, pair_notes
from efficiency.loss.ehl_friction import line_conditions
from efficiency.machine_settings.inputs import SettingsInput, load_targets, targets_next_to
from efficiency.machine_settings.settings_result import SettingsResult
from efficiency.machine_settings.solve import machine_settings
from efficiency.mesh import LoadedMesh
from efficiency.optimisation.problem import VARIABLES, start_value, with_values
from efficiency.output.flank_map import FlankMap
from efficiency.output.tables import result_notes
from efficiency.pair import GearPair
from ehl.common.data import data_names, data_path, named_file
from ehl.common.errors import InputError, MixedEhlError, check_choice
from ehl.common.files import toml_text
from ehl.common.notes import Note
from ehl.common.progress import ProgressCallback
from ehl.common.quantities import to_display, typeset_unit, typeset_units
from ehl.common.units import UNITS
from ehl.common.validation import read_toml
from ehl.contact import Contact
from ehl.surface.finish import State
from regression.formula import shipped_formulas
from regression.friction.published_registry import PUBLISHED, model_label


def _number(unit: str, label: str) -> Any:
    """A field of a scene with a number: its unit and label."""
    return field(default="", metadata={"unit": unit, "label": label})


@dataclass(frozen=True)
class Scene:
    """Settings of the user; an empty text denotes the value of the design."""

    design: str  # shipped design, or the file the program was started with
    side: str = "drive"
    oil: str = ""
    friction: str = ""
    finish: str = ""  # of `FINISHES`
    torque: str = _number("N m", "pinion torque")
    speed: str = _number("rpm", "pinion speed")
    temperature: str = _number("degC", "oil temperature")
    roughness_rms_pinion: str = _number("um", "Rq pinion")
    roughness_rms_gear: str = _number("um", "Rq gear")
    peklenik_number: str = _number("", "Peklenik number (empty: of the finish)")
    E: str = _number("mm", "E offset")
    P: str = _number("mm", "P pinion axial")
    G: str = _number("mm", "G gear axial")
    shaft_angle_error: str = _number("deg", "α shaft angle")
    lengthwise_crowning: str = _number("um", "lengthwise crowning")
    profile_crowning: str = _number("um", "profile crowning")
    tip_relief: str = _number("um", "tip relief")
    hypoid_offset: str = _number("mm", "hypoid offset")

    def values(self, *names: str) -> dict[str, str]:
        """Fields that are not empty, with their units; `InputError` for a value that cannot be used."""
        texts = {name: getattr(self, name).strip() for name in names}
        found = {name: f"{text} {FIELDS[name][0]}".strip() for name, text in texts.items() if text}
        for name, text in found.items():
            checked(name, text)
        return found

    @property
    def mesh_values(self) -> dict[str, str]:
        """Misalignment that differs from the design's."""
        return self.values(*MISALIGNMENTS)

    @property
    def conditions(self) -> dict[str, Any]:
        """Operating point that differs from the design's."""
        given: dict[str, Any] = self.values(
            "speed", "temperature", "roughness_rms_pinion", "roughness_rms_gear", "peklenik_number"
        )
        return given | ({"oil": self.oil} if self.oil else {})


# fields with a number, by the keyword of the Python interface: unit, label
FIELDS = {one.name: (one.metadata["unit"], one.metadata["label"]) for one in fields(Scene) if one.metadata}
SHAPE = ("lengthwise_crowning", "profile_crowning", "tip_relief", "hypoid_offset")
"""Variables of the flanks, which require new machine settings; for designs with relief in their targets."""
CHOICES = {
    "design": "pair",
    "side": "flanks",
    "finish": "finish of both flanks",
    "oil": "oil",
    "friction": "friction model",
}
# numbers of the tab of an axle: label, value at the start
AXLE_FIELDS = {
    "torque": ("pinion torque [N m]", "200"),
    "speed": ("pinion speed [rpm]", "1500"),
    "temperature": ("oil temperature [°C] or balance", "80"),
}
_STATES: dict[str, State] = {"run in": "run_in", "new": "new"}
# finish as it is chosen: name, state
FINISHES: dict[str, tuple[str, State]] = {
    f"{name}, {words}": (name, state) for name in data_names("finishes") for words, state in _STATES.items()
}
COMPARED = ("xu_kahraman_2007", "constant:0.05")
FRICTIONS = (*shipped_formulas(), *PUBLISHED, "constant:0.05")
FIRST = "fm_hypoid_13x42_relieved"  # design a page begins with
MAP_STEPS = 7  # torques and speeds of a map each
_LONGEST = 40  # characters of a field
_KEPT = 16  # pairs, axles, settings and loads, each


@dataclass(frozen=True)
class SceneAnswer:
    """Loaded mesh, result, and name of the friction model of a scene."""

    loaded: LoadedMesh
    result: EfficiencyResult
    friction: str

    @property
    def notes(self) -> list[Note]:
        """Warnings of the result, the most severe first."""
        return pair_notes(result_notes(self.result))

    @cached_property
    def flank(self) -> FlankMap:
        """Fields over the gear flank."""
        return FlankMap.of(self.loaded.mesh.bevel.flanks(), self.result)

    def tooth(self, name: str) -> tuple[list[list[float]], float]:
        """Points of the gear flank: along the pitch cone [mm], over it [mm], value; and the largest value.

        The name is ``pressure_hertz`` [GPa] or ``loss_density`` [W/mm2].
        """
        flank = self.flank
        if not flank.drawable:
            return [], 0.0
        u, h = flank.place()
        values = to_display(name, flank.local(name))
        shown = np.isfinite(values) & flank.loaded
        points = np.column_stack([1e3 * u[shown], 1e3 * h[shown], values[shown]])
        return points.round(4).tolist(), float(values[shown].max(initial=0.0))

    def outline(self) -> list[list[float]]:
        """Corners of the gear flank, closed [mm]."""
        blank = self.loaded.mesh.bevel.flanks().blank("gear")
        u = np.array([-0.5, 0.5]) * blank.face_width
        low, high = blank.root(u), blank.tip(u)
        corners = [(u[0], low[0]), (u[1], low[1]), (u[1], high[1]), (u[0], high[0]), (u[0], low[0])]
        return [[round(1e3 * float(x), 3), round(1e3 * float(y), 3)] for x, y in corners]

    def headline(self) -> str:
        """Efficiency with its interval; without a result the notes contain the reason."""
        found = self.result
        if found.status == "failed":
            return "no result"
        low, high = 100.0 * found.efficiency_lower, 100.0 * found.efficiency_upper
        interval = f" ({low:.1f} to {high:.1f})" if math.isfinite(low) and low < high else ""
        return f"{100.0 * found.efficiency:.2f} %{interval}"


class Bench:
    """Pairs, meshes and loads kept between evaluations.

    given: design file of the command line, the only file that is opened.
    """

    def __init__(self, given: Path | None = None) -> None:
        self.given, kept = given, lru_cache(maxsize=_KEPT)
        self._pair, self._axle = kept(lambda design: GearPair(self._source(design))), kept(Axle)
        self._made, self._load = kept(self._cut), kept(self._under_load)

    @property
    def designs(self) -> list[str]:
        """Names of designs a scene may have, the given file first."""
        shipped = bevel_names()
        return [self.given.name, *shipped] if self.given is not None else list(shipped)

    def _source(self, design: str) -> Path | str:
        """The file of the command line, or the name of a shipped design."""
        return self.given if self.given is not None and design == self.given.name else design

    def pair(self, design: str) -> GearPair:
        """The pair of a name: a shipped one, or the file of the command line."""
        check_choice("design", design, self.designs)
        return self._pair(design)

    def start(self, design: str | None = None) -> Scene:
        """The scene of a design as it is, every field filled."""
        name = design or (self.given.name if self.given is not None else FIRST)
        given = self.pair(name).design
        point = given.operation
        values = {key: getattr(point, key) for key in ("torque", "speed", "temperature")}
        values |= given.assembly.misalignment.model_dump()
        return Scene(
            name,
            oil=point.oil,
            friction=default_friction(point.oil),
            **self.roughness(name),
            **{key: _text(key, value) for key, value in values.items()},
            **self._start_shape(name),
        )

    def targets(self, design: str) -> SettingsInput | None:
        """Targets of a design, from which new flanks can be made; None where they are missing or have no relief."""
        source = self._source(design)
        path = targets_next_to(source) if isinstance(source, Path) else data_path("targets", f"{source}.toml")
        if not path.is_file():
            return None
        found = load_targets(path)
        return found if found.pinion.edge_relief.tip is not None else None

    def _start_shape(self, design: str) -> dict[str, str]:
        """Texts of the fields of `SHAPE` of a design; empty where its flanks cannot be changed."""
        targets = self.targets(design)
        if targets is None:
            return {}
        start = {name: start_value(targets, name, "both") for name in SHAPE if name != "hypoid_offset"}
        texts = {name: _text(name, value, 4) for name, value in start.items()}
        return texts | {"hypoid_offset": _text("hypoid_offset", targets.blank.hypoid_offset, 5)}

    def shape(self, scene: Scene) -> dict[str, float]:
        """Variables of the flanks [m] that differ from the design's."""
        start = self._start_shape(scene.design)
        given = scene.values(*(name for name in SHAPE if getattr(scene, name) != start.get(name, "")))
        if given and not start:
            raise InputError(next(iter(given)), None, "a design with targets, such as the shipped ..._relieved")
        return {name: VARIABLES[name].check(text, name) for name, text in given.items()}

    def settings(self, scene: Scene) -> SettingsResult | None:
        """Machine settings of the changed flanks; None for the flanks of the design."""
        shape = self.shape(scene)
        if not shape:
            return None
        found = self._made(scene.design, tuple(shape.items()))
        if found.status != "converged":
            raise InputError(
                next(iter(shape)), None, f"flanks that can be cut ({found.status})", "".join(found.warnings[:1])
            )
        return found

    def _cut(self, design: str, shape: tuple[tuple[str, float], ...]) -> SettingsResult:
        targets = self.targets(design)
        assert targets is not None  # a design without targets has no shape
        return machine_settings(with_values(targets, dict(shape), "both"), transmission=False)

    def roughness(self, design: str, finish: str = "") -> dict[str, str]:
        """Texts of the fields of Rq of a pair with a finish."""
        members = _finished(self.pair(design).design, finish)
        rms = {"roughness_rms_pinion": members.pinion.roughness_rms, "roughness_rms_gear": members.gear.roughness_rms}
        return {name: _text(name, value, 4) for name, value in rms.items()}

    def loaded(self, scene: Scene) -> LoadedMesh:
        """The loaded mesh of a scene; the last few are kept. A finish changes neither mesh nor load."""
        # only what the load depends on
        bare = Scene(scene.design, scene.side, torque=scene.torque)
        found = self._load(replace(bare, **{name: getattr(scene, name) for name in (*MISALIGNMENTS, *SHAPE)}))
        mesh = found.mesh
        return replace(found, mesh=replace(mesh, design=_finished(mesh.bevel, scene.finish))) if scene.finish else found

    def _under_load(self, scene: Scene) -> LoadedMesh:
        made, placed = self.settings(scene), cast("Any", {"side": scene.side, **scene.mesh_values})
        pair = self.pair(scene.design) if made is None else GearPair(made.design)
        return pair.mesh(**placed).load(scene.values("torque").get("torque"))

    def axle(self, texts: Mapping[str, str]) -> tuple[Axle, dict[str, str]]:
        """A shipped axle with the methods of the tab, and the operating point."""
        name = texts["axle"]
        check_choice("axle", name, data_names("axles"))
        point = {"torque": f"{texts['torque']} N m", "speed": f"{texts['speed']} rpm"}
        kelvin = texts["temperature"]
        point["temperature"] = kelvin if kelvin == BALANCE else f"{kelvin} degC"
        methods = {key: text for key, text in texts.items() if key not in ("axle", *AXLE_FIELDS)}
        return self._axle(name).with_methods(**methods), point

    def axle_point(self, texts: Mapping[str, str]) -> AxleResult:
        """Losses of an axle at the operating point of the tab."""
        axle, point = self.axle(texts)
        return axle.at(**point)

    def axle_speeds(self, texts: Mapping[str, str]) -> tuple[list[float], dict[str, list[float]]]:
        """Speeds to twice that of the tab [rpm], and the loss by source at them [W]."""
        axle, point = self.axle(texts)
        found = axle.at(**point).points[0]
        speeds = [abs(found.speed) * share for share in np.linspace(0.2, 2.0, 10)]
        losses = axle.map([found.torque], speeds, [found.temperature], interval=False)
        rpm = [float(f"{speed * 30.0 / math.pi:.3g}") for speed in speeds]
        return rpm, {name: losses.values(f"loss_{name}").round(2).tolist() for name in SOURCES}

    def answer(self, scene: Scene) -> SceneAnswer:
        """Efficiency and all figures of the page for one scene."""
        self.oil(scene)
        friction = self.friction(scene)
        loaded = self.loaded(scene)
        return SceneAnswer(loaded, loaded.efficiency(friction, **scene.conditions), friction)

    def problems(self, scene: Scene, error: InputError) -> dict[str, str]:
        """Problems of a scene: the field, or an empty text, and a sentence with its label.

        An invalid field is set to the value of the design and the scene is evaluated again, until there is a result.
        """
        found: dict[str, str] = {}
        try:
            start = self.start(scene.design)
        except InputError as unknown:
            return {"design": str(unknown)}
        while True:
            named = {_field(one.field): one for one in error.problems}
            fresh = {name: one for name, one in named.items() if name not in found}
            found |= {name: _sentence(scene, name, one) for name, one in fresh.items()}
            back = {name: getattr(start, name) for name in fresh if name}
            if not back:
                return found
            scene = replace(scene, **back)
            try:
                self.answer(scene)
                return found
            except InputError as other:
                error = other
            except MixedEhlError:
                return found

    def oil(self, scene: Scene) -> str:
        """Name of the oil: a shipped one, or that of the design."""
        own = self.pair(scene.design).design.operation.oil
        name = scene.oil or own
        check_choice("oil", name, (*data_names("oils"), own))
        return name

    def friction(self, scene: Scene) -> str:
        """Name of the friction model: a shipped or a published formula, or a constant, no file."""
        name = scene.friction or default_friction(self.oil(scene))
        if name.partition(":")[0] != "constant":
            check_choice("friction", name, FRICTIONS)
        return name

    def compared(self, scene: Scene) -> list[tuple[str, float, float, float]]:
        """Loss in W by friction model: label, loss, and the ends of its interval."""
        loaded = self.loaded(scene)
        oil = self.oil(scene)
        found = []
        for name in (*shipped_formulas(oil), *COMPARED):
            result = loaded.efficiency(name, **scene.conditions)
            ends = (result.power_input * (1.0 - end) for end in (result.efficiency_upper, result.efficiency_lower))
            low, high = (end if math.isfinite(end) else result.power_loss for end in ends)
            found.append(
                (model_label(name), result.power_loss, min(low, result.power_loss), max(high, result.power_loss))
            )
        return found

    def map(
        self, scene: Scene, progress: ProgressCallback | None = None
    ) -> tuple[list[float], list[float], list[list[float]]]:
        """Efficiency in % over torque [N m] and speed [rpm], from a fifth of the scene's to 1.4 times of it."""
        base = self.answer(scene)
        torque = base.loaded.torque
        turn = 30.0 / math.pi
        speed = base.result.conditions.speed * turn
        share = np.linspace(0.2, 1.4, MAP_STEPS)
        torques, speeds = [float(f"{x:.3g}") for x in torque * share], [float(f"{x:.3g}") for x in speed * share]
        axes = {"torque": torques, "speed": [f"{v} rpm" for v in speeds]}
        grid = base.loaded.mesh.over(base.friction, progress=progress, **scene.conditions | axes)
        return torques, speeds, (100.0 * grid.values()).tolist()

    def script(self, scene: Scene) -> str:
        """A Python script that gives the number of the page."""
        name, shape = str(self._source(scene.design)), self.shape(scene)
        load, pair = "", f"efficiency.load({name!r})"
        if shape:
            targets = name.removesuffix(".toml") + "_targets.toml" if self.given is not None else name
            load = (
                "from efficiency.machine_settings.inputs import load_targets\n"
                "from efficiency.optimisation.problem import with_values\n\n"
                f"targets = with_values(load_targets({targets!r}), {shape!r}, 'both')\n"
            )
            pair = "efficiency.GearPair(efficiency.settings(targets).design)"
        mesh = "".join(f", {key}={value!r}" for key, value in scene.mesh_values.items())
        torque = scene.values("torque").get("torque")
        friction = self.friction(scene)
        conditions = "".join(f", {key}={value!r}" for key, value in scene.conditions.items())
        finished = f".finished{FINISHES[scene.finish]}" if scene.finish else ""
        return (
            f"import efficiency\n{load}\n"
            f"pair = {pair}{finished}\n"
            f"mesh = pair.mesh(side={scene.side!r}{mesh})\n"
            f"result = mesh.load({torque!r}).efficiency({friction!r}{conditions})\n"
            'print(f"efficiency {100 * result.efficiency:.3f} %")\n'
        )

    def design_text(self, scene: Scene) -> str:
        """The design with the operating point, finish and alignment of the scene, as a design file.

        Names of profiles and other files in the design are not changed.
        """
        made = self.settings(scene)
        source = named_file("design", "designs", self._source(scene.design))
        content = read_toml(source) if made is None else tomllib.loads(made.text)
        operation = content.setdefault("operation", {})
        conditions, torque = scene.conditions, scene.values("torque")
        operation.update(
            {name: conditions[name] for name in ("speed", "temperature", "oil") if name in conditions} | torque
        )
        if scene.finish:
            content.pop("surface", None)
        for member in ("pinion", "gear"):
            if scene.finish:
                content[member]["finish"], content[member]["finish_state"] = FINISHES[scene.finish]
            if f"roughness_rms_{member}" in conditions:
                content[member]["roughness_rms"] = conditions[f"roughness_rms_{member}"]
        if "peklenik_number" in conditions:
            content.setdefault("surface", {})["peklenik_number"] = float(conditions["peklenik_number"])
        if scene.mesh_values:
            content.setdefault("assembly", {}).setdefault("misalignment", {}).update(scene.mesh_values)
        return toml_text(content)

    def contact(self, scene: Scene) -> Contact:
        """Film and pressure of the contact with the largest loss, solved smooth (about a second)."""
        answer = self.answer(scene)
        state, result = answer.result.points.state, answer.result
        at = int(np.argmax(result.friction.mu * state.load_per_length * result.points.speed_sliding))
        point: dict[str, Any] = {"temperature": float(state.temperature_oil[at]), **line_conditions(state, at)}
        return Contact(oil=self.oil(scene), **point)


def _finished(design: Design, finish: str) -> Design:
    """The design with a finish of `FINISHES`, or as it is."""
    if not finish:
        return design
    check_choice("finish", finish, FINISHES)
    return design.with_finish(*FINISHES[finish])


def _field(name: str) -> str:
    """Field of a scene that an error names, or nothing."""
    last = name.rpartition(".")[2]
    return last if last in {one.name for one in fields(Scene)} else ""


def _sentence(scene: Scene, name: str, error: InputError) -> str:
    """An error with the label and the unit of its field, and what was typed there."""
    if not name:
        return str(error)
    unit, label = FIELDS.get(name, ("", CHOICES.get(name, name)))
    allowed = error.allowed.partition(" (a number")[0]
    hint = "" if unit == "degC" else error.hint  # of unit-less numbers in files
    if unit and allowed.startswith("a number"):
        allowed, hint = f"a number in {typeset_unit(unit)}", ""
    typed = str(getattr(scene, name))
    shown = typed if len(typed) <= _LONGEST else typed[:_LONGEST] + "…"
    of_unit = f" [{typeset_unit(unit)}]" if unit else ""
    return f"{label}{of_unit} = {shown!r} cannot be used; allowed: {typeset_units(allowed)}. {hint}".strip()


def _text(name: str, value: float, digits: int = 6) -> str:
    """An SI value in the unit of a field."""
    _, factor, zero = UNITS.get(FIELDS[name][0], ("", 1.0, 0.0))
    return f"{(value - zero) / factor:.{digits}g}"


def changed(scene: Scene, **values: str) -> Scene:
    """A scene with other texts; unknown names and texts longer than a field are rejected."""
    for name in values:
        check_choice("field", name, (one.name for one in fields(Scene)))
    return replace(scene, **{name: str(value or "") for name, value in values.items()})
