"""Load capacity of a bevel or hypoid pair after ISO 10300:2023, Method B1: pitting and root strength of both flanks.

torque  ->  forces of the virtual gears  ->  K factors  ->  contact and root stress  ->  permissible stresses, safety

Formula numbers and values from public sources: the repository github.com/afuentesaz/AGMAStandards (ISO10300Calc). Its
self test against ISO/TR 10300-30:2024, samples 1 to 3, provides the values of the tests. The standard itself was not
available: this is not a certified calculation. Life factors of case-hardened steel and damage as in ISO 6336-2, -3 and
-6, unverified.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from efficiency.blanks import rating
from efficiency.blanks.rating import Pair, RatingInput
from ehl.common.arrays import FloatArray
from ehl.common.errors import InputError

if TYPE_CHECKING:
    from efficiency.blanks.pair_blank import PairBlank
    from efficiency.blanks.virtual_gears import VirtualGears

STRESS_CORRECTION = 2.0
"""Y_ST: root stress of the test gears over their nominal one."""
RZ_OF_RQ = 6.0 * math.sqrt(2.0 / math.pi)
"""Rz over Rq: Rz = 6 Ra, and Ra of Gaussian heights."""
# slip layer of case-hardened steel [mm]
_SLIP_LAYER = 0.0030
# range of endurance with variable constants of the lubricant film [MPa]
_LOW, _HIGH = 850.0, 1200.0


def _within(endurance: float) -> float:
    return min(max(endurance / 1e6, _LOW), _HIGH)


def lubricant_factor(endurance: float, viscosity_kinematic_40: float) -> float:
    """Z_L (54): contact endurance [Pa], kinematic viscosity at 40 degC [m2/s]."""
    low = 0.08 * (_within(endurance) - _LOW) / 350.0 + 0.83
    return low + 4.0 * (1.0 - low) / (1.2 + 134.0 / (1e6 * viscosity_kinematic_40)) ** 2


def speed_factor(endurance: float, speed: float) -> float:
    """Z_v (56): contact endurance [Pa], pitch line speed of the gear at the mean point [m/s]."""
    low = 0.08 * (_within(endurance) - _LOW) / 350.0 + 0.85
    return low + 2.0 * (1.0 - low) / math.sqrt(0.8 + 32.0 / speed)


def roughness_factor(endurance: float, mean_rz: float, radius: float) -> float:
    """Z_R (59): contact endurance [Pa], mean Rz of both flanks [m], radius of relative curvature [m].

    Surfaces smoother than the test gears have the value 1 (this work), because the formula has no upper limit and would
    give 1.3 for superfinished flanks.
    """
    relative = float(1e6 * mean_rz * (10.0 / (1e3 * radius)) ** (1.0 / 3.0))
    if relative <= 3.0:
        return 1.0
    return float((3.0 / relative) ** (0.12 + (1000.0 - _within(endurance)) / 5000.0))


def hypoid_factor(
    spiral_pinion: float, spiral_gear: float, generated_pressure_angle: float, effective_pressure_angle: float
) -> float:
    """Z_Hyp (12) to (19): sliding along the contact line over the sum of velocities across it; 1 without offset.

    Mean spiral angles, generated and effective pressure angle of the flank [rad]. The formula is for shaft angles at
    which the inclination of the contact line is that on the virtual gears; its range is 0.6 to 1.
    """
    cos_1, cos_2 = math.cos(spiral_pinion), math.cos(spiral_gear)
    lean = math.atan(math.tan(0.5 * (spiral_pinion + spiral_gear)) * math.sin(effective_pressure_angle))
    # velocities over that of the pinion at the mean point
    along = abs(cos_1 * (math.tan(spiral_pinion) - math.tan(spiral_gear))) * math.cos(abs(lean))
    profile = abs(2.0 * cos_1 * math.sin(generated_pressure_angle))
    lengthwise = abs(math.sin(spiral_pinion) + math.sin(spiral_gear) * cos_1 / cos_2)
    across = math.hypot(profile, lengthwise) * math.sin(math.atan2(profile, lengthwise) + abs(lean))
    return min(max(1.0 - 0.3 * (along / across - 0.15), 0.6), 1.0)


def surface_factor(root_rz: float) -> float:
    """Y_R,relT (40) of the root fillets, Rz [m] from 1 to 40 um."""
    return 1.674 - 0.529 * float((min(max(1e6 * root_rz, 1.0), 40.0) + 1.0) ** 0.1)


def notch_factor(notch: float) -> float:
    """Y_delta,relT (43) of the notch parameter: root thickness over twice the fillet radius [-]."""
    gradient = 0.2 * (1.0 + 2.0 * notch)
    return (1.0 + math.sqrt(_SLIP_LAYER * gradient)) / (1.0 + math.sqrt(_SLIP_LAYER * 1.2))


def size_factor(module: float) -> float:
    """Y_X (209) of the mean normal module [m]."""
    return min(max(1.05 - 10.0 * module, 0.80), 1.0)


# K_Hbeta-be by the verification of the contact pattern, with neither, one or both members cantilevered (Table 4)
_MOUNTING = {"full_load": (1.0, 1.0, 1.0), "light_load": (1.05, 1.10, 1.25), "sample": (1.20, 1.32, 1.50)}
_TRANSVERSE = {7: 1.1, 8: 1.2, 9: 1.4}  # K_Halpha-C of spiral teeth by accuracy grade; below 1 (Table 5)
_STEEL = 210e9, 0.3, 7860.0  # modulus [Pa], Poisson's ratio, density [kg/m3]
_STIFFNESS = 20e9, 14e9  # mesh and single stiffness of average teeth per face width [N/m2]
_AVERAGE_LOAD = 100e3  # load per face width below which teeth are softer [N/m]
# load cycles and life factors of case-hardened steel; pitting, root
PITTING_LIFE = (1e5, 5e7, 1e10), (1.6, 1.0, 0.85)
ROOT_LIFE = (1e3, 3e6, 1e10), (2.5, 1.0, 0.85)
BEVEL_FACTOR = 1.2
"""Z_K: bevel factor of the permissible contact stress."""


@dataclass(frozen=True)
class FlankRating:
    """Load capacity of one flank; pairs are (pinion, gear), stresses in Pa."""

    # F_vmt, F_n: tangential force of the virtual gears, normal force at the mean point [N]
    force_tangential: float
    force_normal: float
    # K_v, K_Hbeta, K_Halpha, K_Fbeta; K_Falpha = K_Halpha
    dynamic_factor: float
    face_load_factor: float
    transverse_load_factor: float
    face_load_factor_root: float
    # l_bm, Z_M-B, Z_LS, Z_E [sqrt(Pa)], Z_Hyp, Z_L Z_v Z_R
    contact_line: float
    mid_zone_factor: float
    load_sharing_factor: float
    elasticity_factor: float
    hypoid_factor: float
    film_factors: float
    # sigma_H0, sigma_H
    contact_stress_nominal: float
    contact_stress: float
    contact_stress_permissible: Pair  # sigma_HP
    safety_pitting: Pair  # S_H
    # Y_eps, Y_BS
    contact_ratio_factor: float
    spiral_angle_factor: float
    # Y_Fa, q_s, Y_Sa
    form_factor: Pair
    notch: Pair
    stress_correction: Pair
    # sigma_F0, sigma_F, sigma_FP
    root_stress_nominal: Pair
    root_stress: Pair
    root_stress_permissible: Pair
    safety_root: Pair  # S_F
    spectrum: rating.SpectrumRating | None  # None without a load spectrum


def rate_flank(pair: PairBlank | rating.RatedPair, inputs: RatingInput, side: rating.Side) -> FlankRating:
    """Load capacity of the flanks of one side at the torque of the inputs, and over their spectrum.

    The same torque is taken for both sides; for the coast side its direction is reversed.
    """
    flank = _Flank(pair, inputs, side)
    now = flank.at(inputs.torque, inputs.speed)
    contact_limit, root_limit = flank.contact_limit * np.ones(2), flank.root_limit
    if inputs.life is not None:
        cycles = rating.load_cycles(pair.ratio, inputs.speed, inputs.life)
        contact_limit = contact_limit * rating.life_factors(PITTING_LIFE, cycles)
        root_limit = root_limit * rating.life_factors(ROOT_LIFE, cycles)
    found = vars(flank) | vars(now)
    found |= {"contact_stress_permissible": contact_limit, "safety_pitting": contact_limit / now.contact_stress}
    found |= {"root_stress_permissible": root_limit, "safety_root": root_limit / now.root_stress}
    found["spectrum"] = rating.spectrum_rating((PITTING_LIFE, ROOT_LIFE), inputs.loads, pair.ratio, flank.used)
    own: dict[str, Any] = {f.name: found[f.name] for f in fields(FlankRating)}
    own |= {name: rating.as_pair(value) for name, value in own.items() if isinstance(value, np.ndarray)}
    return FlankRating(**own)


@dataclass(frozen=True)
class _Loaded:
    """Forces [N], factors and stresses [Pa] of one torque, named as in `FlankRating`."""

    force_tangential: float
    force_normal: float
    dynamic_factor: float
    transverse_load_factor: float
    contact_stress_nominal: float
    contact_stress: float
    root_stress_nominal: FloatArray
    root_stress: FloatArray


class _Flank:
    """Quantities of the rating of one flank that do not depend on the torque, and the stresses at a torque."""

    def __init__(self, pair: PairBlank | rating.RatedPair, inputs: RatingInput, side: rating.Side) -> None:
        self.pair, self.inputs = pair, inputs
        drive = side == "drive"
        self.virtual: VirtualGears = pair.virtual_drive if drive else pair.virtual_coast
        self.alpha_n = pair.pressure_angle_drive if drive else pair.pressure_angle_coast
        self.alpha_e = pair.effective_pressure_angle_drive if drive else pair.effective_pressure_angle_coast
        mounting = _MOUNTING[inputs.pattern_verified][rating.CANTILEVERED.index(inputs.cantilevered)]
        self.face_load_factor = 1.5 * mounting  # (28)
        self.curvature_factor = rating.curvature_factor(pair)
        self.face_load_factor_root = self.face_load_factor / self.curvature_factor
        self.contact_line = self._contact_line()
        self.mid_zone_factor = self._mid_zone_factor()
        self.elasticity_factor = math.sqrt(_STEEL[0] / (2.0 * math.pi * (1.0 - _STEEL[1] ** 2)))  # (51)
        spirals = pair.pinion.mean_spiral_angle, pair.gear.mean_spiral_angle
        self.hypoid_factor = hypoid_factor(*spirals, self.alpha_n, self.alpha_e)
        speed = 0.5 * inputs.speed / pair.ratio * pair.gear.mean_diameter
        self.film_factors = (
            lubricant_factor(inputs.contact_endurance, inputs.viscosity_kinematic_40)
            * speed_factor(inputs.contact_endurance, speed)
            * roughness_factor(inputs.contact_endurance, inputs.flank_rz, self.virtual.relative_radius)
        )
        self.contact_limit = inputs.contact_endurance * self.film_factors * BEVEL_FACTOR * self.hypoid_factor
        self.contact_ratio_factor, self.spiral_angle_factor = self._root_factors()
        edges = inputs.edge_radius_pinion, inputs.edge_radius_gear
        form = np.array([self._form(i, edge) for i, edge in enumerate(edges)])
        self.form_factor, self.notch, self.stress_correction = form.T
        allowed = inputs.bending_endurance * STRESS_CORRECTION * surface_factor(inputs.root_rz)
        self.root_limit = allowed * size_factor(pair.module_normal) * np.array([notch_factor(q) for q in self.notch])

    def at(self, torque: float, speed: float) -> _Loaded:
        """Stresses at a pinion torque [N m] and speed [rad/s]."""
        pair, virtual, inputs = self.pair, self.virtual, self.inputs
        tangent = 2.0 * torque / pair.pinion.mean_diameter / math.cos(pair.pinion.mean_spiral_angle)
        force = tangent * math.cos(virtual.helix_angle)
        normal = tangent / math.cos(self.alpha_n)
        width = virtual.effective_face_width
        soft = min(1.0, force * inputs.application_factor / width / _AVERAGE_LOAD)
        dynamic = inputs.dynamic_factor or self._dynamic_factor(force, speed, soft)
        transverse = self._transverse_factor(force * inputs.application_factor * dynamic * self.face_load_factor, soft)
        factors = inputs.application_factor * dynamic * transverse
        nominal = math.sqrt(normal / (self.contact_line * virtual.relative_radius))
        nominal = nominal * self.mid_zone_factor * self.load_sharing_factor * self.elasticity_factor
        level = force / (virtual.face_width * pair.module_normal)
        shared = self.contact_ratio_factor * self.spiral_angle_factor * self.load_sharing_factor**2
        root = level * shared * self.form_factor * self.stress_correction
        contact = nominal * math.sqrt(factors * self.face_load_factor)
        bent = root * factors * self.face_load_factor / self.curvature_factor
        return _Loaded(force, normal, dynamic, transverse, nominal, contact, root, bent)

    def used(self, torque: float, speed: float) -> tuple[FloatArray, FloatArray]:
        """Contact and root stress of both members over their limits."""
        now = self.at(torque, speed)
        return now.contact_stress / self.contact_limit * np.ones(2), now.root_stress / self.root_limit

    def _dynamic_factor(self, force: float, speed: float, soft: float) -> float:
        """K_v (8) to (25); Table 3 and the formula above resonance as in ISO 6336-1.

        The public source has other fractions in Table 3, which the printed K and K_v of the samples exclude.
        """
        pair, inputs = self.pair, self.inputs
        if inputs.pitch_deviation_gear is None:
            return rating.dynamic_factor(pair, speed, inputs.accuracy_grade)
        mean = math.cos(0.5 * (pair.pressure_angle_drive + pair.pressure_angle_coast))
        masses = [0.125 * _STEEL[2] * math.pi * (m.mean_diameter / mean) ** 2 for m in (pair.pinion, pair.gear)]
        reduced = masses[0] * masses[1] / sum(masses)
        ratio = speed * pair.pinion.teeth / math.sqrt(_STIFFNESS[0] * soft / reduced)  # N, to the resonance
        total = self.virtual.contact_ratio_total
        if total <= 2.0:
            c_12, c_3, c_4, c_56 = 0.66, 0.23, 0.90, 0.94
        else:
            c_12, c_3, c_56 = 0.32 + 0.57 / (total - 0.3), 0.096 / (total - 1.56), 0.47 + 0.12 / (total - 1.74)
            c_4 = (0.57 - 0.05 * total) / (total - 1.44)
        c_7 = 0.75 if total <= 1.5 else 1.0 if total > 2.5 else 0.125 * math.sin(math.pi * (total - 2.0)) + 0.875
        error = self._pitch_error() * _STIFFNESS[1] * soft * self.virtual.face_width
        error /= force * inputs.application_factor
        main, above = error * c_12 + c_4 + 1.0, error * c_56 + c_7
        if ratio <= 0.75:
            return ratio * (error * c_12 + c_3) + 1.0
        return float(np.interp(ratio, (1.25, 1.5), (main, above)))

    def _pitch_error(self) -> float:
        """Single pitch deviation of the gear minus its running-in allowance (51) [m]."""
        deviation = self.inputs.pitch_deviation_gear or 0.0
        return deviation - min(0.075 * deviation, 3e-6)

    def _transverse_factor(self, force: float, soft: float) -> float:
        """K_Halpha (40), (46) to (48); `force` with the other factors [N]."""
        total = self.virtual.contact_ratio_total
        if self.inputs.pitch_deviation_gear is None:
            found = _TRANSVERSE.get(self.inputs.accuracy_grade, 1.0)
        else:
            error = _STIFFNESS[0] * soft * self._pitch_error() * self.virtual.face_width / force
            if total <= 2.0:  # as in ISO 6336-1; in the public source the contact ratio multiplies only the error
                found = 0.5 * total * (0.9 + 0.4 * error)
            else:
                found = 0.9 + 0.4 * error * math.sqrt(2.0 * (total - 1.0) / total)
        offset = min(2.0 * abs(self.pair.hypoid_offset) / self.pair.gear.mean_diameter, 0.1)
        return max(found - (found - 1.0) * offset / 0.1, 1.0)

    def _contact_line(self) -> float:
        """Contact line in the middle, from those at tip, middle and root (A.26 to A.36); sets Z_LS (7 to 10).

        Lines end at the edges of the zone of action, 0 <= x <= b_v,eff; C_lb is the product of two roots. Both
        are undefined in the public source and confirmed by the three samples of the report.
        """
        pair, virtual = self.pair, self.virtual
        half_offset = 0.5 * pair.offset_angle_pitch_plane
        turn = math.atan(math.sin(pair.gear.pitch_angle) * math.tan(pair.offset_angle)) - half_offset
        tilt = math.tan(turn) / math.cos(virtual.transverse_pressure_angle)
        lean, width, path = math.tan(virtual.base_helix_angle), virtual.effective_face_width, virtual.path_of_contact
        cos_lean, sin_lean = math.cos(virtual.base_helix_angle), math.sin(virtual.base_helix_angle)
        pitch = virtual.base_pitch * cos_lean
        inside = max(1.0 - virtual.contact_ratio_overlap, 0.0)
        middle = -pitch * (1.0 - 0.5 * virtual.contact_ratio_profile) * inside
        places = middle + pitch, middle, middle - pitch
        most = 0.5 * (path + width * (tilt + lean)) * cos_lean
        narrow = 1.0 - math.sqrt(width / virtual.face_width)
        squares = [min((place / most) ** 2, 1.0) for place in places]
        slope, lines = max(tilt + lean, 1e-12), []
        for place, part in zip(places, squares, strict=True):
            height = place * cos_lean + lean * (place * sin_lean + 0.5 * width)
            ends = [(height + 0.5 * (sign * path + width * tilt)) / slope for sign in (1.0, -1.0)]
            upper, lower = (min(max(end, 0.0), width) for end in ends)
            lines.append((upper - lower) / cos_lean * (1.0 - math.sqrt(1.0 - part) * narrow))
        power = 1.5 if self.inputs.profile_crowning == "low" else 0.75
        areas = [(1.0 - part**power) * line for part, line in zip(squares, lines, strict=True)]
        self.load_sharing_factor = math.sqrt(areas[1] / sum(areas))
        return lines[1]

    def _mid_zone_factor(self) -> float:
        """Z_M-B (6)."""
        virtual = self.virtual
        profile, overlap = virtual.contact_ratio_profile, min(virtual.contact_ratio_overlap, 1.0)
        first = 2.0 + (profile - 2.0) * overlap
        parts = (first, 2.0 * profile - first)
        product = 1.0
        for part, tip, base, teeth in zip(
            parts, virtual.tip_diameter, virtual.base_diameter, virtual.teeth, strict=True
        ):
            product *= math.sqrt((tip / base) ** 2 - 1.0) - part * math.pi / teeth
        return math.tan(virtual.transverse_pressure_angle) / math.sqrt(product)

    def _root_factors(self) -> tuple[float, float]:
        """Y_eps (27) to (29) and Y_BS (30) to (35)."""
        virtual, pair = self.virtual, self.pair
        profile = 0.25 + 0.75 / virtual.contact_ratio_profile
        contact = profile - min(virtual.contact_ratio_overlap, 1.0) * (profile - 0.625)
        if virtual.helix_angle < 1e-9:
            return contact, 1.0
        tooth = virtual.face_width / math.cos(virtual.helix_angle)
        covered = self.contact_line * math.cos(virtual.base_helix_angle) / math.cos(virtual.helix_angle)
        x = 2.0 * tooth / (pair.pinion.mean_whole_depth + pair.gear.mean_whole_depth)
        a, b = -0.0182 * x * x + 0.4736 * x - 0.32, -0.0032 * x * x + 0.0526 * x + 0.712
        c = -0.0050 * x * x + 0.0850 * x + 0.54
        return contact, a / c * (covered / tooth - 1.05 * b) ** 2 + 1.0

    def _form(self, member: int, edge: float) -> tuple[float, float, float]:
        """Y_Fa, notch parameter q_s, Y_Sa of a generated tooth with the edge radius of its cutter (6) to (26)."""
        pair, virtual, alpha = self.pair, self.virtual, self.alpha_e
        module, teeth = pair.module_normal, virtual.normal_teeth[member]
        blank = (pair.pinion, pair.gear)[member]
        shift = pair.profile_shift * (1.0, -1.0)[member]
        depth, radius = pair.dedendum_factor, edge / module
        corner = math.pi / 4.0 - blank.thickness_coefficient - depth * math.tan(alpha)
        corner -= radius * (1.0 - math.sin(alpha)) / math.cos(alpha)  # E
        height = radius - depth + shift  # G
        start = 2.0 / teeth * (math.pi / 2.0 - corner) - math.pi / 3.0  # H
        angle = math.pi / 6.0
        for _ in range(100):
            angle = 2.0 * height / teeth * math.tan(angle) - start
        cos_angle = math.cos(angle)
        chord = teeth * math.sin(math.pi / 3.0 - angle) + math.sqrt(3.0) * (height / cos_angle - radius)
        fillet = radius + 2.0 * height**2 / (cos_angle * (teeth * cos_angle**2 - 2.0 * height))
        tip = teeth + 2.0 * blank.mean_addendum / module
        at_tip = math.acos(teeth * math.cos(alpha) / tip)
        half = (math.pi / 2.0 + 2.0 * (shift * math.tan(alpha) + blank.thickness_coefficient)) / teeth
        half += math.tan(alpha) - alpha - math.tan(at_tip) + at_tip
        load = at_tip - half
        arm = (math.cos(half) - math.sin(half) * math.tan(load)) * tip - teeth * math.cos(math.pi / 3.0 - angle)
        arm = 0.5 * (arm - height / cos_angle + radius)
        shape = 6.0 * arm * math.cos(load) / (chord**2 * math.cos(self.alpha_n))
        if min(chord, fillet, arm) <= 0.0:
            name = ("pinion", "gear")[member]
            where = f"rating.edge_radius_{name}"
            raise InputError(where, f"{1e3 * edge:.3g} mm", "an edge radius that leaves a root", "Take a smaller one.")
        slender, notch = chord / arm, 0.5 * chord / fillet
        return shape, notch, (1.2 + 0.13 * slender) * notch ** (1.0 / (1.21 + 2.3 / slender))
