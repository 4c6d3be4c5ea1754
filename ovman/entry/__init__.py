"""What somebody else's agent comes in by: the score of a file of predictions, without the workflow."""
