"""Loss maps in the formats of other programs: VECTO, Functional Mock-up Unit, Modelica, MATLAB with Simscape."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from efficiency.vehicle.loss_map import INTERVAL, LossMap
from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError
from ehl.common.quantities import quantity
from regression.export.export import identifier
from regression.export.fmu import Variable, fmu
from regression.export.printer import number_rows

VECTO = ".vtlm"
VECTO_HEAD = "Input Speed [rpm],Input Torque [Nm],Torque Loss [Nm]"


def check_axes(path: Path | str, torques: FloatArray, speeds: FloatArray) -> None:
    """Raise an `InputError` for increasing torques and speeds whose map the format of a file does not accept."""
    path = Path(path)
    if path.suffix.lower() != VECTO and min(len(torques), len(speeds)) < 2:
        found = f"{len(torques)} torques, {len(speeds)} speeds"
        raise InputError("model", found, "at least two torques and two speeds")
    if path.suffix.lower() == VECTO and not torques[0] < 0.0 < torques[-1]:
        of = quantity("torque")
        hint = "VECTO requires drive and coast: add torques of the other sign, such as '-300:300:7 N m'."
        raise InputError("torque", of.span(torques[0], torques[-1]), "negative and positive torques", hint)


def vecto(found: LossMap, path: Path) -> str:
    """Loss map of VECTO for a gear or an axle.

    VECTO would extrapolate below the lowest speed. The file therefore repeats the torque losses of the lowest speed at
    0 rpm, with a comment in its first line.
    """
    torques = found.torques
    rpm = quantity("speed").to_display(found.speeds)
    losses = found.values()
    rows = [
        f"{speed:.2f},{torque:.2f},{loss:.4f}"
        for speed, line in zip([0.0, *rpm], [losses[0], *losses], strict=True)
        for torque, loss in zip(torques, line, strict=True)
    ]
    outside = float(np.max(found.values("outside_range_share")))
    parts = [_about(found), f"at 0 rpm the torque losses of {rpm[0]:.4g} rpm, the lowest speed of the map"]
    if outside > 0.0:
        parts.append(f"up to {100.0 * outside:.3g} % of the sliding power outside the range of the friction model")
    # VECTO's own files have one comment at the end of the head as well
    comment = "; ".join(parts).replace("#", " ").replace(",", ";")
    return "\n".join([f"{VECTO_HEAD} # {comment}", *rows]) + "\n"


def functional_mockup_unit(found: LossMap, path: Path) -> bytes:
    """FMU (FMI 2.0, model exchange and co-simulation).

    Inputs: `torque` and `speed` of the pinion. Outputs: `torque_loss` by bilinear interpolation, with its interval if
    the map has one, `efficiency`, and `in_range`, which is 0 outside the axes. There the loss is that of the nearest
    point.
    """
    tables = _tables(found)
    inputs = [
        Variable("torque", "N.m", "pinion torque, negative in coast", found.torques[-1]),
        Variable("speed", "rad/s", "pinion speed", found.speeds[-1]),
    ]
    outputs = [Variable(table, "N.m", text) for table, text in tables.items()]
    outputs.append(Variable("efficiency", "", "output over input power; in coast the gear is the input"))
    outputs.append(Variable("in_range", "", "1 within the axes of the map, else 0"))
    losses = [found.values(table) for table in tables]
    text = _c_tables(found.torques, found.speeds, losses)
    return fmu(identifier(path), _about(found), inputs, outputs, text, _C_BODY)


def modelica(found: LossMap, path: Path) -> str:
    """Modelica package (Standard Library 4): block `TorqueLoss` with the map, table `lossTable` for `LossyGear`.

    `LossyGear` has one efficiency and one friction torque for each speed and direction, here from a least-squares line
    over the torques. The comment of the table states the largest deviation from the map. A map without drive or coast
    has no such table.
    """
    tables = _tables(found)
    name, both = identifier(path), bool(found.torques[0] < 0.0 < found.torques[-1])
    lossy, error = lossy_gear(found)
    blocks, outputs, equations = [], [], []
    for table, text in tables.items():
        grid = np.zeros((len(found.torques) + 1, len(found.speeds) + 1))
        grid[0, 1:], grid[1:, 0], grid[1:, 1:] = found.speeds, found.torques, found.values(table).T
        outputs.append(f'    Modelica.Blocks.Interfaces.RealOutput {table}(unit="N.m") "{text}";')
        blocks.append(
            f"    Modelica.Blocks.Tables.CombiTable2Ds {table}_table(table={_matrix(grid)}, {_MODELICA_TABLE});"
        )
        equations += [f"    {table}_table.{u} = {v};" for u, v in (("u1", "torque"), ("u2", "speed"))]
        equations.append(f"    {table} = {table}_table.y;")
    deviation = f"largest deviation from the map {error:.3g} N m"
    return "\n".join(
        [
            f'package {name} "{_about(found)}"',
            *(f'  constant Real lossTable[:,5] = {_matrix(lossy)} "Table of LossyGear, {deviation}";',) * both,
            '  block TorqueLoss "Torque loss at the pinion, bilinear; outside the axes that of the nearest point"',
            '    Modelica.Blocks.Interfaces.RealInput torque(unit="N.m") "Pinion torque, negative in coast";',
            '    Modelica.Blocks.Interfaces.RealInput speed(unit="rad/s") "Pinion speed";',
            *outputs,
            "  protected",
            *blocks,
            "  equation",
            *equations,
            "  end TorqueLoss;",
            '  annotation(uses(Modelica(version="4.0.0")));',
            f"end {name};\n",
        ]
    )


def matlab(found: LossMap, path: Path) -> str:
    """MATLAB script: axes and matrices of a `PS Lookup Table (2D)` in Simscape or a `2-D Lookup Table` in Simulink."""
    name = identifier(path)
    values = {"torque": found.torques[:, None], "speed": found.speeds[None, :]}
    texts = {"torque": "pinion torque [N m], negative in coast; first input", "speed": "pinion speed [rad/s]"}
    values |= {table: found.values(table).T for table in _tables(found)}
    texts |= {table: f"{text} [N m], rows: torque" for table, text in _tables(found).items()}
    lines = [f"{name}.{key} = {_matrix(value, ' ...')};  % {texts[key]}" for key, value in values.items()]
    return "\n".join([f"% {_about(found)}", "% Interpolation: linear; extrapolation: nearest.", *lines]) + "\n"


def lossy_gear(found: LossMap) -> tuple[FloatArray, float]:
    """Table of `Modelica.Mechanics.Rotational.Components.LossyGear`, and its largest deviation from the map.

    With the pinion torque T_in and T_out/ratio = T_in - T_loss:

        drive   T_out/ratio = eta_mf1 T_in - tau_bf1,   coast   T_out/ratio = T_in/eta_mf2 - tau_bf2

    The model extrapolates its table linearly: the first row is repeated at rest, the last one at twice its speed.

    Returns (rows, 5): speed [rad/s], eta_mf1, eta_mf2, tau_bf1, tau_bf2 [N m]; and the deviation [N m].
    """
    rows, error = [], 0.0
    for speed, losses in zip(found.speeds, found.values(), strict=True):
        lines = []
        for side in (found.torques >= 0.0, found.torques <= 0.0):
            x, y = found.torques[side], (found.torques - losses)[side]
            if not len(x):
                lines.append((1.0, 0.0))
                continue
            slope, level = np.polyfit(x, y, 1) if len(x) > 1 else (1.0, float(y[0] - x[0]))
            level = min(level, 0.0)
            slope = slope if level < 0.0 or len(x) < 2 else float(x @ y / (x @ x))
            error = max(error, float(np.abs(slope * x + level - y).max()))
            lines.append((slope, abs(level)))
        (drive, first), (coast, second) = lines
        rows.append((speed, drive, 1.0 / coast, first, second))
    table = np.array(rows)
    rest, fast = table[:1] * (0.0, 1.0, 1.0, 1.0, 1.0), table[-1:] * (2.0, 1.0, 1.0, 1.0, 1.0)
    return np.vstack([rest[rest[:, 0] < table[0, 0]], table, fast]), error


def _tables(found: LossMap) -> dict[str, str]:
    """Names and descriptions of the tables of a map."""
    tables = {"torque_loss": "torque loss at the pinion"}
    if np.all(np.isfinite(found.values("torque_loss_upper"))):
        tables |= {name: f"{name[-5:]} end of its 90 % interval" for name in INTERVAL}
    return tables


def _about(found: LossMap) -> str:
    return f"{found.table().title}; {found.case_notes[0][1]}".replace("\n", " ").replace('"', "'")


_MODELICA_TABLE = (
    "smoothness=Modelica.Blocks.Types.Smoothness.LinearSegments, "
    "extrapolation=Modelica.Blocks.Types.Extrapolation.HoldLastPoint"
)


def _matrix(values: FloatArray, wrap: str = "") -> str:
    """Text of a matrix in Modelica and MATLAB, one row per line."""
    rows = [", ".join(f"{value:.15g}" for value in row) for row in values]
    return "[" + f";{wrap}\n    ".join(rows) + "]"


# bilinear interpolation of the tables, and the outputs of the unit
_C_PLACE = """
static int place(const double axis[], int n, double x, double *share)
{
    int k = 0;
    while (k < n - 2 && x > axis[k + 1]) k++;
    *share = (x - axis[k]) / (axis[k + 1] - axis[k]);
    *share = *share < 0.0 ? 0.0 : *share > 1.0 ? 1.0 : *share;
    return k;
}"""
_C_BODY = """\
    double a, b;
    const int i = place(speeds, SPEEDS, u[1], &a), j = place(torques, TORQUES, u[0], &b);
    for (int k = 0; k < TABLES; k++) {
        const double low = tables[k][i][j] + b * (tables[k][i][j + 1] - tables[k][i][j]);
        y[k] = low + a * (tables[k][i + 1][j] + b * (tables[k][i + 1][j + 1] - tables[k][i + 1][j]) - low);
    }
    y[TABLES] = u[0] == 0.0 ? 0.0 : u[0] > 0.0 ? 1.0 - y[0] / u[0] : u[0] / (u[0] - y[0]);
    y[TABLES + 1] = u[0] >= torques[0] && u[0] <= torques[TORQUES - 1];
    y[TABLES + 1] *= u[1] >= speeds[0] && u[1] <= speeds[SPEEDS - 1];"""


def _c_tables(torques: FloatArray, speeds: FloatArray, losses: Sequence[FloatArray]) -> str:
    """C text of the axes and tables of a map."""

    def array(name: str, values: FloatArray) -> str:
        return f"static const double {name} = {{\n{number_rows([values.ravel().tolist()], '    ', '  ').strip()}\n}};"

    sizes = f"enum {{ SPEEDS = {len(speeds)}, TORQUES = {len(torques)}, TABLES = {len(losses)} }};"
    axes = [array("speeds[SPEEDS]", speeds), array("torques[TORQUES]", torques)]
    return "\n".join([sizes, *axes, array("tables[TABLES][SPEEDS][TORQUES]", np.array(losses)), _C_PLACE])


FORMATS: dict[str, Callable[[LossMap, Path], str | bytes]] = {
    VECTO: vecto,
    ".fmu": functional_mockup_unit,
    ".mo": modelica,
    ".m": matlab,
}
