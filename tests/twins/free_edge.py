"""Local approach of a body next to a free side face against plane-strain finite elements (scikit-fem).

The increase of the approach of the load to the point at the depth h below, over the distance c of a Hertz load from the
side face: finite elements of the end of a strip of thickness 2 h, which represents the tip, toe and heel of a tooth.
Unit: load per length over Young's modulus.
"""

from itertools import pairwise
from typing import Any

import numpy as np
from skfem import Basis, ElementQuad2, ElementVector, FacetBasis, LinearForm, MeshQuad, condense, solve
from skfem.models.elasticity import lame_parameters, linear_elasticity

from ehl.common.arrays import FloatArray

# extent of the body in depths; elements across the load and how fast they grow away from it
SIZE, ACROSS, GROWTH = 30.0, 12, 0.25


def graded(points: tuple[float, ...], end: float, finest: float) -> FloatArray:
    """Grid lines from 0 to an end, finest at some points, all of which are grid lines."""
    stops = sorted({0.0, *points, end})
    lines = [np.zeros(1)]
    for low, high in pairwise(stops):
        places = [low]
        while places[-1] < high:
            away = min(abs(places[-1] - point) for point in points)
            places.append(places[-1] + finest + GROWTH * away)
        # shared out so that the last line is the stop
        share = (np.array(places[1:]) - low) / (places[-1] - low)
        lines.append(low + share * (high - low))
    return np.concatenate(lines)


def approach(distance: float, depth: float, half_width: float, poisson_ratio: float) -> float:
    """Approach of the centre of a Hertz load on the face y = 0 to the point under it, per w'/E [-].

    The strip lies at x > 0, 0 < y < 2 depth and is held far away. `distance` is that of the load from the side face
    x = 0.
    """
    far = SIZE * max(depth, distance)
    x = graded((distance,), far, 2.0 * half_width / ACROSS)
    y = graded((0.0, depth), 2.0 * depth, 2.0 * half_width / ACROSS)
    mesh = MeshQuad.init_tensor(x, y)
    element = ElementVector(ElementQuad2())
    basis = Basis(mesh, element, intorder=4)

    def hertz(v: Any, w: Any) -> Any:
        return np.sqrt(np.maximum(1.0 - ((w.x[0] - distance) / half_width) ** 2, 0.0)) * v[1]

    loaded = FacetBasis(mesh, element, facets=mesh.facets_satisfying(lambda p: np.abs(p[1]) < 1e-12 * depth))
    stiffness = linear_elasticity(*lame_parameters(1.0, poisson_ratio)).assemble(basis)
    force = LinearForm(hertz).assemble(loaded)
    downwards = basis.get_dofs(elements=True).all(["u^2"])
    held = basis.get_dofs(lambda p: np.abs(p[0] - x[-1]) < 1e-9 * far)
    moved = solve(*condense(stiffness, force, D=held)) / force[downwards].sum()
    places = np.array([[distance, distance], [0.0, depth]])
    top, under = np.asarray(basis.probes(places) @ moved).reshape(2, 2)[1]
    return float(top - under)
