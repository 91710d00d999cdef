"""Contact lines on the fitted mesh that follow the depth, from event to event.

The lines of a contact that stays alone are solved for one by one, where no corner holds them
(lone.py). Others that move smoothly are found at many depths at once, and kept as polynomials on
the way (smooth.py). Where that fails something happens to them: the depth of that is enclosed
(trials.py), and what the lines do there is that of a state of ../fitted (events.py).
"""
