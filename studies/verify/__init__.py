"""The study `verify`: every numbered equation of the paper, from the energy."""
