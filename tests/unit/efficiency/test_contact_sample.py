"""Which contacts stand for a mesh, and the spline through them."""

from typing import Any

import numpy as np
import pytest

from efficiency.loss import contact_sample as module
from efficiency.loss.contact_sample import LIGHT_SHARE, coordinates, nearest, predict, spread, worth_solving
from ehl.state import ContactState

ONE: dict[str, Any] = {
    "pressure_hertz": 1e9, "radius_equivalent": 0.01, "effective_modulus": 226e9, "speed_entrainment": 3.0,
}  # fmt: skip


def law(place: np.ndarray) -> np.ndarray:
    return np.asarray(np.sin(2.0 * place[:, 0]) + place[:, 1] ** 2)


def family(n: int, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    place = np.random.default_rng(seed).uniform(size=(n, 3))
    return place, np.vstack([law(place), np.full(n, 7.0)])


def test_planes_are_exact_and_smooth_functions_close() -> None:
    place, found = family(60)
    found[1] = 1.0 + place @ [0.5, 0.2, -0.1]
    other = 0.1 + 0.8 * family(40, 4)[0]  # among the contacts: beyond their range values are cut
    wanted = law(other)
    prediction = predict(other, place, found, np.ones(60))
    inside = np.clip(1.0 + other @ [0.5, 0.2, -0.1], found[1].min(), found[1].max())
    np.testing.assert_allclose(prediction.values[1], inside, atol=1e-9)
    np.testing.assert_allclose(prediction.weights.sum(axis=1), 1.0, atol=1e-9)
    rms = np.sqrt(np.mean((prediction.values[0] - wanted) ** 2))
    assert rms < 0.03 * np.ptp(wanted)
    assert rms < 1.5 * np.sqrt(np.mean(prediction.missed**2))


def test_scatter_is_smoothed() -> None:
    place, exact = family(80)
    noise = 0.3 * np.random.default_rng(5).standard_normal(80)
    other, wanted = family(200, 6)
    prediction = predict(other, place, exact + noise, np.ones(80))
    assert np.sqrt(np.mean((prediction.values[0] - wanted[0]) ** 2)) < 0.6 * 0.3
    # each is missed by its own scatter and a little more
    assert 0.25 < np.sqrt(np.mean(prediction.missed**2)) < 0.45


@pytest.mark.parametrize("scatter", [0.0, 0.3])
def test_a_contact_is_missed_by_as_much_as_without_it(scatter: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_SMOOTHING", (scatter,))
    place, found = family(40)
    prediction = predict(place, place, found, np.ones(40))
    for left_out in (0, 17, 39):
        others = np.arange(40) != left_out
        without = predict(place[[left_out]], place[others], found[:, others], np.ones(39))
        value = float((without.weights @ found[0, others])[0])
        assert prediction.missed[left_out] == pytest.approx(found[0, left_out] - value, abs=1e-9)


def test_contacts_in_a_plane_of_the_coordinates() -> None:
    place, _ = family(50)
    place[:, 2] = place[:, 0]
    found = (2.0 * place[:, 0] + place[:, 1])[None, :]
    prediction = predict(place, place, found, np.ones(len(place)))
    np.testing.assert_allclose(prediction.values, found, atol=1e-8)
    place, found = family(11)  # too few contacts
    assert predict(place, place, found, np.ones(len(place))) is None


def test_light_ends_of_lines_are_not_solved() -> None:
    n = 500
    pressure = np.concatenate([np.full(20, 2e7), np.full(n - 20, 1e9)])
    state = ContactState.of(**ONE | {"pressure_hertz": pressure}, slide_to_roll=np.linspace(-0.5, 0.5, n))
    power = state.load_per_length * state.speed_sliding
    kept = worth_solving(state, power)
    left = np.setdiff1d(np.arange(n), kept)
    assert set(range(20)) <= set(left)
    assert power[left].sum() <= LIGHT_SHARE * power.sum()
    # rolling points stay: they are loaded
    assert int(np.argmin(np.abs(state.slide_to_roll))) in kept
    assert worth_solving(state, np.zeros(n)).size == n


def test_points_that_are_spread() -> None:
    place, _ = family(300)
    chosen = spread(place, np.ones(300), 30)
    assert np.unique(chosen).size == 30
    gaps = np.sqrt(((place[chosen][:, None] - place[chosen][None]) ** 2).sum(axis=2)) + np.eye(30)
    covered = np.sqrt(((place[:, None] - place[chosen][None]) ** 2).sum(axis=2)).min(axis=1)
    assert gaps.min() >= covered.max() - 1e-12
    np.testing.assert_array_equal(nearest(place[chosen], place[chosen]), np.arange(30))
    assert spread(place[:1].repeat(5, axis=0), np.ones(5), 3).size == 1


def test_coordinates_know_the_texture() -> None:
    assert coordinates(ContactState.of(**ONE | {"pressure_hertz": np.full(4, 1e9)})).shape == (4, 1)
    for name, values in (("correlation_length", [3e-5, 6e-5]), ("peklenik_number", [1.0, 5.0])):
        place = coordinates(ContactState.of(**ONE, **{name: values}))
        np.testing.assert_array_equal(place[:, 0], [0.0, 1.0])
