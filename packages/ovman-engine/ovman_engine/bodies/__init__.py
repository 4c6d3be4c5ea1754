"""Bodies: what moves, supports, carries and blocks; the agent among them."""
