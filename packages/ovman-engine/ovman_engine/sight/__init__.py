"""What an agent sees, from where, and how it gets there."""
