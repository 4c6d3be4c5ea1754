"""A world: a floor plan and everything that has changed in it since Reset."""
