"""What several test files share: example scenes, random cases, comparisons, files to be read.

example_scenes.py         scenes with parameters that are not 1, and profiles of several contacts
scene_kinds.py            one scene of every kind that a load path can meet
paths_without_adhesion.py random bodies without adhesion, whose load paths are known from a hull
hostile_scenes.py         random scenes over many decades, and what counts as an answer
narrow_features.py        random profiles with features as narrow as the distance of the nodes
arrays_of_states.py       random convex scenes with arrays of states, against `minimise` one by one
card_cases.py             random scenes of the closed forms, and their energies in 50 digits
lattices.py               lattices, and their lowest energies by trying all contact sets
bonded_layers.py          scenes with the exact response of a bonded layer
layer_elements.py         such a layer by finite elements through its thickness
scene_files.py            texts of scene files
measured_curves.py        curves of force against depth as an instrument would record them
sweep_points.py           functions of a point of a sweep, and sweeps that stop midway
comparison.py             how numbers are compared
repository.py             where the repository and its modules are
"""
