"""There."""
