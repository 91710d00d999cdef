"""The study `pull_off`: adhesion force against surface tension."""
