"""Contacts on fixed nodes: their energy is known (../nodes), its minimum is searched over sets.

A state is a tuple of contacts, the first and last node of each; one contact is no special case.
Whoever finds them, assembly.py makes an equilibrium of them: contacts on a row of nodes
(contact_set.py) -> energy, force and certificate in one pass over blocks of nodes (judge.py), lines
between the nodes (line.py), and how accurate these are (accuracy.py).

They are found by state.py, which asks one of
    plain.py         one contact with finite slopes, or γ₁ = 0, by Newton's method: read it first
                     (with its certificate and free surface: plain_state.py)
    lowest.py        lowest energy of all contact sets; oracle.py the same; rings.py around an axis,
                     where only the fitted mesh asks
    ../nodes/row.py  one convex contact: lines are looked for among links ever further apart
    walk.py          the end of a path from first touch on, from one change to the next, with lines
                     between the nodes (between.py); load paths (../paths/lattice_branch.py) too
"""
