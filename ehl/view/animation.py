"""The moving roughness as a film: pressure, the gap between both surfaces with its contact spots, friction."""

from __future__ import annotations

import base64
import copy
import io
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from ehl.common.errors import InputError
from ehl.common.figures import BLUE, GREY, ORANGE
from ehl.rough import Snapshot, TransientResult
from ehl.rough._kernels.march import MU_FLUID, SHARE
from ehl.rough._kernels.motion import sample_profile
from ehl.rough._kernels.records import TRAVEL
from ehl.rough.solve import snapshot
from ehl.view.rough_plots import DARK, SHOWN, hertz_line

if TYPE_CHECKING:
    from PIL.Image import Image

    from ehl.inputs import ContactProblem
    from ehl.line_contact import LineContact

Array = NDArray[np.float64]

FRAMES, ROLLED = 100, 4.0  # number, and travel they cover [b]
PER_SECOND = 15
DOTS_PER_INCH = 80
BODY, OIL = "#d5d9df", "#f4e7c5"


@dataclass(frozen=True, eq=False)
class Frame:
    """One moment of the contact.

    Parameters
    ----------
    travel : float
        Rolled distance since the first frame [b].
    friction : float
        mu of this time step [-].
    contact : Snapshot
        Pressures and film along x.
    upper, lower : ndarray, shape (n,)
        Edges of surface 1 and of surface 2 [m], the film apart; curvature and elastic deflection are shared evenly.
    """

    travel: float
    friction: float
    contact: Snapshot
    upper: Array
    lower: Array


def roll_on(transient: TransientResult, count: int = FRAMES, travel: float = ROLLED) -> list[Frame]:
    """Frames from rolling a solved contact on from its last step; the solution itself is left as it is.

    Parameters
    ----------
    transient : TransientResult
    count : int
        Number of frames; fewer where the time steps are longer.
    travel : float
        Rolled distance they cover [b].
    """
    run = copy.deepcopy(transient.run)
    units, model = run.problem.units, run.problem.model
    stride = max(1, round(travel * units.steps_per_half_width / count))
    frames = []
    for k in range(max(1, int(travel * units.steps_per_half_width / stride))):
        records, _ = run.advance(stride)
        steps = float(run.state.scalars[TRAVEL])
        heights = np.zeros((2, run.problem.x.size))
        sample_profile(model.surfaces.profile_1, model.surfaces.shift_1 * steps, units.film, heights[0])
        sample_profile(model.surfaces.profile_2, model.surfaces.shift_2 * steps, units.film, heights[1])
        now = snapshot(run)
        middle = 0.5 * (heights[1] - heights[0])
        mu = float(records[-1, MU_FLUID] + model.contact.friction * records[-1, SHARE])
        rolled = (k + 1) * stride / units.steps_per_half_width
        frames.append(Frame(rolled, mu, now, middle + 0.5 * now.film, middle - 0.5 * now.film))
    return frames


def check_animation(problem: ContactProblem, path: Path) -> None:
    """Whether an animation can come of this, before anything is computed.

    Raises
    ------
    InputError
        Another suffix than .gif and .html, no such folder, or a contact in which nothing moves.
    """
    if path.suffix.lower() not in WRITERS:
        raise InputError("animate", str(path), "a file name ending in .gif or .html")
    if not os.path.isdir(path.parent):
        raise InputError("animate", str(path), "a file in an existing folder")
    if problem.model.roughness != "deterministic":
        raise InputError(
            "animate",
            str(path),
            "a contact with model.roughness = 'deterministic'",
            f"Nothing moves in the {problem.model.roughness} model.",
        )
    if not problem.rough:
        raise InputError("animate", str(path), "a contact with a rough surface", "Nothing moves between smooth ones.")


def animate_contact(problem: ContactProblem, transient: TransientResult | None, friction: float, path: Path) -> Path:
    """Write the animation of a deterministic solution as GIF or as a self-contained HTML page.

    Raises
    ------
    InputError
        As `check_animation`; the roughness was left out because the film is thick; the file cannot be written.
    """
    check_animation(problem, path)
    if transient is None:
        raise InputError(
            "animate",
            str(path),
            "a solution with its roughness",
            "It was left out because the film is thick; model.shortcuts = 'off' keeps it.",
        )
    film = _Pictures(problem.line, friction, roll_on(transient))
    try:
        WRITERS[path.suffix.lower()](film, path)
    except OSError as error:
        raise InputError("animate", str(path), "a writable file", f"{error}.") from None
    return path


class _Pictures:
    """The figure and what changes in it from frame to frame; only that is drawn anew, four times as fast."""

    def __init__(self, contact: LineContact, mean_friction: float, frames: list[Frame]) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.frames = frames
        self.x = frames[0].contact.x / contact.half_width
        self.figure = Figure(figsize=(7.0, 6.6), dpi=DOTS_PER_INCH, layout="constrained")
        pressure, gap, friction = self.figure.subplots(3, 1, height_ratios=(3.0, 3.0, 1.5))

        hertz_line(pressure, contact.pressure_hertz)
        (self.fluid,) = pressure.plot([], [], color=BLUE, lw=1.2, label="fluid")
        self.asperities = pressure.fill_between(self.x, 0.0 * self.x, color=ORANGE, lw=0.0, label="asperities")
        shown = (SHOWN[0], float(self.x[-1]))
        highest = max(float((f.contact.pressure_fluid + f.contact.pressure_asperity).max()) for f in frames)
        pressure.set(xlim=shown, ylim=(0.0, 1.05 * highest / 1e9), ylabel="pressure [GPa]")
        pressure.legend(loc="upper left", frameon=False, fontsize=8)

        inside = np.abs(self.x) < 1.0
        self.top = 1.3e6 * max(float(np.abs(e[inside]).max()) for f in frames for e in (f.upper, f.lower))
        gap.set(xlim=shown, ylim=(-self.top, self.top), ylabel="height [µm]", xlabel="x/b [-]", facecolor=OIL)
        self.bodies = [gap.fill_between(self.x, 0.0 * self.x, color=BODY, ec=DARK, lw=0.8) for _ in range(2)]
        (self.spots,) = gap.plot([], [], color=ORANGE, marker="o", ms=3.0, ls="none", label="contact")
        over = [gap.legend(loc="upper left", framealpha=0.9, edgecolor="none", fontsize=8), *gap.spines.values()]
        for y, i, speed in ((0.9, 1, contact.speed_1), (0.1, 2, contact.speed_2)):
            text = f"surface {i}, {abs(speed):.3g} m/s {'←' if speed < 0.0 else '→'}"
            over.append(gap.text(0.99, y, text, transform=gap.transAxes, ha="right", va="center", fontsize=8))

        mu = [frame.friction for frame in frames]
        spread = max(max(mu) - min(mu), 1e-6)
        friction.axhline(mean_friction, color=GREY, ls="--", lw=1.0, label="time mean")
        (self.trace,) = friction.plot([], [], color=BLUE, lw=1.2)
        friction.set(
            xlim=(0.0, frames[-1].travel),
            ylim=(min(mu) - 0.2 * spread, max(mu) + 0.2 * spread),
            xlabel="rolled distance [b]",
            ylabel="friction [-]",
        )
        friction.legend(loc="upper left", frameon=False, fontsize=8)
        self.moving = [self.fluid, self.asperities, *self.bodies, self.spots, *over, self.trace]
        for artist in self.moving:
            artist.set_animated(True)
        self.canvas = cast(Any, FigureCanvasAgg(self.figure))
        self.canvas.draw()
        self.still = self.canvas.copy_from_bbox(self.figure.bbox)

    def picture(self, k: int) -> Image:
        """One frame."""
        from PIL.Image import fromarray

        self._show(k)
        self.canvas.restore_region(self.still)
        for artist in self.moving:
            self.figure.draw_artist(artist)
        return fromarray(np.asarray(self.canvas.buffer_rgba())[:, :, :3].copy())

    def _show(self, k: int) -> None:
        frame, x = self.frames[k], self.x
        self.fluid.set_data(x, frame.contact.pressure_fluid / 1e9)
        self.asperities.set_verts([_below(x, frame.contact.pressure_asperity / 1e9, 0.0)])
        for body, edge, end in zip(self.bodies, (frame.upper, frame.lower), (self.top, -self.top), strict=True):
            body.set_verts([_below(x, edge * 1e6, 2.0 * end)])
        touching = frame.contact.pressure_asperity > 0.0
        self.spots.set_data(x[touching], 0.5e6 * (frame.upper + frame.lower)[touching])
        self.trace.set_data([f.travel for f in self.frames[: k + 1]], [f.friction for f in self.frames[: k + 1]])


def _below(x: Array, edge: Array, base: float) -> Array:
    """Corners of the area between an edge and a level."""
    return np.column_stack([np.r_[x[0], x, x[-1]], np.r_[base, edge, base]])


def _write_gif(film: _Pictures, path: Path) -> None:
    first, *others = [film.picture(k).quantize(64) for k in range(len(film.frames))]
    first.save(path, format="GIF", save_all=True, append_images=others, duration=1000 // PER_SECOND, loop=0)


def _write_html(film: _Pictures, path: Path) -> None:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    pictures = []
    for k in range(len(film.frames)):
        buffer = io.BytesIO()
        film.picture(k).save(buffer, format="WEBP", quality=80)
        pictures.append(base64.b64encode(buffer.getvalue()).decode("ascii"))
    environment = Environment(loader=PackageLoader("ehl.view"), autoescape=True, undefined=StrictUndefined)
    page = environment.get_template("animation.html").render(pictures=pictures, per_second=PER_SECOND)
    path.write_text(page, encoding="utf-8")


WRITERS = {".gif": _write_gif, ".html": _write_html}
