"""The tool `fit`: surface energies from a measured curve."""
