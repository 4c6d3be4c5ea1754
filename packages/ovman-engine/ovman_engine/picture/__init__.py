"""Images: what cameras see of a world."""
