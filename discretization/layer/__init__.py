"""One contact of a layer with its exact response."""
