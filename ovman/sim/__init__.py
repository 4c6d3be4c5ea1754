"""A session on AI2-THOR's own Controller: primitives, world changes, tours, the mover, measurements."""
