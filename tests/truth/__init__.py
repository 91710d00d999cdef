"""Reference solutions for profiles that are not convex, independent of the minimisers.

They know the scene and nothing of `discretization`. Slow, and meant to be obviously right:

ground.py       the profile: fine nodes, one-sided slopes, refined extremes
surfaces.py     free surfaces of small and finite slopes
walk.py         the adhered state: a quasi-static walk in depth from first touch
totals.py       lines polished by Newton's method, force and energy
scenes.py       random scenes of several classes and unit systems
compare.py      what `minimise` says about them; `python -m tests.truth CLASS N SEED` counts
"""
