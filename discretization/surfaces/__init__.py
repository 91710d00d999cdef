"""Free surfaces beside contact lines, on spectral meshes anchored at the lines.

protocol.py says what is computed of a free surface: the depth at which a line rests beside it, its
energy and pull, its shape. There is one class for each geometry and energy, in units of l and γ₁,
on spectral elements (network.py) whose errors are rounding:

    small slopes   line, axisymmetric  small.py on network.py and rings.py
    finite         line                finite_line.py on finite_gap.py
                   axisymmetric        menisci.py
"""
