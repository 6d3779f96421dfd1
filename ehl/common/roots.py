"""Root of a function of one variable, without the import of `scipy.optimize`, which takes longer than most uses."""

from collections.abc import Callable

_ROUNDS = 200


def bracketed_root(
    function: Callable[[float], float], low: tuple[float, float], high: tuple[float, float], tolerance: float = 0.0
) -> float:
    """Root between two places with values of opposite signs, by the method of Chandrupatla.

    Inverse quadratic interpolation where it is certain to converge, else bisection (T. R. Chandrupatla, Advances in
    Engineering Software 28, 1997).

    low, high: both places with the values there.
    tolerance: of the root, absolute, in addition to four units of its last digit.
    """
    (b, fb), (a, fa) = low, high
    c, fc, share = b, fb, fa / (fa - fb)
    for _ in range(_ROUNDS):
        best, value = (a, fa) if abs(fa) < abs(fb) else (b, fb)
        least = 2.0 * (4.5e-16 * abs(best) + 0.25 * tolerance) / max(abs(b - a), 1e-300)
        if least > 0.5 or value == 0.0:
            return best
        at = a + min(max(share, least), 1.0 - least) * (b - a)
        found = function(at)
        if (found > 0.0) == (fa > 0.0):
            c, fc = a, fa
        else:
            c, fc, b, fb = b, fb, a, fa
        a, fa = at, found
        place, height = (a - b) / (c - b), (fa - fb) / (fc - fb)
        if height**2 < place and (1.0 - height) ** 2 < 1.0 - place:
            share = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        else:
            share = 0.5
    return best
