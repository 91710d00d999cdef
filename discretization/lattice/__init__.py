"""Contacts on fixed nodes: their energy is known (../nodes), its minimum is searched over sets.

A state is a tuple of contacts, the first and last node of each. They are found by plain.py (one
contact with finite slopes, or γ₁ = 0, by Newton's method: read it first), by lowest.py and
oracle.py (the lowest energy of all contact sets), or by walk.py (from first touch on, from change
to change; of load paths, too, ../paths/lattice_branch.py). Whoever finds them, state.py makes an
equilibrium of them: energy, force and certificate (certificate.py), lines between the nodes
(subgrid.py), and how accurate these are (accuracy.py).
"""
