"""The tool `sweep`: a function over a grid of parameters."""
