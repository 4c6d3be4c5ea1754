"""Recorded sessions: every call of a simulator and every answer, without pictures."""
