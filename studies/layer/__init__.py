"""The study of the layer with its exact response."""
