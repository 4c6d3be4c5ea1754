"""The grid of reachable cells, shortest paths on it, and the navigator that follows them with primitives."""
