"""States followed along an imposed depth, load or position of a machine.

A branch (branch.py) is what is followed in depth: lattice_branch.py on nodes, fitted_branch.py, and
for several contacts fitted_many.py with the depths at which lines rest (line_levels.py, stops.py),
the moves between (fitted_moves.py, gap_moves.py) and the surfaces' clearance (clearance.py). Then:
equilibrium with a load or a machine (control.py) -> states and events in order (load_path.py,
events.py) -> History (history.py) and its ledger (ledger.py).
"""
