"""What happens under a control without adhesion, where C rises with the depth and nothing jumps."""

import math

from .controls import CLOSE, Reading
from .depth_paths import Place


class Unique(Reading):
    """Without adhesion: C rises with the depth, and each value has one place."""

    def beyond(self, value, window):
        """Nothing jumps."""
        return []

    def go(self, value, guess=None):
        """To a value, by secants from a guess of the depth."""
        touch, self.value = self.path.touch, value
        self.step += 1
        if value < self.control.value(touch, 0.0):
            self.place = Place(value if self.control.stiffness else -math.inf)
            return self.place
        least = self.control.value(1.0, 0.0) + self.control.value(0.0, self.path.stiffness(None))
        low, high = touch, touch + (value - self.control.value(touch, 0.0)) / least
        depth = min(max(guess if guess is not None else (low + high) / 2, low), high)
        trials = [depth, touch] if depth > touch else [touch]
        return self._solved(value, trials, low, high, CLOSE * least * self.scale)

    def _solved(self, value, trials, low, high, least):
        """By secants, enclosed between low and high."""
        known = []
        for _ in range(100):
            depth = trials.pop(0) if trials else _secant(known, low, high)
            self.place = self.path.moved(None, depth)
            off = self.reached(self.place) - value
            if abs(off) <= least:
                return self.place
            low, high = (depth, high) if off < 0 else (low, depth)
            known.append((depth, off))
        raise RuntimeError(f"C does not reach {value!r}")


def _secant(known, low, high):
    """The next trial between two depths."""
    if len(known) < 2:
        return (low + high) / 2
    (x, p), (y, q) = sorted(known, key=lambda pair: abs(pair[1]))[:2]
    step = y - q * (y - x) / (q - p) if q != p else math.nan
    return step if low < step < high else (low + high) / 2


def reading_of(path, control, scale, finer=1.0):
    """How the path under a control is read off this one."""
    return (Reading if path.scene.opened.work_of_adhesion else Unique)(path, control, scale, finer)
