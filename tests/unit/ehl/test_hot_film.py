"""Rounds of film and heat: mixing of the change of viscosity, carrying over to other grids."""

import copy

import numpy as np
import pytest
from contacts import BEARING_STEEL as STEEL
from contacts import hot_oil
from contacts import line_contact as contact

from ehl.contact import Contact
from ehl.smooth import hot_film
from ehl.smooth.hot_film import MEMORY, RELAXATION, Mixer
from ehl.smooth.newton import NewtonFailure, solve_level
from ehl.smooth.scaling import Offset
from ehl.smooth.thermal import solve_smooth

X = np.linspace(-2.0, 1.0, 31)
OIL = hot_oil()


def answer(used: np.ndarray) -> np.ndarray:
    """A heat balance that overshoots: a hotter film is heated less."""
    return -1.0 / (1.0 + X**2) - 0.9 * used + 0.3 * np.roll(used, 1)


def test_mixing_settles_where_plain_rounds_do_not():
    mixer, plain = Mixer(Offset.of(X, np.zeros_like(X))), np.zeros_like(X)
    first = answer(mixer.used.rows[0])
    for k in range(25):
        found = answer(mixer.used.rows[0])
        mixer.follow(Offset.of(X, found, np.array([0.1 * found, 0.3 * found])))
        plain = answer(plain)
        if k == 0:
            np.testing.assert_allclose(mixer.used.rows[0], RELAXATION * first)
        if k == 2:
            half, moved = copy.deepcopy(mixer), mixer.on_nodes(np.linspace(-2.0, 1.0, 61))
            half.halve()
            np.testing.assert_allclose(half.used.rows, 0.5 * (mixer._before[0] + mixer.used.rows))
            np.testing.assert_allclose(moved.used.rows[:, ::2], mixer.used.rows, atol=1e-15)
            np.testing.assert_allclose([s[1][:, ::2] for s in moved._secants], [s[1] for s in mixer._secants])
    np.testing.assert_allclose(answer(mixer.used.rows[0]), mixer.used.rows[0], atol=1e-8)
    np.testing.assert_allclose(mixer.used.rows[2], 0.3 * mixer.used.rows[0], atol=1e-8)
    assert np.abs(answer(plain) - plain).max() > 1e-2
    assert len(mixer._secants) == MEMORY - 1


@pytest.mark.parametrize("fails", [3, 40])
def test_a_film_that_cannot_follow_takes_shorter_steps_or_says_so(fails, monkeypatch):
    """Some films fail on the first grid: with shorter steps the same contact; where all do, a failure."""
    exact = solve_smooth(contact(), OIL, (STEEL, STEEL), thermal="on")
    calls = 0

    def stubborn(*arguments, **options):
        nonlocal calls
        calls += 1
        if 2 <= calls < 2 + fails:
            raise NewtonFailure("damping_exhausted", 1)
        return solve_level(*arguments, **options)

    monkeypatch.setattr(hot_film, "solve_level", stubborn)
    result = solve_smooth(contact(), OIL, (STEEL, STEEL), thermal="on")
    if fails == 3:
        assert result.status == "converged"
        assert result.friction_fluid == pytest.approx(exact.friction_fluid, rel=1e-4)
    else:
        assert (result.status, result.reason) == ("failed", "damping_exhausted")


def test_a_film_that_follows_no_further_counts_its_last_change(monkeypatch):
    calls = 0

    def stubborn(*arguments, **options):
        nonlocal calls
        calls += 1
        if calls > 5:
            raise NewtonFailure("damping_exhausted", 1)
        return solve_level(*arguments, **options)

    model, first = {}, hot_film.HotFilm.started
    monkeypatch.setattr(hot_film, "solve_level", stubborn)

    def started(self, cold, guess):
        self.tolerance = 1e-12  # never met
        first(self, cold, guess)
        model["change"], model["rounds"] = self.change, self.rounds
        raise NewtonFailure("stop", 0)

    monkeypatch.setattr(hot_film.HotFilm, "started", started)
    solve_smooth(contact(), OIL, (STEEL, STEEL), thermal="on")
    assert model["rounds"] >= 4
    assert 0.0 < max(model["change"]) <= hot_film.ACCEPTED_CHANGE


def test_an_old_matrix_leaves_no_flow_that_does_not_balance(monkeypatch):
    """A matrix of an earlier round sees too small a correction: a fresh one follows where the residual says so."""
    case = Contact(
        pressure_hertz=1.3e9, radius_equivalent=6.08e-3, effective_modulus=226e9, speed_entrainment=13.8,
        slide_to_roll=-1.26, speed_sliding_lengthwise=9.09, viscosity_inlet=0.04, pressure_viscosity=1.34e-8,
        eyring_stress=2.63e6, temperature_oil=350.0, temperature_viscosity=0.0439, limiting_shear_coefficient=0.102,
        thermal="on", accuracy="fast",
    )  # fmt: skip
    monkeypatch.setattr(hot_film, "EXTRAPOLATED", -1.0)  # a heat balance on every grid
    balanced = case.solve()
    monkeypatch.setattr(hot_film, "MASS_RESIDUAL", np.inf)
    left = case.solve()
    assert balanced.film is not None
    assert left.film is not None
    assert balanced.film.mass_residual <= 5e-4 < left.film.mass_residual
    assert left.friction_coefficient == pytest.approx(balanced.friction_coefficient, rel=1e-4)
