"""Rooms: walls, doors, windows and ceilings of floor plans and of houses."""
