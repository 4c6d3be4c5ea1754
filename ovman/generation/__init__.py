"""Algorithm 1: scenes, candidates, trials, admissible, certified, episodes, and the audit of what was rejected."""
