"""The page of `mixed-ehl app`: controls, result, fields on the tooth, friction models, map, contact, exports; axle."""

import asyncio
import base64
import io
import logging
import tempfile
from collections.abc import Callable, Collection
from functools import partial
from pathlib import Path
from typing import Any, TypeVar, get_args

from nicegui import app, core, run, ui

from efficiency.app import charts
from efficiency.app.guard import Guard
from efficiency.app.scene import (
    AXLE_FIELDS,
    CHOICES,
    FIELDS,
    FINISHES,
    FRICTIONS,
    SHAPE,
    Bench,
    Scene,
    SceneAnswer,
    changed,
)
from efficiency.axle.axle_input import MethodsInput
from efficiency.axle.result import OUTSIDE, AxleResult
from efficiency.design.design import MISALIGNMENTS
from ehl.common.data import data_names, reason_text
from ehl.common.errors import InputError, MixedEhlError
from ehl.common.progress import Progress
from ehl.common.quantities import rounded, typeset_unit
from ehl.common.units import KELVIN
from regression.friction.published_registry import model_label

_T = TypeVar("_T")

_LOG = logging.getLogger(__name__)
_NOTES = 3  # number of notes that are shown
_STALE = "opacity-30"  # of results of other settings
_REACH = 0.3  # of a slider to both sides [mm, deg]
COLOURS = {"fault": "negative", "warning": "warning", "for information": "info"}


class Page:
    """One browser tab: its scene and elements."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        self.scene = bench.start()
        self.busy = self.waiting = False
        self.inputs: dict[str, Any] = {}
        self.sliders: dict[str, Any] = {}
        self.drawn: dict[str, Scene] = {}  # what map and contact were drawn for
        drawer = self._controls()
        with ui.tabs() as tabs:
            pair, axle = ui.tab("Gear pair"), ui.tab("Axle").mark("axle_tab")
        with ui.tab_panels(tabs, value=pair).props("keep-alive").classes("w-full bg-transparent"):
            with ui.tab_panel(axle):
                whole = AxleTab(bench)
            with ui.tab_panel(pair), ui.column().classes("w-full max-w-screen-xl mx-auto gap-3 p-2"):
                with ui.card().classes("w-full"):
                    ui.label("Efficiency of the mesh").classes("text-sm opacity-70")
                    self.headline = ui.label("…").classes("text-3xl font-bold").mark("headline")
                    self.details = ui.label("").classes("text-sm details")
                    self.fault = ui.label("").classes("text-negative whitespace-pre-line").mark("fault")
                    self.fault.set_visibility(False)
                    self.stale = ui.label("The results below belong to the last valid settings.").mark("stale")
                    self.stale.classes("text-negative").set_visibility(False)
                    self.notes = ui.column().classes("w-full gap-1")
                with ui.row().classes("w-full gap-3"):
                    self.pressure = chart_card("Contact pressure on the gear tooth [GPa]")
                    self.loss = chart_card("Loss on the gear tooth [W/mm²]")
                self.bars = chart_card("Power loss by friction model [W] with 90 % intervals from the inputs", "w-full")
                with ui.row().classes("w-full gap-3"):
                    with ui.card().classes("flex-1 min-w-[320px]"):
                        self.map_button = ui.button("Efficiency map", on_click=self._draw_map).mark("map")
                        self.progress = ui.linear_progress(0.0, show_value=False)
                        self.progress.set_visibility(False)
                        self.map = ui.echart({"series": []}).classes("h-80 w-full")
                        self.map.set_visibility(False)
                        self.map_stale = _outdated("map")
                    with ui.card().classes("flex-1 min-w-[320px]"):
                        self.contact_button = ui.button(
                            "Film and pressure of the contact with the largest loss (smooth)"
                        )
                        self.contact_button.on_click(self._draw_contact)
                        self.contact_text = ui.label("")
                        self.contact = ui.image().classes("w-full")
                        self.contact.set_visibility(False)
                        self.contact_stale = _outdated("contact")
                with ui.row().classes("gap-2"):
                    for words, name, make in (
                        ("Design file", "design.toml", bench.design_text),
                        ("Report", "report.html", self._report),
                        ("Python script", "efficiency_of_pair.py", bench.script),
                    ):
                        ui.button(words, on_click=partial(self._save, name, make)).props("outline")

        async def turned(event: Any) -> None:
            drawer.set_value(event.value != "Axle")  # its settings are those of the pair
            if event.value == "Axle":
                await whole.refresh()

        tabs.on_value_change(turned)
        ui.timer(0.05, self.refresh, once=True)

    # controls

    def _controls(self) -> Any:
        drawer = ui.left_drawer().classes("gap-1")
        with ui.header().classes("items-center justify-between py-1"):
            flat = "flat color=white dense"
            with ui.row().classes("items-center"):
                ui.button(icon="menu", on_click=lambda: drawer.toggle()).props(f'{flat} aria-label="settings"')
                ui.label("mixed-ehl").classes("text-lg")
            dark = ui.dark_mode(None)
            contrast = ui.button(icon="contrast", on_click=lambda: dark.set_value(not dark.value))
            contrast.props(f'{flat} aria-label="light or dark"')
        with drawer:
            self._select("design", self.bench.designs)
            self._select("side", ["drive", "coast"])
            self._select("oil", list(data_names("oils")))
            self._select("friction", {name: model_label(name) for name in FRICTIONS})
            self._select("finish", {"": "as designed"} | {name: name for name in FINISHES})
            for name in FIELDS:
                if name not in MISALIGNMENTS and name not in SHAPE:
                    self._number(name)
            ui.label("flanks, both sides").classes("text-sm opacity-70 mt-2")
            for name in SHAPE:
                self._number(name)
                slider = ui.slider(min=0.0, max=1.0, step=0.01).props("dense").mark(f"slider {name}")
                field = self.inputs[name]
                # when released: settings take a second
                slider.on("change", lambda _, slider=slider, field=field: field.set_value(f"{slider.value:.4g}"))
                self.sliders[name] = slider
            ui.label("misalignment").classes("text-sm opacity-70 mt-2")
            for name in MISALIGNMENTS:
                self._number(name, _REACH)
        self._place_sliders()
        return drawer

    def _place_sliders(self) -> None:
        """Sliders of the flanks from nothing, or half of the offset, to three times the design's value."""
        start = self.bench.start(self.scene.design)
        for name, slider in self.sliders.items():
            text = getattr(start, name)
            value = float(text or 0.0)
            shares = (0.5, 1.3) if name == "hypoid_offset" else (0.1, 3.0)
            low, high = sorted(share * value for share in shares)
            slider.set_visibility(value != 0.0)
            self.inputs[name].set_visibility(bool(text))
            slider.props(f":min={low:.6g} :max={high or 1.0:.6g} :step={(high - low) / 50.0 or 1.0:.6g}")
            slider.set_value(float(getattr(self.scene, name) or 0.0))

    def _select(self, name: str, names: list[str] | dict[str, str]) -> None:
        value = getattr(self.scene, name)
        shown = names if isinstance(names, dict) else dict(zip(names, names, strict=True))
        chosen = ui.select(shown if value in shown else {value: value} | shown, value=value, label=CHOICES[name])
        chosen.classes("w-full").props("dense").mark(name)
        chosen.on_value_change(lambda event: self._set(name, event.value))
        self.inputs[name] = chosen

    def _number(self, name: str, reach: float = 0.0) -> None:
        unit, label = FIELDS[name]
        field = ui.input(f"{label}{f' [{typeset_unit(unit)}]' if unit else ''}", value=getattr(self.scene, name))
        field.classes("w-full").props("dense debounce=60").mark(name)
        field.on_value_change(lambda event: self._set(name, event.value))
        self.inputs[name] = field
        if reach:
            slider = ui.slider(min=-reach, max=reach, step=reach / 30.0, value=0.0).props("dense")
            slider.on_value_change(lambda event: field.set_value(f"{event.value:.4g}"))

    async def _set(self, name: str, value: str | None) -> None:
        if getattr(self.scene, name) == str(value or ""):
            return
        if name == "design":
            await self._open(str(value))
            return
        self.scene = changed(self.scene, **{name: str(value or "")})
        if name == "finish":  # its Rq and lay
            self.scene = changed(
                self.scene, **self.bench.roughness(self.scene.design, self.scene.finish), peklenik_number=""
            )
            self._fill()
        await self.refresh()

    async def _open(self, design: str) -> None:
        self.headline.text = "opening…"
        scene = await self._try(lambda: self.bench.start(design))
        if scene is None:
            return
        self.scene = scene
        self._fill()
        self._place_sliders()
        await self.refresh()

    def _fill(self) -> None:
        for name, element in self.inputs.items():
            element.set_value(getattr(self.scene, name))

    # answers

    async def _try(self, work: Callable[[], _T]) -> _T | None:
        """The result of a function run in a thread, or None with its error on the page."""
        scene = self.scene

        def attempt() -> tuple[_T | None, dict[str, str]]:
            try:
                return work(), {}
            except InputError as error:
                return None, self.bench.problems(scene, error)

        try:
            found, wrong = await run.io_bound(attempt)  # type: ignore[misc]
        except MixedEhlError as error:
            self._refuse(str(error))
            return None
        except Exception as error:
            _LOG.exception("fault of the page")
            self._refuse(
                f"Program error ({type(error).__name__}: {error}). Please send the output of the terminal and the "
                "settings of this page."
            )
            return None
        self._refuse("\n".join(wrong.values()), wrong)
        return found

    def _refuse(self, words: str, fields: Collection[str] = ()) -> None:
        """Show the errors and mark their fields; an empty text hides them."""
        self.fault.text = words
        self.fault.set_visibility(bool(words))
        for name, element in self.inputs.items():
            element.error = "see above" if name in fields else None

    async def refresh(self) -> None:
        """Compute the current scene; of scenes set during the computation only the last one is computed next."""
        if self.busy:
            self.waiting = True
            return
        self.busy = True
        try:
            while True:
                self.waiting = False
                scene = self.scene
                answer = await self._try(lambda scene=scene: self.bench.answer(scene))  # type: ignore[misc]
                self._mark(fresh=answer is not None)
                if answer is None:
                    self.headline.text, self.details.text = "no result", ""
                else:
                    self._show(answer)
                    pictures = await self._try(lambda answer=answer: _drawn(answer))  # type: ignore[misc]
                    if pictures is not None:
                        self._show_pictures(*pictures)
                if not self.waiting and answer is not None:
                    await asyncio.sleep(0.2)
                    if not self.waiting:
                        rows = await self._try(lambda scene=scene: self.bench.compared(scene))  # type: ignore[misc]
                        if rows is not None:
                            charts.draw(self.bars, charts.losses(rows))
                if not self.waiting:
                    return
        finally:
            self.busy = False

    def _mark(self, *, fresh: bool) -> None:
        """Dim results of other settings."""
        self.stale.set_visibility(not fresh)
        for element in (self.notes, self.pressure, self.loss, self.bars):
            element.classes(**({"remove": _STALE} if fresh else {"add": _STALE}))
        for name, element, words in (("map", self.map, self.map_stale), ("contact", self.contact, self.contact_stale)):
            old = name in self.drawn and self.drawn[name] != self.scene
            words.set_visibility(old)
            element.classes(**({"add": _STALE} if old else {"remove": _STALE}))

    def _show(self, answer: SceneAnswer) -> None:
        found = answer.result
        self.headline.text = answer.headline()
        self.details.text = (
            ""
            if found.status == "failed"
            else f"{rounded(found.power_loss, 3):.6g} W of {found.power_input / 1e3:.4g} kW lost, mean friction "
            f"coefficient {found.friction_coefficient_mean:.4f}, maximum Hertz pressure "
            f"{found.pressure_hertz_max / 1e9:.3g} GPa, by {model_label(answer.friction)}; in brackets: 90 % "
            "interval from oil, surfaces and formula; numerical "
            f"error {100.0 * found.efficiency_error:.1g} percentage points"
        )

    def _show_pictures(self, pressure: dict[str, Any], loss: dict[str, Any], notes: list[Any]) -> None:
        charts.draw(self.pressure, pressure)
        charts.draw(self.loss, loss)
        first, rest = notes[:_NOTES], notes[_NOTES:]
        self.notes.clear()
        with self.notes:
            for note in first:
                _note(note)
            if rest:
                with ui.expansion(f"{len(rest)} more").classes("w-full"):
                    for note in rest:
                        _note(note)

    async def _draw_map(self) -> None:
        self.map_button.disable()
        self.progress.set_visibility(True)
        states = [Progress("points", 0, 1)]
        watch = ui.timer(0.2, lambda: self.progress.set_value(states[-1].done / states[-1].total))
        scene = self.scene
        found = await self._try(lambda: self.bench.map(scene, states.append))
        watch.cancel()
        self.progress.set_visibility(False)
        self.map_button.enable()
        if found is None:
            return
        charts.draw(self.map, charts.efficiency_map(*found))
        self.map.set_visibility(True)
        self.drawn["map"] = scene
        self._mark(fresh=True)

    async def _draw_contact(self) -> None:
        self.contact_button.disable()
        self.contact_text.text = "solving; in a new installation the solver is compiled first, about 20 s"
        scene = self.scene

        def solve() -> tuple[str, str]:
            result = self.bench.contact(scene).solve()
            held = io.BytesIO()
            result.figure().savefig(held, format="png", dpi=110, bbox_inches="tight")
            return "data:image/png;base64," + base64.b64encode(held.getvalue()).decode(), (
                f"mu {result.friction_coefficient:.4f} ± {100 * result.friction_error:.2g} %, central film "
                f"{1e9 * result.film_central:.3g} nm, {result.status}"
            )

        found = await self._try(solve)
        self.contact_button.enable()
        if found is None:
            self.contact_text.text = ""
            return
        self.contact.set_source(found[0])
        self.contact.set_visibility(True)
        self.contact_text.text = found[1]
        self.drawn["contact"] = scene
        self._mark(fresh=True)

    # exports

    async def _save(self, name: str, make: Callable[[Scene], str | bytes]) -> None:
        content = await self._try(lambda: make(self.scene))
        if content is not None:
            ui.download.content(content, name)

    def _report(self, scene: Scene) -> bytes:
        with tempfile.TemporaryDirectory() as folder:
            return self.bench.answer(scene).result.report(Path(folder) / "report.html").read_bytes()


def _outdated(name: str) -> Any:
    words = ui.label("For earlier settings; press the button to update.").classes("text-negative").mark(f"old {name}")
    words.set_visibility(False)
    return words


def _note(note: Any) -> None:
    with ui.row().classes("w-full items-start no-wrap gap-2"):
        ui.badge(note.grade, color=COLOURS[note.grade])
        ui.label(note.text).classes("text-sm")


def _drawn(answer: SceneAnswer) -> tuple[dict[str, Any], dict[str, Any], list[Any]]:
    """Charts of pressure and loss on the tooth, and the notes."""
    return charts.tooth(answer, "pressure_hertz"), charts.tooth(answer, "loss_density"), answer.notes


def chart_card(title: str, classes: str = "flex-1 min-w-[320px]") -> Any:
    """An empty chart in a card with a title."""
    with ui.card().classes(classes):
        ui.label(title).classes("text-sm opacity-70")
        return ui.echart({"series": []}).classes("h-72 w-full")


class AxleTab:
    """Controls and results of an axle."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.inputs, self.busy = bench, dict[str, Any](), False
        names = list(data_names("axles"))
        with ui.row().classes("w-full gap-3 items-end"):
            self.inputs["axle"] = ui.select(names, value=names[0], label="axle").props("dense").mark("axle")
            for name, (label, value) in AXLE_FIELDS.items():
                self.inputs[name] = ui.input(label, value=value).props("dense debounce=300").mark(f"axle_{name}")
            for name, field in MethodsInput.model_fields.items():
                chosen = ui.select(list(get_args(field.annotation)), value=field.default, label=name)
                self.inputs[name] = chosen.classes("w-40").props("dense").mark(f"axle_{name}")
        with ui.card().classes("w-full"):
            self.headline = ui.label("").classes("text-3xl font-bold").mark("axle_headline")
            self.details = ui.label("").classes("text-sm whitespace-pre-line")
            self.fault = ui.label("").classes("text-negative").mark("axle_fault")
        with ui.row().classes("w-full gap-3"):
            self.bars = chart_card("Loss by source [W]; marks: 90 % interval")
            with ui.card().classes("flex-1 min-w-[320px]"):
                ui.button("Loss over the speed", on_click=self._draw_speeds).mark("axle_speeds")
                self.speeds = ui.echart({"series": []}).classes("h-80 w-full")
        ui.label(OUTSIDE).classes("text-sm opacity-70")
        for element in self.inputs.values():
            element.on_value_change(self.refresh)

    async def _try(self, work: Callable[[], Any]) -> Any:
        def attempt() -> tuple[Any, str]:
            try:
                return work(), ""
            except MixedEhlError as error:
                return None, str(error)

        found, self.fault.text = await run.io_bound(attempt)  # type: ignore[misc]
        return found

    def _texts(self) -> dict[str, str]:
        return {name: str(element.value or "") for name, element in self.inputs.items()}

    async def refresh(self) -> None:
        """Compute the result of the current inputs, again if they change during the computation."""
        if self.busy:
            return
        self.busy, texts = True, dict[str, str]()
        try:
            while texts != self._texts():
                texts = self._texts()
                self.headline.text = "computing"
                found = await self._try(lambda texts=texts: self.bench.axle_point(texts))  # type: ignore[misc]
                self.headline.text, self.details.text = ("no result", "") if found is None else _words(found)
                if found is not None and not found.reason:
                    rows = [(name, *row[:3]) for name, row in found.split().items()]
                    charts.draw(self.bars, charts.losses(rows))
        finally:
            self.busy = False

    async def _draw_speeds(self) -> None:
        texts = self._texts()
        found = await self._try(lambda: self.bench.axle_speeds(texts))
        if found is not None:
            charts.draw(self.speeds, charts.stacked(*found))


def _words(found: AxleResult) -> tuple[str, str]:
    """Loss with its interval; efficiency, temperatures, other methods and notes."""
    total, low, high, _ = found.split()["total"]
    if found.reason:
        return "no result", "\n".join((reason_text(found.reason), *found.notes))
    point = found.points[0]
    others = ", ".join(f"{name} {rounded(loss, 2):.6g} W" for name, loss in found.alternatives.items())
    lines = [
        f"Efficiency {100.0 * point.axle_efficiency:.1f} %, oil {point.temperature - KELVIN:.1f} °C, housing "
        f"{point.temperature_housing - KELVIN:.1f} °C, heat that warms the axle {rounded(point.heat_stored, 2):.6g} W.",
        f"Other methods: {others}.",
    ]
    total, low, high = (rounded(value, 2) for value in (total, low, high))
    return f"{total:.6g} W ({low:.6g} to {high:.6g})", "\n".join((*lines, *found.notes))


def serve(bench: Bench, port: int, token: str, *, browser: bool) -> None:
    """Serve the page on the loopback address until Ctrl-C, to users with the token."""
    app.add_middleware(Guard, port=port, token=token)
    core.sio.eio.cors_allowed_origins = []  # no CORS headers; the guard checks the origin

    @ui.page("/")
    def index() -> None:
        Page(bench)

    ui.run(
        host="127.0.0.1",
        port=port,
        show=f"/?token={token}" if browser else False,
        reload=False,
        title="mixed-ehl",
        show_welcome_message=False,
        reconnect_timeout=60.0,  # [s]; a tab that a busy or sleeping machine keeps away longer loses what was typed
        timeout_graceful_shutdown=2,  # [s]; without it the server waits for browsers that do not answer
    )
