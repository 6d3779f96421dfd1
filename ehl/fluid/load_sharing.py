"""Load sharing: a first mixed friction from the film ratio, until the deterministic solver is asked for.

A published function of lambda says which share of the load the asperities carry; that share rubs at mu_b, the rest
at the friction of the smooth film. The shares of different authors differ by up to a factor of two at the same
lambda, and by definition: the film is smooth and isothermal here, and roughness is the composite Rq.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehl.common.errors import InputError

Array = NDArray[np.float64]


def arana_2019(film_ratio: ArrayLike) -> Array:
    """Asperity load share 1 - erf(lambda); found (Arana, Larranaga & Ulacia 2019)."""
    from scipy.special import erfc

    return np.asarray(erfc(np.asarray(film_ratio, dtype=float)))


def doleschel_2002(film_ratio: ArrayLike) -> Array:
    """Asperity load share (1 - lambda/2)^2 for lambda <= 2, else 0; found (Doleschel).

    Doleschel's lambda uses the mean Ra of both surfaces; the load-sharing model takes it with the composite Rq.
    """
    return np.asarray(np.square(1.0 - 0.5 * np.clip(np.asarray(film_ratio, dtype=float), 0.0, 2.0)))


LOAD_SHARES: dict[str, Callable[[ArrayLike], Array]] = {
    "arana_2019": arana_2019,
    "doleschel_2002": doleschel_2002,
}


@dataclass(frozen=True)
class LoadSharing:
    """Friction of a rough contact by load sharing; the two parts add up to the whole."""

    asperity_load_share: float
    friction_fluid: float
    friction_asperity: float


def load_sharing(
    film_ratio: float, friction_smooth: float, boundary_friction: float, model: str, scale: float = 1.0
) -> LoadSharing:
    """Share the load between asperities and film.

    Parameters
    ----------
    film_ratio : float
        lambda = smooth isothermal film_central/Rq [-]; infinity for smooth surfaces.
    friction_smooth : float
        Friction coefficient of the smooth film [-].
    boundary_friction : float
        mu_b of the asperity contacts [-].
    model : str
        A key of `LOAD_SHARES`.
    scale : float
        The share is read at `scale` times the film ratio [-]; 1 is the published law, others come from calibration.
    """
    if model not in LOAD_SHARES:
        raise InputError("model.load_sharing", model, "one of " + ", ".join(sorted(LOAD_SHARES)))
    share = float(LOAD_SHARES[model](scale * film_ratio)) if math.isfinite(film_ratio) else 0.0
    return LoadSharing(share, (1.0 - share) * friction_smooth, share * boundary_friction)
