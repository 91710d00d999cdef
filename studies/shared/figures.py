"""What all figures share: colours that colour-blind readers tell apart, and how they are saved.

BLUE, ORANGE, GREEN and GREY are these colours, SOFT and RIGID those of layer and indenter.
`canvas(width, height, rows, columns)` is a new figure of this size in inches, which lays itself
out, and its axes: one, or an array of them. All come from discretization.plots.
`replacing(path)` gives a file beside this one to write, which takes its place once it is whole.
"""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from discretization.plots import BLUE, GREEN, GREY, ORANGE
from discretization.plots import RIGID as RIGID
from discretization.plots import SOFT as SOFT
from discretization.plots import canvas as canvas
from energy.arrays import Array
from studies.shared.table import replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure
else:
    Figure = Any  # for annotations: matplotlib is imported when something is drawn

PURPLE, SKY, YELLOW, BLACK = "#CC79A7", "#56B4E9", "#E69F00", "#000000"  # Okabe-Ito, the rest
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, YELLOW, BLACK, GREY)
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
LINE: dict[str, Any] = {"color": BLACK, "lw": 1.2}  # of closed forms and laws
DPI = 140  # pixels an inch: a figure of 7 inches fills a page of 1000 pixels


def shades(count: int, name: str = "viridis", top: float = 0.9) -> list[str]:
    """So many colours from dark to light, which keep their order in greyscale.

    top: where the lightest is on the map; 0.7 for lines on white.
    """
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    return [to_hex(colour) for colour in colormaps[name](np.linspace(0, top, count))]


def plain_ticks(axis: Any, unit: str = "", steps: tuple[float, ...] = (1.0, 2.0, 5.0)) -> None:
    """Label a logarithmic axis at these steps of each decade: 0.2, 0.5, 1, or with a prefixed unit.

    The labels that matplotlib adds to a short axis, 2 × 10⁻¹ and so on, run into each other.
    """
    from matplotlib.ticker import EngFormatter, FuncFormatter, LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=steps))
    plain = FuncFormatter(lambda value, _: f"{value:g}")
    axis.set_major_formatter(EngFormatter(unit) if unit else plain)
    axis.set_minor_formatter(NullFormatter())


def edges(middles: Array) -> Array:
    """Edges (n + 1,) of cells around these middles (n,)."""
    if middles.size == 1:
        return np.asarray(middles[0] + np.array([-0.5, 0.5]))
    inner = (middles[1:] + middles[:-1]) / 2
    return np.concatenate([[2 * middles[0] - inner[0]], inner, [2 * middles[-1] - inner[-1]]])


def save(figure: Figure, path: Path, pdf: bool = True) -> list[Path]:
    """Write the figure as PNG and, if wanted, as PDF, without the time in it; the files written.

    Each is what one pass draws: `savefig` would draw everything twice to lay it out.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.image import imsave

    named = {"Title": title(figure)}
    image = BytesIO()
    figure.set_dpi(DPI)
    drawn = FigureCanvasAgg(figure)
    drawn.draw()
    imsave(image, drawn.buffer_rgba(), format="png", dpi=DPI, metadata=named)
    written = [_write(path.with_suffix(".png"), image)]
    if pdf:
        from matplotlib.backends.backend_pdf import FigureCanvasPdf

        image = BytesIO()
        figure.set_layout_engine("none")  # as just laid out
        FigureCanvasPdf(figure).print_pdf(image, metadata={"CreationDate": None, **named})
        written.append(_write(path.with_suffix(".pdf"), image))
    return written


def _write(path: Path, image: BytesIO) -> Path:
    """Write the content of a picture to a file; its path."""
    with replacing(path) as beside:
        beside.write_bytes(image.getbuffer())
    return path


def title(figure: Figure) -> str:
    """What a figure says above itself, or above the first of its panels; its caption elsewhere."""
    own = figure.get_suptitle() or (figure.axes[0].get_title() if figure.axes else "")
    return " ".join(str(own).split())
