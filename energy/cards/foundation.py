"""The thin layer as a foundation of independent springs, Eqs. (2)-(3).

Imported: `Values` is a float for numbers, an array for arrays. `refuse(name, value, bad, remedy)`
raises ValueError where `bad` is true. `finite` and `positive` check an argument, whose name comes
first, and return it as float64.
"""

from numpy.typing import ArrayLike

from energy.cards._checks import finite, positive, refuse
from energy.cards._types import Values


def modulus(E: ArrayLike, nu: ArrayLike) -> Values:
    """Modulus of uniaxial compression of a thin layer.

    Ẽ = E (1 − ν) / ((1 + ν)(1 − 2ν)), Eq. (2).

    Valid for d ≪ h ≪ a.

    Parameters
    ----------
    E, nu : array_like
        Young's modulus [Pa] and Poisson's ratio.

    Returns
    -------
    float or ndarray
        Ẽ [Pa].

    Raises
    ------
    ValueError
        For E <= 0 or ν outside (−1, 1/2).
    """
    E = positive("E", E)
    nu = finite("nu", nu)
    bad = (nu <= -1.0) | (nu >= 0.5)
    refuse("nu", nu, bad, "must lie in (-1, 1/2): an incompressible thin layer has no finite Ẽ")
    return E * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))


def stiffness(E: ArrayLike, nu: ArrayLike, h: ArrayLike) -> Values:
    """Stiffness of a thin layer per area.

    k = Ẽ / h, Eq. (3) per unit area.

    Parameters
    ----------
    E, nu, h : array_like
        Young's modulus [Pa], Poisson's ratio and thickness of the layer [m].

    Returns
    -------
    float or ndarray
        k [N/m³].

    Raises
    ------
    ValueError
        For E <= 0, h <= 0 or ν outside (−1, 1/2).
    """
    return modulus(E, nu) / positive("h", h)
