"""Contact lines as unknowns, a spectral mesh of the free surface anchored at each.

What lines feel of the free surfaces beside them is known in ../surfaces.

Where lines rest (rests.py) and where they come to rest (stops.py, resting.py) -> states
(tension.py, pressed.py, motion.py) -> energy and force, certificate and error estimate
(contacts.py) -> Equilibrium, by several.py, which reads the contacts of "global" off a lattice;
where γ₁ = 0 by ../paths/springs.py alone. Where there can be only one contact its lines are
bracketed at once (alone.py), and only what is next to them is judged (single.py). Paths of any
profile: ../following.
"""
