"""What a user would pick instead of this package, written as such a user would write it.

Every rival is a function of a `Grid` (problem.py) that does the modelling and returns `solve()`,
which does the solving and returns an `Answer`. Packages that need not be installed are imported by
name; tasks.py says which rival takes part in which task, and how this package answers it.
"""
