"""Entries of everybody's, each driven or judged again here before it stands in a table."""
