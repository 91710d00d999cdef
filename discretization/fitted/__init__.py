"""Contact lines as unknowns, a spectral mesh of the free surface anchored at each.

One contact: free surface (spectral.py, free_surface.py) -> what a line feels of it (response.py) ->
contact lines (lines.py, roots.py) -> integrals (gauss.py, quadrature.py) -> rounding of heights
(height_rounding.py), certificate and error estimate -> Equilibrium, by state.py. The surfaces that
it keeps, in the scene's units: tail.py.

Several contacts: contact nodes of the lattice without small gaps (bubbles.py) -> surfaces between
(gap.py, with finite slopes finite_range.py and finite_gap.py) -> lines (gap_lines.py, contacts.py)
-> certificate and error estimate (judgement.py) -> Equilibrium, by several.py.
"""
