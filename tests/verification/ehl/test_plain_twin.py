"""The rough engine against the plain dense solver of tests/twins/plain_twin.py: another algorithm, the same physics."""

import pytest
from twins.plain_twin import PlainTwin, roll
from twins.rough_scenes import Scene, eyring_oil, gaussian_pair, line, speed_of_film_ratio

from ehl.rough._kernels.march import FILM_MEAN
from ehl.rough.averaging import Window

RMS = 0.4e-6
STARTUP = 3.4


@pytest.mark.parametrize(("ratio", "per_width", "touches"), [(1.0, 38.0, False), (0.3, 30.0, True)])
def test_engine_and_plain_solver_agree_on_rough_surfaces(ratio: float, per_width: float, touches: bool) -> None:
    oil = eyring_oil()
    contact = line(speed_of_film_ratio(ratio, RMS, oil))
    scene = Scene(contact, oil, gaussian_pair(contact, RMS, 0.2))
    window = Window(scene.run(per_width))
    window.start(STARTUP)
    window.roll(2.0)
    units = window.run.problem.units
    twin = PlainTwin(contact, oil, scene.surfaces, round(per_width * scene._length()), scene.boundary_film)
    mu, film = roll(twin, STARTUP, 2.0)
    assert twin.failures == 0
    assert twin.x.size == window.run.problem.x.size
    assert mu == pytest.approx(window.interval()[0], rel=1e-3)
    assert film == pytest.approx(float(window.records[:, FILM_MEAN].mean()) * units.film, rel=1e-3)
    if touches:
        assert twin.c.sum() > 0.0
