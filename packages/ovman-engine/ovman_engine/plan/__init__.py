"""Scenes before anything happens in them: recorded floor plans, and houses given as JSON."""
