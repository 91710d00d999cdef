"""Reference solutions where there is no closed form, independent of the minimisers.

They know the scene and nothing of `discretization`. Slow, and meant to be obviously right:

ground.py       the profile with fine nodes; where a line rests on its way, and a surface touches
surfaces.py     free surfaces of small and finite slopes, and what holds a line
walk.py         the adhered state: a quasi-static walk in depth from first touch
obstacle.py     w = 0: the only state, as a hull; γ₁ = 0: every spring by itself
sets.py         the state of least energy, by a dynamic programme over contact nodes
totals.py       lines polished by Newton's method, force and energy

meniscus.py     rotational symmetry with finite slopes: Young-Laplace, integrated from far away

paths/         depth paths that may turn, and what happens under a dead load or a machine:
  depth_paths.py  depth paths that may turn, from any place of theirs
  controls.py     what happens under a dead load or a machine, read off a depth path

random_states.py draws random scenes and random_paths.py random load paths; compare.py says what
`minimise` makes of the ones and path_compare.py what `load_path` makes of the others, and

    python -m tests.truth CLASS N SEED

counts; with N = 1 it prints the scene, the reference and the answer.
"""
