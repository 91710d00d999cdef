"""Writes families.npz, the pieces of the families of free surfaces about an axis that are shipped.

    python -m discretization.surfaces.tables

from the top level of a clone, after a change of what the families are or how they are solved for.
It takes ten seconds. Nothing in the pieces depends on a scene or on units; solving for one where it
is needed costs .1 s, and a first load path with finite slopes needs a dozen.

`rings` and `menisci` have a `FAMILY` each: free surfaces with small slopes, and with finite ones.
`Family.shipped` has, by kind (1 outside the line, -1 inside; twice that for steep menisci), the
numbers of the pieces in the file; `fitted(kind, number)` solves for the coefficients of one, and
`key(kind)` is the name of a kind in the file. `TABLES` is the path of the file.
"""

import numpy as np

from discretization.surfaces import menisci, rings
from discretization.surfaces.network import TABLES, Family
from energy.arrays import Array

FAMILIES = (rings.FAMILY, menisci.FAMILY)


def pieces(family: Family) -> dict[str, Array]:
    """The Chebyshev coefficients that are shipped of a family, by its kinds.

    Parameters
    ----------
    family : Family

    Returns
    -------
    dict of ndarray (pieces, points, values)
        Under the names that they have in the file; dimensionless.
    """
    return {
        family.key(kind): np.stack([family.fitted(kind, number) for number in numbers])
        for kind, numbers in family.shipped.items()
    }


def main() -> None:
    """Write the file anew."""
    found: dict[str, Array] = {}
    for family in FAMILIES:
        found |= pieces(family)
    np.savez(TABLES, **found)  # type: ignore[arg-type]
    print(f"{TABLES}: {sum(part.shape[0] for part in found.values())} pieces")


if __name__ == "__main__":
    main()
