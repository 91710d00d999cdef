"""Units: as the headers of measured data write them, and with the prefix that suits a figure.

Sizes are in m, N, N/m or V: that of "mN/m" is 1e-3. KINDS are what a unit may measure.
"""

import re
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}  # by power of ten
_SIZES = {symbol: 10.0**power for power, symbol in PREFIXES.items()}
_SIZES |= {"c": 1e-2, "u": 1e-6, "μ": 1e-6}  # read, not written; the last is the Greek letter
_NEWTON = f"([{''.join(_SIZES)}]?)N"
_METRE = "([kcmµuμnp]?)m"  # no Mm and Gm: whoever writes Mm means mm
KINDS = {
    "length": re.compile(_METRE),
    "force": re.compile(_NEWTON),
    "force per length": re.compile(f"{_NEWTON}/{_METRE}"),
    "voltage": re.compile("([mµuμn]?)V"),
}
# Added to log₁₀(value)/3 before it is rounded down, so that 1000 is 1 k in spite of rounding: more
# than the logarithm is off by, 1e-15, and less than four digits of a value show.
_OF_A_THOUSAND = 1e-9
_SPELLED = {  # units as words, in the singular and in small letters
    "metre": "m",
    "meter": "m",
    "millimetre": "mm",
    "millimeter": "mm",
    "micrometre": "µm",
    "micrometer": "µm",
    "micron": "µm",
    "nanometre": "nm",
    "nanometer": "nm",
    "newton": "N",
    "millinewton": "mN",
    "micronewton": "µN",
    "nanonewton": "nN",
    "piconewton": "pN",
    "volt": "V",
    "millivolt": "mV",
}


def size(unit: str, kind: str) -> float | None:
    """The size of a unit in m, N, N/m or V.

    Parameters
    ----------
    unit : str
        Such as "mN/m" or "µm"; words are known, too: "microns", "Micrometer", "nanonewtons".
    kind : str
        One of `KINDS`.

    Returns
    -------
    float or None
        None if it is no unit of that kind.
    """
    unit = unit.strip()
    symbol = _SPELLED.get(unit.casefold().removesuffix("s"), unit)
    found = KINDS[kind].fullmatch(symbol)
    if found is None:
        return None
    prefix, *below = found.groups()  # that of "per length" has a prefix of its own
    denominator = _SIZES[below[0]] if below else 1.0
    return _SIZES[prefix] / denominator


def named(cell: str) -> tuple[str, str]:
    """Name and unit of a column from its header.

    Whatever stands in brackets at the end is taken for the unit, as in "depth [µm]" and "depth
    (inch)", and a short word behind a slash, "depth/µm"; "depth in µm", "depth, µm", "depth_um" and
    "depth µm" only where that is a known unit.

    Parameters
    ----------
    cell : str

    Returns
    -------
    name, unit : str
        The unit is "" if there is none.
    """
    text = " ".join(cell.split())
    loose = re.fullmatch(r"(.*?[^\s/])(?:\s+in\s+|\s*[,_]\s*|\s+)(\S+)", text)
    if loose and any_kind(loose[2]):
        return loose[1], loose[2]
    marked = re.fullmatch(r"(.+?)\s*[\[(]([^\[\]()]*)[\])]", text)
    marked = marked or re.fullmatch(r"([^/]+?)\s*/\s*(\S{1,6})", text)
    return (marked[1], marked[2].strip()) if marked else (text, "")


def any_kind(unit: str) -> bool:
    """Whether a text is a unit of one of the `KINDS`.

    Parameters
    ----------
    unit : str

    Returns
    -------
    bool
    """
    return any(size(unit, kind) is not None for kind in KINDS)


class Unit(NamedTuple):
    """A unit to draw in.

    Attributes
    ----------
    size : float
        By which values are divided.
    symbol : str
        What stands on the axis, with its prefix.
    """

    size: float
    symbol: str


def prefixed(values: ArrayLike, unit: str) -> Unit:
    """The unit with the prefix that puts the largest of some values into 1..1000.

    Parameters
    ----------
    values : array_like
        In the plain unit; those that are not finite do not count.
    unit : str
        A plain SI unit ("m", "N/m"), to whose first symbol the prefix applies; "" for numbers
        without a unit, which have no prefix.

    Returns
    -------
    Unit
        Without a prefix if all values are zero.
    """
    if not unit:
        return Unit(1.0, "")
    sizes = np.abs(np.asarray(values, float))
    largest = float(sizes[np.isfinite(sizes)].max(initial=0.0))
    thousands = np.log10(largest) / 3 if largest else 0.0  # powers of a thousand
    exponent = 3 * int(np.floor(thousands + _OF_A_THOUSAND))
    exponent = min(max(exponent, min(PREFIXES)), max(PREFIXES))
    return Unit(10.0**exponent, PREFIXES[exponent] + unit)


def quantity(value: float, unit: str) -> str:
    """A value with its unit and a prefix, "20 mN/m".

    Parameters
    ----------
    value : float
        In the plain unit.
    unit : str
        As in `prefixed`.

    Returns
    -------
    str
    """
    size, symbol = prefixed(value, unit)
    return f"{value / size:.4g} {symbol}"
