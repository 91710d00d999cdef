"""Contacts on fixed nodes: their energy is known (../nodes), its minimum is searched over sets.

A state is a tuple of contacts, the first and last node of each; one contact is no special case.
Whoever finds them, state.py makes an equilibrium of them: contacts on a row of nodes -> energy,
force and certificate (judge.py), and lines between the nodes (line.py, the same on load paths);
accuracy.py says how accurate these are.

They are found by plain.py (one contact with finite slopes, or γ₁ = 0, by Newton's method: read it
first), by lowest.py (the lowest energy of all contact sets, as oracle.py, and of rings about an
axis), or by walk.py (the end of a path from first touch on, from one change to the next; load paths
too, ../paths/lattice_branch.py).
"""
