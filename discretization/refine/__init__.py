"""Contacts found on nodes, their lines taken to rest by Newton's method.

Nodes (../lattice) give which contacts there are and in what order events come (lives.py). The lines
of all free surfaces are then taken to rest together (settle.py), and the depths of all events of a
route are found at once (events.py). What has the last word: landings are repeated on closer nodes
(landings.py), and between its own events the energy of every surface must balance (balance.py).

For line contacts with small slopes and γ₁ > 0 under a uniform work of adhesion of closing and of
opening. `minimise` calls states.py, which needs no events: contacts on nodes pressed to one depth
(pressed.py), where no event is near (steady.py). `load_path` calls ../paths/refined_branch.py.
"""
