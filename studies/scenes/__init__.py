"""Scene files, and what is done with them: `new`, `run`, `sweep` and `fit`."""
