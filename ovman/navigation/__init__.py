"""Where the agent can go, how it gets there, and the primitives that take it there."""
