"""Contact lines as unknowns, a spectral mesh of the free surface anchored at each.

The depths at which lines rest beside the free surfaces of ../surfaces (rest_depths.py) and where
they come to rest (zeros.py, line_search.py) -> states (tension.py, pressed_surface.py,
contact_lines.py) -> energy and force, certificate and error estimate (contacts.py) -> Equilibrium,
by states.py, which reads the contacts of "global" off a lattice; where γ₁ = 0 by
../paths/springs.py alone. Where there can be only one contact its lines are bracketed at once
(single_contact.py). Paths: ../paths.
"""
