"""As much of it as is asked for."""
