"""The reference agent: grounding, association, decision; with two visits or one, with maps or with true positions."""
