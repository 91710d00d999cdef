"""What studies share; here the quantities that have an error estimate."""

QUANTITIES = ("half_width", "force", "energy")
