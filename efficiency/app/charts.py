"""Options of the charts of the page (ECharts): plain dictionaries, drawn by the browser."""

from collections.abc import Mapping, Sequence
from typing import Any

from efficiency.app.scene import SceneAnswer

Options = dict[str, Any]

GREY = "#8a8a8a"  # of axes, on light and dark
AXIS: Options = {"axisLabel": {"color": GREY}, "nameTextStyle": {"color": GREY}}
# viridis, as in the reports
SCALE = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"]
COLOURS: Options = {
    "right": 0,
    "top": "middle",
    "precision": 2,
    "inRange": {"color": SCALE},
    "calculable": True,
    "textStyle": {"color": GREY},
}


def draw(chart: Any, options: Options) -> None:
    """Show other options in a chart of the page."""
    chart.options.update(options)
    chart.update()


def tooth(answer: SceneAnswer, name: str) -> Options:
    """A quantity of `SceneAnswer.tooth` on the gear flank, with its outline."""
    points, top = answer.tooth(name)
    line = {"onZero": False, "show": True}
    axis = AXIS | {"type": "value", "scale": True, "splitLine": {"show": False}, "axisLine": line}
    return {
        "animation": False,
        "grid": {"left": 50, "right": 80, "top": 30, "bottom": 40},
        "tooltip": {},
        "xAxis": axis | {"name": "toe to heel [mm]", "nameLocation": "middle", "nameGap": 25},
        "yAxis": axis | {"name": "root to tip [mm]"},
        "visualMap": COLOURS | {"min": 0, "max": float(f"{top or 1.0:.3g}"), "dimension": 2, "seriesIndex": 0},
        "series": [
            {"type": "scatter", "symbolSize": 7, "data": points},
            {"type": "line", "symbol": "none", "silent": True, "data": answer.outline(), "lineStyle": {"color": GREY}},
        ],
    }


def losses(rows: Sequence[tuple[str, float, float, float]]) -> Options:
    """Loss by friction model, with marks at the ends of its interval."""
    grid = {"lineStyle": {"color": GREY, "opacity": 0.3}}
    ends = [[round(end, 2), name] for name, _, *both in rows if both[1] - both[0] > 1e-6 * both[1] for end in both]
    return {
        "grid": {"left": 150, "right": 40, "top": 10, "bottom": 30},
        "tooltip": {},
        "yAxis": AXIS | {"type": "category", "data": [name for name, *_ in rows], "inverse": True},
        "xAxis": AXIS | {"type": "value", "splitNumber": 3, "splitLine": grid},
        "series": [
            {"type": "bar", "data": [round(loss, 2) for _, loss, *_ in rows], "itemStyle": {"color": "#1f5c99"}},
            {
                "type": "scatter",
                "symbol": "rect",
                "symbolSize": [3, 14],
                "itemStyle": {"color": "#c8641e"},
                "data": ends,
            },
        ],
    }


def stacked(speeds: Sequence[float], losses: Mapping[str, Sequence[float]]) -> Options:
    """Loss by source over the speed, one on the other."""
    return {
        "grid": {"left": 60, "right": 20, "top": 40, "bottom": 45},
        "tooltip": {"trigger": "axis"},
        "legend": {"top": 0, "textStyle": {"color": GREY}},
        "xAxis": AXIS | {"type": "category", "data": speeds, "name": "rpm", "nameLocation": "middle", "nameGap": 30},
        "yAxis": AXIS | {"type": "value", "name": "W"},
        "series": [
            {"type": "line", "name": name, "stack": "loss", "areaStyle": {}, "symbol": "none", "data": list(values)}
            for name, values in losses.items()
        ],
    }


def efficiency_map(torques: Sequence[float], speeds: Sequence[float], rows: Sequence[Sequence[float]]) -> Options:
    """Efficiency over speed and torque."""
    cells = [[i, j, round(rows[j][i], 3)] for j in range(len(torques)) for i in range(len(speeds))]
    values = [cell[2] for cell in cells]
    return {
        "grid": {"left": 60, "right": 90, "top": 35, "bottom": 50},
        "tooltip": {"position": "top"},
        "xAxis": AXIS | {"type": "category", "data": speeds, "name": "rpm", "nameLocation": "middle", "nameGap": 30},
        "yAxis": AXIS | {"type": "category", "data": torques, "name": "N m"},
        "visualMap": COLOURS | {"min": min(values), "max": max(values), "text": ["%", ""]},
        "series": [{"type": "heatmap", "data": cells}],
    }
