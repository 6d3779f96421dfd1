"""Two-part heads against a second algorithm, ISO 23509 and the one-part head; a pinion with one tooth."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from refusals import refuses

import efficiency
from efficiency.blanks.inputs import PairBlankInput
from efficiency.blanks.method_1 import lengthwise_radius
from efficiency.blanks.pair import pair_blank
from efficiency.blanks.tangency import PitchCones
from efficiency.contact.tooth_grid import normal_thickness, tooth_grid
from efficiency.cutting.cutter import FLANK_SIDES
from efficiency.design.design import Design, load_design
from efficiency.loss.closed_form import PitchGeometry, buckingham_type, lengthwise_sliding
from efficiency.ltca.ritz_solid import Orders
from efficiency.ltca.solid_tooth import solid_tooth_of
from efficiency.machine_settings.inputs import SettingsInput, load_targets
from efficiency.machine_settings.settings_result import SettingsResult
from efficiency.machine_settings.solve import machine_settings
from ehl.common.validation import validate

NAME = "tp_spiral_bevel_12x37_relieved"
STEP = 1e-30


def rotated(axis: int, angle: Any, point: np.ndarray) -> np.ndarray:
    """Points (3, n) rotated about a coordinate axis."""
    a, b = (axis + 1) % 3, (axis + 2) % 3
    out = [point[0], point[1], point[2]]
    out[a] = np.cos(angle) * point[a] - np.sin(angle) * point[b]
    out[b] = np.sin(angle) * point[a] + np.cos(angle) * point[b]
    return np.array([component + 0.0 * out[a] for component in out])


class HeadFlank:
    """One flank from the tables of a design file in SI units: no normals, no equation of meshing, no other code.

    The edge of a blade moves with the head, the cradle and the work; the swept points fill space except where the
    determinant of the map from (length along the edge, head angle, roll) to space vanishes: the envelope.
    """

    def __init__(self, flank: Mapping[str, Any], blank: Mapping[str, Any], side: str) -> None:
        self.m, self.c, self.b = flank["machine"], flank["cutter"], blank
        self.hand = 1.0 if blank["hand"] == "right" else -1.0
        self.out = 1.0 if side == "concave" else -1.0
        self.start = self._facing()

    def cone(self, u: np.ndarray, h: np.ndarray) -> np.ndarray:
        """Radius and height along the axis of points at (u, h) of the pitch cone."""
        d, along = self.b["pitch_angle"], self.b["mean_cone_distance"] + u
        apex = self.b["pitch_apex_beyond_crossing"]
        return np.array([along * np.sin(d) + h * np.cos(d), along * np.cos(d) - h * np.sin(d) - apex])

    def _facing(self) -> float:
        """Head angle at which a blade points to the mean point of the blank above the work axis."""
        m = self.m
        (radius, z), g = self.cone(np.zeros(1), np.zeros(1))[:, 0], m["machine_root_angle"]
        z += m["machine_centre_to_back"]
        point = np.array([np.sin(g) * radius + np.cos(g) * z, -m["blank_offset"], np.sin(g) * z - np.cos(g) * radius])
        point[2] += m["sliding_base"]
        point[:2] -= m["radial_setting"] * np.array([np.cos(m["cradle_angle"]), np.sin(m["cradle_angle"])])
        seen = rotated(1, -m["tilt"], rotated(2, -m["swivel"], point[:, None]))
        return float(np.arctan2(seen[1, 0], seen[0, 0]))

    def swept(self, x: np.ndarray) -> np.ndarray:
        """Points (3, n) in the work frame: x is length along the edge from its reference point, head angle, roll."""
        t, head, roll = x
        m, c = self.m, self.c
        angle, bend = c["blade_angle"], c["blade_curvature"]
        if bend:
            xi = (np.cos(angle) - np.cos(angle + bend * t)) / bend
            eta = (np.sin(angle + bend * t) - np.sin(angle)) / bend
        else:
            xi, eta = t * np.sin(angle), t * np.cos(angle)
        moved = self.out * c["eccentricity"]
        plane = self.hand * c["blade_offset_angle"]
        away = c["radius_offset"] + moved + self.out * xi
        edge = np.array([c["cutter_radius"] + away * np.cos(plane), away * np.sin(plane), -c["reference_height"] - eta])
        back = self.start + plane + self.hand * c["eccentricity_angle"]
        point = rotated(2, head, edge) - moved * np.array([[np.cos(back)], [np.sin(back)], [0.0]])
        point = rotated(2, m["swivel"], rotated(1, m["tilt"], point))
        q = m["cradle_angle"]
        point = point + m["radial_setting"] * np.array([[np.cos(q)], [np.sin(q)], [0.0]])
        point = rotated(2, roll, point)
        shifts = [m["sliding_base"]] + [m.get(f"helical_motion_{k}", 0.0) for k in (1, 2, 3)]
        base = shifts[0] + roll * (shifts[1] + roll * (shifts[2] / 2.0 + roll * shifts[3] / 6.0))
        x_m, y_m, z_m = point[0], point[1] + m["blank_offset"], point[2] - base
        g = m["machine_root_angle"]
        work = np.array(
            [np.sin(g) * x_m - np.cos(g) * z_m, y_m, np.cos(g) * x_m + np.sin(g) * z_m - m["machine_centre_to_back"]]
        )
        turned = roll - m.get("modified_roll_2c", 0.0) / 2.0 * roll**2 - m.get("modified_roll_6d", 0.0) / 6.0 * roll**3
        indexed = c["blade_groups"] / self.b["teeth"] * (head - self.start - self.hand * c["blade_phase"])
        return rotated(2, indexed - m["roll_ratio"] * turned, work)

    def _equations(self, x: np.ndarray, target: np.ndarray) -> np.ndarray:
        point = self.swept(x)
        columns = [np.imag(self.swept(x + 1j * STEP * np.eye(3)[k][:, None])) / STEP for k in range(3)]
        size = self.b["mean_cone_distance"]
        volume = np.einsum("in,in->n", columns[0], np.cross(columns[1], columns[2], axis=0)) / size**2
        return np.array([np.hypot(point[0], point[1]) - target[0], point[2] - target[1], volume]) / size

    def azimuth(self, target: np.ndarray) -> np.ndarray:
        """Azimuth of the flank at (radius, z), (2, n)."""
        x = np.array([[0.0], [self.start], [0.0]]) + np.zeros((3, target.shape[1]))
        steps = np.array([1e-6, 1e-5, 1e-5])
        for _ in range(40):
            value = self._equations(x, target)
            slope = [
                (self._equations(x + shift, target) - self._equations(x - shift, target)) / (2.0 * step)
                for step, shift in zip(steps, np.diag(steps)[:, :, None], strict=True)
            ]
            change = np.linalg.solve(np.stack(slope, axis=-1).transpose(1, 0, 2), value.T[..., None])[..., 0].T
            limit = np.minimum(1.0, np.array([[5e-3], [0.1], [0.1]]) / np.abs(change).clip(1e-300)).min(axis=0)
            x = x - limit * change
            if np.abs(change).max() < 1e-13:
                break
        point = self.swept(x)
        return np.arctan2(point[1], point[0])


def targets(blank: str, machine: str = "free_form", **ease_off: float) -> SettingsInput:
    """Shipped targets of a face-hobbed pair for the two-part head, both members generated."""
    content = load_targets(blank).model_dump(exclude_unset=True)
    content["blank"]["process"] = "two_part_face_hobbing"
    content["cutting"] = {"gear": "generated", "machine": machine}
    for side in ("drive", "coast"):
        content["targets"][side] |= ease_off
    return validate(SettingsInput, content)


@pytest.fixture(scope="module")
def hypoid() -> SettingsResult:
    return machine_settings(targets("fh_hypoid_9x34"), transmission=False)


@pytest.fixture(scope="module")
def pairs(hypoid: SettingsResult) -> dict[str, Design]:
    bevel = load_design(NAME)
    eccentric = bevel.model_dump()
    for member in ("pinion", "gear"):
        for side in FLANK_SIDES:
            eccentric[member][side]["cutter"] |= {"eccentricity": 2e-3, "eccentricity_angle": 0.1}
    return {"spiral bevel": bevel, "hypoid": hypoid.design, "both members eccentric": validate(Design, eccentric)}


@pytest.mark.parametrize("pair", ["spiral bevel", "hypoid", "both members eccentric"])
def test_flanks_are_the_envelope_of_the_swept_edge(pairs: dict[str, Design], pair: str) -> None:
    design = pairs[pair]
    share = [g.ravel() for g in np.meshgrid(np.linspace(-0.45, 0.45, 5), np.linspace(0.35, 0.95, 4))]
    for member in ("pinion", "gear"):
        content = getattr(design, member).model_dump()
        for side in FLANK_SIDES:
            flank, second = design.flank(member, side), HeadFlank(content[side], content["blank"], side)
            u = share[0] * flank.blank.face_width
            h = flank.blank.height(u, share[1])
            points, found = flank.solve(u, h)
            assert found.mean() > 0.9
            target = second.cone(u, h)[:, found]
            off = np.angle(np.exp(1j * (second.azimuth(target) - points.azimuth[found])))
            assert np.abs(off * target[0]).max() < 1e-12


def iso_curvature(eccentricity: float) -> float:
    """1/rho_mbeta of ISO 23509 [1/m] for blades moved out by an eccentricity: r cos nu grows by it, r sin nu stays."""
    design, inputs = load_design(NAME), load_targets(NAME).blank
    spiral, cone = pair_blank(inputs).gear.mean_spiral_angle, design.gear.blank.mean_cone_distance
    angle, lead = design.gear.blank.pitch_angle, design.gear.concave.cutter.blade_offset_angle
    cones = PitchCones((angle, angle), (cone, cone), (spiral, spiral))
    radius = math.hypot(inputs.cutter_radius * math.cos(lead) + eccentricity, inputs.cutter_radius * math.sin(lead))
    return 1.0 / lengthwise_radius(inputs.model_copy(update={"cutter_radius": radius}), cones)


@pytest.mark.parametrize("e", [1e-3, 5e-3])
def test_crowning_of_an_eccentricity_is_that_of_the_lengthwise_radii_of_iso_23509(e: float) -> None:
    """At the mean point the distance grows with half the difference of the curvatures."""
    gear, u = load_design(NAME).gear, np.linspace(-5e-3, 5e-3, 11)
    spiral = pair_blank(load_targets(NAME).blank).gear.mean_spiral_angle
    pressure = gear.concave.cutter.blade_angle
    for side, sign in (("concave", 1.0), ("convex", -1.0)):
        table = getattr(gear, side)
        cutters = (table.cutter.model_copy(update={"eccentricity": value}) for value in (0.0, e))
        flanks = (table.model_copy(update={"cutter": cutter}).flank(side, gear.blank) for cutter in cutters)
        one, other = (flank.solve(u, 0.0 * u)[0] for flank in flanks)
        distance = np.sum((other.position - one.position) * one.normal, axis=0)
        found = np.polynomial.Polynomial.fit(u, distance, 5).convert().coef
        bent = 0.5 * abs(iso_curvature(sign * e) - iso_curvature(0.0))
        # positive eccentricity removes material at the ends of both flanks
        assert found[2] == pytest.approx(-bent * math.cos(pressure) / math.cos(spiral) ** 2, rel=1e-5)
        assert abs(found[0]) < 1e-9
        assert abs(found[1]) < 1e-6


@pytest.mark.parametrize("pair", ["spiral bevel", "hypoid"])
def test_mean_thickness_is_that_of_the_blank(pairs: dict[str, Design], pair: str) -> None:
    inputs = load_targets(NAME if pair == "spiral bevel" else "fh_hypoid_9x34")
    wanted, flanks = pair_blank(inputs.blank.model_copy(update={"gear_cutting": "generated"})), pairs[pair].flanks()
    gear, pinion = (
        normal_thickness(flanks, member, np.array([-getattr(wanted, member).middle_shift]), np.zeros(1))[0]
        for member in ("gear", "pinion")
    )
    assert gear == pytest.approx(wanted.gear.mean_normal_thickness, rel=1e-6)
    # touching flanks against the fit on the whole of both; the ease-off thins the tooth at the pitch cone
    assert pinion == pytest.approx(wanted.pinion.mean_normal_thickness, abs=8e-6)


def test_hypoid_from_targets(hypoid: SettingsResult) -> None:
    assert hypoid.status == "converged"
    assert hypoid.rms < 1e-6
    assert max(np.abs(flank.fitted.root_error).max() for flank in hypoid.flanks) < 0.2e-3
    pinion = hypoid.design.pinion
    assert pinion.concave.machine == pinion.convex.machine
    for side in FLANK_SIDES:
        assert 0.5e-3 < getattr(pinion, side).cutter.eccentricity < 5e-3
        assert getattr(hypoid.design.gear, side).cutter.eccentricity == 0.0


def test_gear_and_pinion_share_the_eccentricity() -> None:
    plain, sums, found = targets("fh_hypoid_9x34_offset_10", "cradle"), [], []
    for value in (0.0, 1e-3):
        cutting = plain.cutting.model_copy(update={"gear_eccentricity": value})
        result = machine_settings(plain.model_copy(update={"cutting": cutting}), transmission=False)
        assert result.rms < 1.5e-6
        assert result.design.gear.concave.cutter.eccentricity == pytest.approx(value)
        found.append(result.design.pinion.concave.cutter.eccentricity)
        sums.append(found[-1] + result.design.gear.convex.cutter.eccentricity)
    assert found[1] < 0.7 * found[0]
    assert sums[1] == pytest.approx(sums[0], rel=0.05)


@pytest.mark.parametrize(("process", "value"), [("face_hobbing", 1e-3), ("two_part_face_hobbing", 16e-3)])
def test_gear_eccentricity_is_checked(process: str, value: float) -> None:
    content = targets("fh_hypoid_9x34").model_dump(exclude_unset=True)
    content["blank"]["process"] = process
    content["cutting"]["gear_eccentricity"] = value
    with refuses("cutting.gear_eccentricity"):
        validate(SettingsInput, content)


def test_crowning_beyond_the_head_is_refused() -> None:
    with refuses("eccentricity"):
        machine_settings(targets("fh_spiral_bevel_12x37", crowning_toe=1e-3, crowning_heel=1e-3), transmission=False)


@pytest.mark.parametrize("value", [None, -6e-3, 16e-3, 0.1, float("nan")])
def test_invalid_eccentricities_are_refused(value: float | None) -> None:
    content = load_design(NAME).model_dump()
    cutter = content["pinion"]["concave"]["cutter"]
    cutter["eccentricity"] = value
    if value is None:
        del cutter["eccentricity"]
    with refuses("pinion.concave.cutter.eccentricity"):
        validate(Design, content)


EASE_OFF = {"crowning_toe": "10 um", "crowning_heel": "10 um", "relief_root": "4 um", "relief_tip": "4 um"}
BLANK = {
    "name": "1x60", "method": 1, "process": "face_milling", "teeth_pinion": 1, "teeth_gear": 60,
    "hypoid_offset": "30 mm", "outer_pitch_diameter_gear": "150 mm", "face_width_gear": "12 mm",
    "mean_spiral_angle_pinion": "75 deg", "cutter_radius": "60 mm", "depth": {
        "data_type": "I", "profile_shift": 0.65, "addendum_factor": 0.85, "dedendum_factor": 1.1,
        "thickness_modification": 0.06,
    },
}  # fmt: skip
MEMBER = {"material": "steel", "finish": "ground"}


@pytest.fixture(scope="module")
def design() -> Design:
    content = {
        "name": "1x60", "blank": BLANK, "cutting": {"gear": "formate", "pinion": "each_flank"},
        "targets": {"drive": EASE_OFF, "coast": EASE_OFF}, "pinion": MEMBER, "gear": MEMBER,
        "operation": {"torque": "5 N m", "speed": "1500 rpm", "temperature": "60 degC", "oil": "75w90"},
    }  # fmt: skip
    made = efficiency.settings(validate(SettingsInput, content))
    assert made.status == "converged"
    # as much as the ease-off makes, 4 um over the depth: no other turn of the thread takes part
    assert made.concave.transmission.edges == ()
    assert made.concave.transmission.peak_to_peak == pytest.approx(6.36 / 206265.0, rel=0.02)
    return made.design


def test_a_pinion_with_one_tooth_runs(design: Design) -> None:
    assert tooth_grid(design.flanks(), "pinion", 7, 7).winding > 6.0 * np.pi
    pair = efficiency.GearPair(design)
    result = pair.at("constant:0.05", grid=(6, 15))
    assert result.status == "converged"
    assert 1e9 < result.pressure_hertz_max < 3e9
    # the lengthwise sliding of the pitch point, and profile sliding on top of it
    made = efficiency.blank(validate(PairBlankInput, BLANK))
    pinion, gear = made.pinion, made.gear
    angles = (pinion.mean_spiral_angle, gear.mean_spiral_angle), (pinion.pitch_angle, gear.pitch_angle)
    sizes = (0.5 * pinion.mean_diameter, 0.5 * gear.mean_diameter), made.module_normal
    pitch = PitchGeometry(made.pressure_angle_drive, *angles, *sizes, made.virtual_drive.contact_ratio_profile)
    assert result.efficiency < lengthwise_sliding(pitch, 0.05)
    assert result.efficiency == pytest.approx(buckingham_type(pitch, 0.05), abs=0.03)


def test_the_next_tooth_of_a_ring_of_one_is_the_loaded_one(design: Design) -> None:
    body = design.pinion.tooth_body()
    tooth = solid_tooth_of(design.flanks(), body, "pinion", "drive", Orders((4, 5, 10), (4, 4, 8)))
    # far from the load, where no local deformation is subtracted
    assert tooth.ahead[0][0, -1] == pytest.approx(tooth.own[0, -1], rel=0.05, abs=1e-3 * np.abs(tooth.own).max())
