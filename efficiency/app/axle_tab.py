"""The tab of a whole axle: operating point and methods, loss by source with intervals, loss over the speed."""

from collections.abc import Callable
from typing import Any, get_args

from nicegui import run, ui

from efficiency.app import charts
from efficiency.app.scene import AXLE_FIELDS, Bench
from efficiency.axle.axle_input import MethodsInput
from efficiency.axle.result import OUTSIDE, AxleResult
from ehl.common.data import data_names, reason_text
from ehl.common.errors import MixedEhlError
from ehl.common.quantities import rounded
from ehl.common.units import KELVIN


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
        """Compute the result of the current inputs, repeatedly if they change meanwhile."""
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
