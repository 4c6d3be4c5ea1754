"""Systems as their authors released them, run unmodified in processes and environments of their own."""
