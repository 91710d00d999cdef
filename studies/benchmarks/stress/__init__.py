"""The benchmark `stress`: digits kept at the ends of the range of every parameter."""
