"""A floor plan and everything that has changed in it since Reset."""
