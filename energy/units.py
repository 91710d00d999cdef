"""Units: as the headers of measured data write them, and with the prefix that suits a figure."""

import re
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
_SIZES = {symbol: 10.0**power for power, symbol in PREFIXES.items()}
_SIZES |= {"c": 1e-2, "u": 1e-6, "μ": 1e-6}
_NEWTON = f"([{''.join(_SIZES)}]?)N"
_METRE = "([kcmµuμnp]?)m"  # no Mm and Gm: whoever writes Mm means mm
KINDS = {
    "length": re.compile(_METRE),
    "force": re.compile(_NEWTON),
    "force per length": re.compile(f"{_NEWTON}/{_METRE}"),
    "voltage": re.compile("([mµuμn]?)V"),
}
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
    """The unit in m, N, N/m or V; None unless it is one of that kind of KINDS, such as "mN/m".

    Units may be written as words: "microns", "Micrometer", "nanonewtons".
    """
    unit = unit.strip()
    symbol = _SPELLED.get(unit.casefold().removesuffix("s"), unit)
    found = KINDS[kind].fullmatch(symbol)
    if found is None:
        return None
    first, *below = found.groups()
    return _SIZES[first] / (_SIZES[below[0]] if below else 1.0)


def named(cell: str) -> tuple[str, str]:
    """Name and unit of a column; unit "" if none.

    Whatever stands in brackets at the end is taken for the unit, as in "depth [µm]" and "depth
    (inch)", and a short word behind a slash, "depth/µm"; "depth in µm", "depth, µm", "depth_um" and
    "depth µm" only where that is a known unit.
    """
    text = " ".join(cell.split())
    loose = re.fullmatch(r"(.*?[^\s/])(?:\s+in\s+|\s*[,_]\s*|\s+)(\S+)", text)
    if loose and any_kind(loose[2]):
        return loose[1], loose[2]
    marked = re.fullmatch(r"(.+?)\s*[\[(]([^\[\]()]*)[\])]", text)
    marked = marked or re.fullmatch(r"([^/]+?)\s*/\s*(\S{1,6})", text)
    return (marked[1], marked[2].strip()) if marked else (text, "")


def any_kind(unit: str) -> bool:
    """Whether the text is a unit of one of the KINDS."""
    return any(size(unit, kind) is not None for kind in KINDS)


class Unit(NamedTuple):
    """A unit to draw in: value/size is the number, symbol what stands on the axis."""

    size: float
    symbol: str


def prefixed(values: ArrayLike, unit: str) -> Unit:
    """The prefix that puts the largest finite |value| into 1..1000; none if all are zero.

    `unit` is a plain SI unit ("m", "N/m"); the prefix applies to its first symbol. Numbers without
    a unit, "", have no prefix.
    """
    if not unit:
        return Unit(1.0, "")
    sizes = np.abs(np.asarray(values, float))
    largest = float(sizes[np.isfinite(sizes)].max(initial=0.0))
    exponent = 3 * int(np.floor(np.log10(largest) / 3 + 1e-9)) if largest else 0
    exponent = min(max(exponent, min(PREFIXES)), max(PREFIXES))
    return Unit(10.0**exponent, PREFIXES[exponent] + unit)


def quantity(value: float, unit: str) -> str:
    """A value with its unit, prefixed: "20 mN/m"."""
    size, symbol = prefixed(value, unit)
    return f"{value / size:.4g} {symbol}"
