"""Flanks of the reference gears of data/reference that several tests share, built from their printed settings."""

import json
from dataclasses import replace
from typing import Any

import numpy as np

from efficiency.cutting.blank import Blank
from efficiency.cutting.cutter import Blade
from efficiency.cutting.flank import CutFlank, index_start
from efficiency.cutting.machine import FORMATE, MachineSettings
from ehl.common.data import data_path

MM = 1e-3
CUTTING: dict[str, Any] = json.loads(data_path("reference", "gear_cutting.json").read_text(encoding="utf-8"))
GEOMETRY: dict[str, Any] = json.loads(data_path("reference", "gear_geometry.json").read_text(encoding="utf-8"))
HOBBED, PINION = CUTTING["fh_hypoid_gear_9x34"], CUTTING["fh_hypoid_pinion_9x34"]
HEAD, AGMA = HOBBED["cutter"], GEOMETRY["agma929_c"]
LENGTHS = {"radial_setting", "blank_offset", "sliding_base", "machine_centre_to_back"}


def hobbed_blank(b: dict[str, Any]) -> Blank:
    """Blank of uniform depth of a member of the face-hobbed pair 9x34."""
    angle = np.radians(b["pitch_angle"])
    cone = 0.5 * b["mean_pitch_diameter"] / np.sin(angle)
    apex = b["tz2"] if "tz2" in b else cone * np.cos(angle) - b["mean_distance_from_crossing"]
    lengths = {name: b[name] * MM for name in ("face_width", "mean_addendum", "mean_dedendum")}
    lengths |= {"mean_cone_distance": cone * MM, "pitch_apex_beyond_crossing": apex * MM}
    angles = {"pitch_angle": angle, "addendum_angle": 0.0, "dedendum_angle": 0.0}
    return Blank(teeth=b["teeth"], hand="right", **angles, **lengths)


def offset_angle() -> float:
    """Blade offset angle of the head: sin nu = z0 mn/(2 rc)."""
    module = HOBBED["blank"]["mean_pitch_diameter"] * np.cos(np.radians(HOBBED["printed"]["beta_m2"]))
    return float(np.arcsin(HEAD["blade_groups"] * module / HOBBED["blank"]["teeth"] / (2.0 * HEAD["cutter_radius"])))


def hobbed_gear(side: Any) -> CutFlank:
    """Formate gear by the closed form of its head position: both blades at the reference radius, a phase apart."""
    blank, spiral = hobbed_blank(HOBBED["blank"]), np.radians(HOBBED["printed"]["beta_m2"])
    nu, rc, mean = offset_angle(), HEAD["cutter_radius"] * MM, blank.mean_cone_distance
    horizontal, vertical = mean - rc * np.sin(spiral - nu), rc * np.cos(spiral - nu)
    machine = MachineSettings(
        radial_setting=float(np.hypot(horizontal, vertical)), cradle_angle=float(np.arctan2(vertical, horizontal)),
        machine_root_angle=blank.pitch_angle, roll_ratio=0.0, sliding_base=-blank.mean_dedendum,
        machine_centre_to_back=blank.pitch_apex_beyond_crossing, generation=FORMATE,
    )  # fmt: skip
    # half the slot to either side of the mean point
    tooth = HOBBED["printed"]["smn2"] * MM / (mean * np.sin(blank.pitch_angle) * np.cos(spiral))
    ahead = (0.5 if side == "concave" else -0.5) * (2.0 * np.pi / blank.teeth - tooth) * blank.teeth
    blade = Blade(rc, np.radians(HEAD[f"alpha_{side}"]), side, reference_height=blank.mean_dedendum, offset_angle=nu)
    blade = replace(blade, groups=HEAD["blade_groups"], phase=ahead / HEAD["blade_groups"])
    return CutFlank(blade, machine, blank, index_start(machine, blank))


def hobbed_pinion(side: Any, **changes: float) -> CutFlank:
    """Pinion flank by the one machine setting for both flanks, with other values of the blade."""
    machine = MachineSettings(
        **{
            name: value * MM if name in LENGTHS else value if name == "roll_ratio" else np.radians(value)
            for name, value in PINION["machine"].items()
        }
    )
    given, blank = PINION[side], hobbed_blank(PINION["blank"])
    blade = Blade(
        HEAD["cutter_radius"] * MM, np.radians(given["blade_angle"]), side,
        curvature=(1.0 / given["curvature_radius"] if "curvature_radius" in given else given["curvature"]) / MM,
        reference_height=blank.mean_dedendum, radius_offset=given["radius_offset"] * MM, groups=HEAD["blade_groups"],
        offset_angle=-offset_angle(),
    )  # fmt: skip
    return CutFlank(replace(blade, **changes), machine, blank, index_start(machine, blank))


def agma_gear(side: Any) -> CutFlank:
    """Gear flank of AGMA 929 C by classic starting settings, blades turned for the root cone."""
    i = AGMA["inputs"]
    blank = Blank(
        teeth=int(i["z2"]), pitch_angle=np.radians(i["delta2"]), mean_cone_distance=i["Rm"] * MM,
        face_width=i["b2"] * MM, mean_addendum=i["ham2"] * MM, mean_dedendum=i["hfm2"] * MM,
        addendum_angle=np.radians(2.1342), dedendum_angle=np.radians(i["theta_f2"]), hand="right",
    )  # fmt: skip
    spiral, radius, sign = np.radians(i["beta_m2"]), i["rc0"] * MM, 1.0 if side == "concave" else -1.0
    below = blank.dedendum_angle
    position = blank.mean_cone_distance * np.cos(below) - radius * np.sin(spiral), radius * np.cos(spiral)
    machine = MachineSettings(
        radial_setting=float(np.hypot(*position)),
        cradle_angle=float(np.arctan2(position[1], position[0])),
        machine_root_angle=blank.pitch_angle - below,
        roll_ratio=float(np.cos(below) / np.sin(blank.pitch_angle)),
        sliding_base=blank.mean_cone_distance * np.sin(below) - blank.mean_dedendum * np.cos(below),
    )
    angle = np.radians(i["alpha_cv1"]) - sign * below * np.sin(spiral)
    return CutFlank(Blade(radius + sign * 0.5 * AGMA["outputs"]["W_m2"] * MM, float(angle), side), machine, blank)
