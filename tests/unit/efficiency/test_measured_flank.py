"""Measured flanks: noise, transmission error, the smooth function behind the noise; corrections of the machine."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from refusals import refuses
from scipy.stats import multivariate_normal

from efficiency.contact import measured_flank as module
from efficiency.contact.conjugate import read_ease_off_map
from efficiency.contact.flank_pair import flank_pair
from efficiency.contact.grid_flank import PointGrid
from efficiency.contact.measured_flank import MeasuredFlank, Sizes, SmoothField, measured_flank, smooth_field
from efficiency.design.design import load_design
from efficiency.geometry.design_rating import rated_pair
from efficiency.machine_settings.conjugate import target_relief
from efficiency.machine_settings.correction import machine_corrections
from efficiency.machine_settings.inputs import FlankTarget
from efficiency.output.files import InspectionGrid, export_ease_off, inspection_grid, write_inspection_grid
from ehl.common.data import data_path
from ehl.common.errors import InputError
from ehl.common.validation import validate

BEVEL, HOBBED = "fm_spiral_bevel_14x39", "fh_hypoid_9x34_offset_10"
DESIGN = load_design(BEVEL)
GEAR = DESIGN.flanks().mating("drive")[1]
ARCSEC = np.pi / 648000.0


@pytest.fixture(scope="module")
def exact() -> InspectionGrid:
    return inspection_grid(GEAR, 9, 15, 0.04)


def points(grid: InspectionGrid, shift: NDArray[np.float64]) -> PointGrid:
    """The grid as an inspection machine gives it, each point moved along its normal."""
    row, column = np.meshgrid(np.arange(1, 10), np.arange(1, 16), indexing="ij")
    position = (grid.position + shift * grid.normal).reshape(3, -1)
    return PointGrid("measured.csv", row.ravel(), column.ravel(), position, None, "", "")


def measured(grid: PointGrid, uncertainty: float, nominal: bool = True) -> MeasuredFlank:
    return measured_flank(grid, GEAR.side, GEAR.blank, uncertainty, GEAR if nominal else None)


@pytest.mark.parametrize(("name", "lower"), [(BEVEL, 0.0), (HOBBED, 0.0), (HOBBED, 0.0002), (HOBBED, 0.005)])
def test_points_without_noise_give_the_transmission_error_of_the_flank(name: str, lower: float) -> None:
    """Pinions that are undercut near the root: the measured flank goes on beyond its points at tip, toe and heel."""
    design = load_design(name)
    flanks = design.flanks()
    own = flanks.mating("drive")[0]
    lowest = inspection_grid(own, 9, 15, 0.04).lowest - lower
    u, v = np.meshgrid(np.linspace(0.46, -0.46, 15) * own.blank.face_width, np.linspace(lowest, 0.96, 9))
    there, exists = own.solve(u.ravel(), own.blank.height(u, v).ravel())
    assert exists.all()
    number = np.arange(u.size)
    grid = PointGrid("measured.csv", number, number, there.position, None, "", "")
    flank = measured_flank(grid, own.side, own.blank, 1e-8, own)
    assert flank.error < 3e-6
    found = flank_pair(replace(flanks, pinion={**flanks.pinion, own.side: flank}), "drive").transmission
    truth = flank_pair(flanks, "drive").transmission
    assert found.peak_to_peak == pytest.approx(truth.peak_to_peak, abs=0.08 * ARCSEC)


@pytest.mark.parametrize(("member", "side"), [("pinion", "convex"), ("gear", "concave")])
def test_a_file_of_another_flank(mixed_ehl: Any, tmp_path: Path, member: str, side: str) -> None:
    own = getattr(DESIGN, member).flank(side)
    write_inspection_grid(tmp_path / "other.csv", DESIGN, member, side, inspection_grid(own, 9, 15, 0.04))  # type: ignore[arg-type]
    path = design_file(tmp_path, 'measurement_uncertainty = "1 um"\n')
    path.write_text(path.read_text(encoding="utf-8").replace("gear.csv", "other.csv"), encoding="utf-8")
    outcome = mixed_ehl("gear", path)
    assert (outcome.code, "gear.convex.grid" in outcome.err) == (2, True)


def test_noise_costs_less_than_three_tenths_of_an_arcsec(exact: InspectionGrid) -> None:
    flanks = DESIGN.flanks()
    truth = flank_pair(flanks, "drive").transmission.peak_to_peak
    rng = np.random.default_rng(11)
    errors, inside = [], 0
    for _ in range(6):
        flank = measured(points(exact, 1e-6 * rng.standard_normal(exact.u.shape)), 1e-6)
        found = flank_pair(replace(flanks, gear={**flanks.gear, GEAR.side: flank}), "drive").transmission
        errors.append(found.peak_to_peak - truth)
        inside += found.interval[0] <= truth <= found.interval[1]
    assert np.sqrt(np.mean(np.square(errors))) < 0.3 * ARCSEC
    assert inside >= 5


@pytest.mark.parametrize("nominal", [True, False])
def test_a_deviation_is_found_through_noise(exact: InspectionGrid, nominal: bool) -> None:
    x, y = 2.0 * exact.u / GEAR.blank.face_width, np.linspace(-1.0, 1.0, 9)[:, None]
    shape = 1e-6 * (20.0 * x - 12.0 * y + 8.0 * x**2 + 5.0 * x * y + 2.0 * np.sin(2.0 * x))
    noise = 1e-6 * np.random.default_rng(5).standard_normal(shape.shape)
    flank = measured(points(exact, shape + noise), 1e-6, nominal)
    there, found = flank.solve(exact.u.ravel(), exact.height.ravel())
    assert found.all()
    normal, position = exact.normal.reshape(3, -1), exact.position.reshape(3, -1)
    error = np.sum((there.position - position) * normal, axis=0) - shape.ravel()
    assert np.sqrt(np.mean(error**2)) < (0.4e-6 if nominal else 0.6e-6)
    assert np.abs(error).max() < max(flank.error, 1e-6) * 1.3


def test_scatter_beyond_the_stated_uncertainty_is_used(exact: InspectionGrid) -> None:
    noise = 3e-6 * np.random.default_rng(7).standard_normal(exact.u.shape)
    flank = measured(points(exact, noise), 0.5e-6)
    assert flank.scatter == pytest.approx(3e-6, rel=0.25)
    assert measured(points(exact, noise), 5e-6).scatter == pytest.approx(5e-6)


def test_points_of_another_flank_are_refused() -> None:
    other = DESIGN.flanks().of("gear")["concave" if GEAR.side == "convex" else "convex"]
    grid = points(inspection_grid(other, 9, 15, 0.04), np.zeros((9, 15)))
    with refuses("measured.csv, row 9, column 1"):
        measured(grid, 1e-6)


def design_file(folder: Path, more: str) -> Path:
    write_inspection_grid(folder / "gear.csv", DESIGN, "gear", GEAR.side, inspection_grid(GEAR, 9, 15, 0.04))
    text = data_path("designs", f"{BEVEL}.toml").read_text(encoding="utf-8")
    path = folder / "design.toml"
    path.write_text(text + f'\n[gear.{GEAR.side}]\ngrid = "gear.csv"\n{more}', encoding="utf-8")
    return path


def test_a_measured_gear_flank_keeps_the_cutter_of_the_design(tmp_path: Path) -> None:
    """The mean of the point radii of both flanks, of which one is that of the nominal flank."""
    design = load_design(design_file(tmp_path, 'measurement_uncertainty = "1 um"\n'))
    assert rated_pair(design).cutter_radius == pytest.approx(rated_pair(DESIGN).cutter_radius, rel=1e-12)


def test_a_design_with_measured_points_tells_the_interval(tmp_path: Path) -> None:
    pair = flank_pair(load_design(design_file(tmp_path, 'measurement_uncertainty = "1 um"\n')).flanks(), "drive")
    truth = flank_pair(DESIGN.flanks(), "drive").transmission.peak_to_peak
    assert isinstance(pair.surface.gear, MeasuredFlank)
    assert pair.transmission.peak_to_peak == pytest.approx(truth, abs=0.3 * ARCSEC)


X, Y = np.meshgrid(np.linspace(-0.92, 0.92, 15), np.linspace(-0.92, 0.92, 9))
PLACE = np.stack([X.ravel(), Y.ravel()])
# across the middle, where the teeth of a pair hand over
LINE = np.stack([np.linspace(-0.2, 0.2, 5), np.linspace(0.5, -0.5, 5)])


def bend(values: NDArray[np.float64]) -> float:
    """How much the middle of the line stands out: what the transmission error is made of."""
    return float(values[2] - 0.5 * (values[0] + values[4]))


def covariance(sizes: Sizes, noise: float, free: float) -> NDArray[np.float64]:
    x, y = PLACE
    found = noise**2 * np.eye(x.size)
    for term in (np.ones_like(x), x, y):
        found += free**2 * np.outer(term, term)
    for term in (x * x, x * y, y * y):
        found += sizes.second**2 * np.outer(term, term)
    across = (x[:, None] - x) / sizes.lengths[0], (y[:, None] - y) / sizes.lengths[1]
    return np.asarray(found + sizes.field**2 * np.exp(-0.5 * (across[0] ** 2 + across[1] ** 2)))


def test_likelihood_is_that_of_the_normal_distribution_with_wide_free_terms() -> None:
    rng = np.random.default_rng(2)
    values = 3.0 * X.ravel() + 0.5 * Y.ravel() ** 2 + rng.standard_normal(X.size)
    sets = Sizes(2.0, 0.4, (0.8, 1.6), 1.0), Sizes(0.3, 1.5, (0.8, 1.6), 1.0)
    expected = [multivariate_normal.logpdf(values, cov=covariance(each, 1.1, 1e3)) for each in sets]
    terms = np.stack([np.ones_like(X.ravel()), X.ravel(), Y.ravel()], axis=1)
    free = np.linalg.qr(terms, mode="complete")[0][:, 3:].T
    x, y = PLACE
    apart = ((x[:, None] - x) / 0.8) ** 2 + ((y[:, None] - y) / 1.6) ** 2
    variance, own = np.linalg.eigh(free @ np.exp(-0.5 * apart) @ free.T)
    seen = own.T @ free
    given = variance, seen @ values, seen @ np.stack([x * x, x * y, y * y], axis=1)
    found = [module._likelihood(*given, np.array([s.field]), np.array([s.second]), 1.1).item() for s in sets]
    assert found[1] - found[0] == pytest.approx(expected[1] - expected[0], abs=1e-4)


def test_mean_and_covariance_are_those_of_the_mixture() -> None:
    """Two sets: each by the plain formulas, what is between their means counts as spread."""
    rng = np.random.default_rng(3)
    values = rng.standard_normal(X.size)
    sets = Sizes(1.0, 0.5, (0.4, 0.8), 0.25), Sizes(0.1, 1.5, (1.6, 1.6), 0.75)
    field = SmoothField(PLACE, values, 1, 1.0, sets)
    means, within = [], np.zeros((3, 3))
    for each in sets:
        noisy, clean = covariance(each, 1.0, 1e3), covariance(each, 0.0, 1e3)
        known = np.linalg.solve(noisy, clean[:, :3]).T
        means.append(known @ values)
        within += each.weight * (clean[:3, :3] - known @ clean[:, :3])
    mean = 0.25 * means[0] + 0.75 * means[1]
    between = 0.25 * np.outer(means[0] - mean, means[0] - mean) + 0.75 * np.outer(means[1] - mean, means[1] - mean)
    np.testing.assert_allclose(field.mean(PLACE[:, :3]), mean, atol=1e-6)
    np.testing.assert_allclose(field.covariance(PLACE[:, :3]), within + between, atol=1e-6)


def test_stated_uncertainty_covers() -> None:
    """Waves of a third of the noise, or none: 95 % intervals hold, and that a wave may be there costs little."""
    rng, inside, errors = np.random.default_rng(4), 0, []
    for draw in range(40):
        tilt, size, phase = rng.standard_normal(2), 0.3 * rng.standard_normal(), rng.uniform(0.0, 6.0)
        size = size if draw < 20 else 0.0

        def true(place: NDArray[np.float64], tilt: NDArray[np.float64], size: float, phase: float) -> Any:
            return 5.0 * tilt @ place + size * np.sin(1.5 * np.pi * (place[0] + 0.3 * place[1]) + phase)

        field = smooth_field(PLACE, true(PLACE, tilt, size, phase) + rng.standard_normal(X.size), 1.0, 1)
        error = bend(field.mean(LINE)) - bend(true(LINE, tilt, size, phase))
        weights = np.array([-0.5, 0.0, 1.0, 0.0, -0.5])
        inside += abs(error) < 1.96 * np.sqrt(weights @ field.covariance(LINE) @ weights)
        if draw >= 20:
            errors.append(error)
    assert inside >= 36
    # least squares with free terms of second order: standard error of their bend from the normal equations
    terms = module._terms(PLACE, 0, 2)
    bent = np.array([bend(column) for column in module._terms(LINE, 0, 2).T])
    assert np.sqrt(np.mean(np.square(errors))) < 1.5 * np.sqrt(bent @ np.linalg.solve(terms.T @ terms, bent))


def grids(folder: Path, name: str, changes: dict[str, float], noise: float = 0.0, sides: str = "both") -> list[Path]:
    """Points of pinion flanks as a machine cuts them whose settings are off."""
    design, rng, files = load_design(name), np.random.default_rng(1), []
    for side in ("concave", "convex") if sides == "both" else (sides,):
        flank = design.flank("pinion", side)
        off = replace(flank.machine, **{key: getattr(flank.machine, key) + by for key, by in changes.items()})
        grid = inspection_grid(replace(flank, machine=off), 7, 11, 0.08)
        shift = noise * rng.standard_normal(grid.u.shape)
        files.append(folder / f"{side}.csv")
        grid = replace(grid, position=grid.position + shift * grid.normal)
        write_inspection_grid(files[-1], design, "pinion", side, grid)
    return files


@pytest.mark.parametrize("name", [BEVEL, HOBBED])
def test_settings_that_are_off_are_found(tmp_path: Path, name: str) -> None:
    changes = {"machine_root_angle": 3e-4, "radial_setting": 5e-5, "roll_ratio": 4e-4, "sliding_base": -2e-5}
    found = machine_corrections(name, grids(tmp_path, name, changes), "0.01 um")
    by_side = {(row.flank, row.part): row for row in found.deviations}
    for side in ("concave", "convex"):
        assert by_side[side, "measured"].deviation_rms > 2e-6
        assert by_side[side, "expected"].deviation_rms < 2e-9
        assert abs(by_side[side, "expected"].pressure_angle_error) < 1e-7
    completing = name == HOBBED
    assert {row.flanks for row in found.corrections} == ({"both"} if completing else {"concave", "convex"})
    if not completing:
        change = {row.setting: row for row in found.corrections if row.flanks == "concave"}
        for setting, by in changes.items():
            # deviations that the points resolve are found, each within its own uncertainty
            assert abs(change[setting].change + by) < 2.0 * change[setting].uncertainty
        assert abs(change["roll_ratio"].change + 4e-4) < 5e-5


def test_noise_leaves_its_own_size_and_the_angles(tmp_path: Path) -> None:
    files = grids(tmp_path, BEVEL, {"machine_root_angle": 4e-4, "blank_offset": 4e-5}, 1e-6)
    found = machine_corrections(BEVEL, files, 1e-6, 1)
    for row in found.deviations:
        if row.part == "expected":
            assert 0.7e-6 < row.deviation_rms < 1.2e-6
            assert abs(row.spiral_angle_error) < 2e-5
            assert abs(row.pressure_angle_error) < 3e-5
    assert "modified_roll_2c" not in {row.setting for row in found.corrections}


def test_dirt_inches_reversed_numbers_and_missing_points_change_nothing(tmp_path: Path) -> None:
    """A point 80 um off and two that were not measured; inch, decimal commas, rows counted from the tip."""
    changes = {"machine_root_angle": 3e-4, "radial_setting": 5e-5}
    files = grids(tmp_path, BEVEL, changes, 0.5e-6)
    clean = {(row.setting, row.flanks): row for row in machine_corrections(BEVEL, files, 1e-6).corrections}
    for file in files:
        text = file.read_text(encoding="utf-8").splitlines()
        head = text[0]
        names, *lines = [line for line in text if not line.startswith("#")]
        points = [[float(cell) for cell in line.split(",")] for line in lines]
        for k, point in enumerate(points):
            if k == 25:
                point[2:5] = list(np.array(point[2:5]) + 0.08 * np.array(point[5:8]))
            point[0] = 100 - point[0]
            point[2:5] = [x / 25.4 for x in point[2:5]]
        rows = [";".join(f"{cell:.12g}" for cell in point).replace(".", ",") for point in points]
        for k in (3, 44):
            rows[k] = ";".join([*rows[k].split(";")[:2], "Bad", "-999", "-999", "0", "0", "1"])
        new = "\r\n".join([head.replace("units=mm", "units=inch") + ";;;", names.replace(",", ";"), *rows])
        file.write_bytes(new.encode("utf-16"))
    found = machine_corrections(BEVEL, files, 1e-6)
    assert sum("omitted" in note for note in found.notes) == 2
    for row in found.corrections:
        assert abs(row.change - clean[row.setting, row.flanks].change) < row.uncertainty


WRONG = [({"uncertainty": "1 mm"}, 1, "pinion", "uncertainty"), ({}, 0, "pinion", "grids"), ({}, 2, "pinion", "grids")]
WRONG += [({}, 1, "gear", "row 1, column 11"), ({}, 1, "", "grids")]


@pytest.mark.parametrize(("given", "count", "member", "field"), WRONG)
def test_wrong_input_is_refused(tmp_path: Path, given: dict[str, Any], count: int, member: str, field: str) -> None:
    (file,) = grids(tmp_path, BEVEL, {}, sides="concave")
    file.write_text(file.read_text(encoding="utf-8").replace("member=pinion", f"member={member}", 1), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        machine_corrections(BEVEL, [file] * count, **given)
    assert caught.value.field.endswith(field)


def test_command(tmp_path: Path, mixed_ehl: Any) -> None:
    (file,) = grids(tmp_path, BEVEL, {"roll_ratio": 4e-4}, sides="concave")
    outcome = mixed_ehl("correct", BEVEL, file, "--json", "--order", "1", "-o", tmp_path / "new.toml")
    assert {row["part"] for row in json.loads(outcome.out)["deviations"]} == {"measured", "expected"}
    text = (tmp_path / "new.toml").read_text(encoding="utf-8")
    assert "[pinion.concave.machine]" in text
    assert "[pinion.convex.machine]" not in text


def test_a_map_of_ease_off_is_a_target(tmp_path: Path) -> None:
    assert len(export_ease_off(DESIGN, tmp_path)) == 2
    given = read_ease_off_map(tmp_path / "ease_off_drive.csv")
    assert given.error < 1e-8
    x, y = np.array([0.0, 0.5, -0.7]), np.array([0.0, -0.3, 0.6])
    target = FlankTarget(map=str(tmp_path / "ease_off_drive.csv"))
    expected = target_relief(FlankTarget(), x, y) + given(x, y)
    np.testing.assert_allclose(target_relief(target, x, y), expected, rtol=1e-12)
    with refuses("transmission_error"):
        validate(FlankTarget, {"map": str(tmp_path / "ease_off_drive.csv"), "transmission_error": "20 arcsec"})
