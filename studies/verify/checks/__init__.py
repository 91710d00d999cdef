"""Every numbered equation of the paper as a check: what is measured, what it should be.

| file | equations | subject |
| --- | --- | --- |
| layer | 1, 2, 3, 7, 17 | layer and surfaces |
| tail | 4, 5, 6 | surface in contact and outside |
| force | 9, 10, 11 | force on the indenter |
| contact_line | 8, 12-16, 18, 34, 35 | contact angle, place of the line |
| flat | 19-23 | plane and flat punch |
| wedge | 24-30 | wedge |
| parabola | 31-33 | parabola |
| nonadhesive | 36-40 | w = 0 |
| beyond | none | what the paper leaves open |
| bonded | none | the layer with its exact response |
| axisymmetric | none | spheres, cones, cylinders and power laws, turned about their axis |

convergence.py is the engine, mesh.py the two discretisations, scenes.py the scenes, observe.py how
a field or a branch is measured. A new check is a function Mesh -> Comparison, or a generator of
several, with the decorator `check(number, what=...)`; it is run on lattices and on the fitted mesh.
"""

from importlib import import_module

from studies.verify.convergence import Check

_FILES = ("layer", "tail", "force", "contact_line", "flat", "wedge", "parabola", "nonadhesive")
_BEYOND = ("beyond", "axisymmetric", "bonded")
_FOUND = [vars(import_module(f"{__name__}.{file}")).values() for file in (*_FILES, *_BEYOND)]
CHECKS: tuple[Check, ...] = tuple(
    sorted(
        (value for own in _FOUND for value in own if isinstance(value, Check)),
        key=lambda item: item.equations[:1] or (1000,),
    )
)
