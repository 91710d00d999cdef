"""Contacts found on nodes, their lines taken to rest by Newton's method.

Nodes (../lattice) give which contacts there are and in what order events come. The lines of all
free surfaces are then taken to rest together (settle.py), and the depths of events are enclosed,
those of all events of a programme at once (events.py). Lines contacts with small slopes.
"""
