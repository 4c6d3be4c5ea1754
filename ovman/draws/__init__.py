"""Fresh homes with certified episodes, drawn from a seed outside the workflow (docs/draws.md)."""


class DrawError(ValueError):
    """A draw, a commitment or a beacon's value that cannot be used; one line with place and remedy."""
