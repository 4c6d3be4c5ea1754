"""What a scene is before anything happens in it: the recorded floor plans, and houses given as JSON."""
