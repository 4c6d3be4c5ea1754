"""AI2-THOR's side of the engine: its protocol, its metadata, its settings."""
