"""Plain scripts of a user, each with one figure: start from the one that is nearest to your case.

A script writes its figure to the path given as first argument, by default its own name with .png
in the current folder.
"""
