"""The study `contact_angle`: whether Young's law emerges."""
