"""Free surfaces beside contact lines, on spectral meshes anchored at the lines.

They answer the questions of protocol.py: at which depth a line rests beside them, what they store
and pull, their shape. One class answers for each geometry and energy, in units of l and γ₁, on
spectral elements (network.py) whose errors are rounding:

    small slopes   line, axisymmetric  small.py on network.py and rings.py
    finite         line                finite_line.py on finite_gap.py
                   axisymmetric        menisci.py
"""
