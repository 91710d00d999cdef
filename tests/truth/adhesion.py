"""What holds a contact line: the work of closing or opening, of the patch that it moves over."""

import numpy as np

ASIDE = 4e-15  # of the places: to which side of an edge


def breaks(scene):
    """Where the work of adhesion changes."""
    return () if scene.pattern is None else scene.pattern.edges


class Adhesion:
    """The deficit at which a line rests: √(2w/γ₁), with finite slopes 2 asin √(w/(2γ₁))."""

    def __init__(self, scene, ground):
        self.gamma1, self.finite = scene.gamma1, scene.slopes == "finite"
        self.works = {+1: scene.work_of_adhesion, -1: scene.opened.work_of_adhesion}
        self.pattern, self._aside = scene.pattern, ASIDE * max(abs(ground.lo), abs(ground.hi))

    def deficit(self, x, toward, way):
        """Of a line at x that would move to this side (±1), outwards (way = 1) or inwards (-1)."""
        w = self.works[way]
        if self.pattern is not None:
            w = w * self.pattern.factor(np.asarray(x, float) + self._aside * toward)
        half = np.sqrt(w / (2 * self.gamma1))
        return 2 * np.arcsin(half) if self.finite else 2 * half
