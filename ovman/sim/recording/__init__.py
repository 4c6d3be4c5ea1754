"""Recorded sessions: everything that was asked of a simulator and everything that it answered but pictures."""
