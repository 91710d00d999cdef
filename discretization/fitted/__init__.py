"""Contact lines as unknowns, a spectral mesh of the free surface anchored at each.

What lines feel of the free surfaces beside them is known in ../surfaces.

One contact, where there can be no other: its lines by bracketing
(alone.py, ../roots.py) -> integrals (../quadrature.py), certificate and error estimate ->
Equilibrium, by single.py.

Any profile: where lines rest (rests.py) and where they come to rest (stops.py, resting.py) ->
states (tension.py, pressed.py, motion.py) -> energy and force (contacts.py), certificate and error
estimate (judgement.py) -> Equilibrium, by several.py, which reads the contacts of "global" off a
lattice; where γ₁ = 0 by springs.py alone. Paths of any profile: ../following.
"""
