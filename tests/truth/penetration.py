"""How far a state's free surface goes through the indenter, by dense sampling and refinement."""

import numpy as np

from .ground import Ground, refined_minima


def penetration(state, feature):
    """Largest g - u >= 0 [length] of an Equilibrium, from its u, contacts and profile."""
    ground = Ground(state.scene.indenter, feature)
    step, lines = ground.step, state.contacts.ravel()
    close = step * 0.5 ** np.arange(0.0, 30.0)
    near = [x + side * close for x in lines for side in (-1, 1)]
    x = np.unique(np.concatenate([ground.nodes, lines, *near]))
    x = x[(x >= ground.lo) & (x <= ground.hi)]

    def v(at):
        at = np.atleast_1d(np.asarray(at, float))
        inside = np.zeros(at.shape, bool)
        for left, right in state.contacts:
            inside |= (at >= left) & (at <= right)
        return np.where(inside, 0.0, state.displacement(at) - (state.depth - ground.height(at)))

    found = [value for _, value in refined_minima(v, x, v(x), 0.0)]
    return max(0.0, -min(found, default=0.0))
