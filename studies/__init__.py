"""Questions asked of the simulator, one module each; the only place with figures and files.

A study is a docstring with the question and the formula, a block of parameters, `run(...)` that
returns numbers, functions that draw them, and `main(argv)` that returns an exit status. Tests call
`run` on a small preset. A new study is such a module, and a line in `studies/__main__.py`.
"""
