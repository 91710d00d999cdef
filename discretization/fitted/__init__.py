"""Contact lines as unknowns, a spectral mesh of the free surface anchored at each.

One contact of a convex profile: free surface (spectral.py, free_surface.py) -> what a line feels of
it (response.py) -> contact lines (lines.py, roots.py) -> integrals (gauss.py, quadrature.py) ->
rounding of heights (height_rounding.py), certificate and error estimate -> Equilibrium, by
state.py. The surfaces that it keeps, in the scene's units: tail.py.

Any profile: free surfaces and the depth D at which a line rests beside them (surfaces.py; with
small slopes small_surfaces.py on gap.py, with finite ones finite_surfaces.py on finite_range.py and
finite_gap.py) -> resting places (stops.py, resting.py, drives.py) -> states (clearance.py,
tension.py, pressed.py, motion.py; springs.py where γ₁ = 0) -> energy and force (contacts.py),
certificate and error estimate (judgement.py) -> Equilibrium, by several.py. Of "global", bubbles.py
reads the contacts of a lattice.

Paths of any profile: energies up to a line (integrals.py), lines that follow the depth (smooth.py),
and what happens to them on the way (events.py).
"""
