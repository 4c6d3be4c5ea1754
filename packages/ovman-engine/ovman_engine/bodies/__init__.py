"""What can be moved, stood on, carried or bumped into, and the agent among it."""
