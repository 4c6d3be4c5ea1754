"""What stands around the objects: walls, doors, windows, ceilings, of floor plans and of houses."""
