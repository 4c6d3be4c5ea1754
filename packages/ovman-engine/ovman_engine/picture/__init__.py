"""What cameras see of a world."""
