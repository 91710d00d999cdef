"""The study `hysteresis`: closed load paths and what they dissipate."""
