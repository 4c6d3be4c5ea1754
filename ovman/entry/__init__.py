"""What somebody else's agent comes in by, outside the workflow: the score of its points, and its evaluation on episodes."""
