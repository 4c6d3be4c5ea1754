"""Settings and records as frozen pydantic models."""
