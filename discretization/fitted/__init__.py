"""Contact lines as unknowns, a spectral mesh of the free surface anchored at each.

What lines feel of the free surfaces beside them is known in ../surfaces; tail.py has the surfaces
of an equilibrium in the scene's units.

One contact, where there can be no other: its lines by bracketing (lines.py, ../roots.py) ->
integrals (gauss.py, quadrature.py) -> rounding of heights (height_rounding.py), certificate and
error estimate -> Equilibrium, by state.py.

Any profile: where lines rest (rests.py) and where they come to rest (stops.py, resting.py) ->
states (clearance.py, tension.py, pressed.py, motion.py) -> energy and force (contacts.py),
certificate and error estimate (judgement.py) -> Equilibrium, by several.py; where γ₁ = 0 by
springs.py alone. Of "global", bubbles.py reads the contacts of a lattice.

Paths of any profile: energies up to a line (integrals.py), lines that follow the depth (smooth.py)
up to where (trials.py), and what happens to them there (events.py).
"""
