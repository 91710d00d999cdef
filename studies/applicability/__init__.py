"""The study `applicability`: where Eq. (16) holds."""
