"""States followed along an imposed depth, load or position of a machine.

A branch (branch.py) is what is followed in depth: lattice_branch.py on nodes; on the fitted mesh
refined_branch.py and one_contact.py, which share fitted_branch.py, and, without surface tension,
springs.py. Then: equilibrium with a load or a machine (control.py) -> states and events
(load_path.py) -> History, its energy balance (history.py).
"""
